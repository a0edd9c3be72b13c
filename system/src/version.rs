//! What this build of goldtof is.
//!
//! ```
//! # mod goldtof {
//! #     pub use goldtof_system::*;
//! # }
//! assert!(goldtof::version::VERSION.starts_with(char::is_numeric));
//! ```

/// Version, and in builds for release the commit that it was made from.
pub const VERSION: &str = concat!(env!("CARGO_PKG_VERSION"), env!("GOLDTOF_COMMIT"));

/// What emitted files say that they were made by, unless their maker says more.
pub const MADE_BY: &str = "goldtof";
