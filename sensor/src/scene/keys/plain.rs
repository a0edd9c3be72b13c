//! Values that a key has as they are written.

use super::{Key, Kind};
use crate::scene::reader::Section;

/// A field of a scene that is what its key says.
pub(in crate::scene) trait Plain: Sized {
    /// The key's value, or its default; `None` if it has neither, or is wrong, which is reported.
    fn read(section: &Section, name: &'static str) -> Option<Self>;

    /// The value of a key that is left out.
    fn left_out(key: &Key) -> Self;
}

impl Plain for f64 {
    fn read(section: &Section, name: &'static str) -> Option<f64> {
        match section.key(name).kind {
            Kind::Quantity { .. } => section.quantity(name),
            _ => section.number(name),
        }
    }

    fn left_out(key: &Key) -> f64 {
        key.default_number().unwrap_or_default()
    }
}

impl Plain for u32 {
    fn read(section: &Section, name: &'static str) -> Option<u32> {
        section.count(name)
    }

    fn left_out(key: &Key) -> u32 {
        key.default().and_then(|text| text.parse().ok()).unwrap_or_default()
    }
}

impl Plain for bool {
    fn read(section: &Section, name: &'static str) -> Option<bool> {
        section.boolean(name)
    }

    fn left_out(key: &Key) -> bool {
        key.default() == Some("true")
    }
}

/// A key that may be left out, and stands for something else then.
impl<T: Plain> Plain for Option<T> {
    fn read(section: &Section, name: &'static str) -> Option<Option<T>> {
        Some(T::read(section, name))
    }

    fn left_out(_: &Key) -> Option<T> {
        None
    }
}
