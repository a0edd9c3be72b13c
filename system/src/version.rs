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
