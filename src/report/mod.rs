//! What people read: plots and the report page.

pub mod plot;
