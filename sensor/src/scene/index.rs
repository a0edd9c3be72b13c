//! Which source, detector or path of a scene is meant: three types, so that one is not
//! taken for another.

use std::fmt;
use std::ops::{Index, IndexMut};

macro_rules! indices {
    ($($(#[$about:meta])* $name:ident;)*) => {$(
        $(#[$about])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
        #[serde(transparent)]
        pub struct $name(pub usize);

        impl $name {
            /// The first `count`, in order.
            pub fn first(count: usize) -> impl DoubleEndedIterator<Item = $name> + ExactSizeIterator {
                (0..count).map($name)
            }

            /// All there could be, in order: to number a list with one for each.
            pub fn all() -> impl Iterator<Item = $name> {
                (0..).map($name)
            }

            /// One for each of `things`, which are in the scene's order.
            pub fn of<T>(things: &[T]) -> impl DoubleEndedIterator<Item = $name> + ExactSizeIterator + use<T> {
                $name::first(things.len())
            }
        }

        impl fmt::Display for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                self.0.fmt(f)
            }
        }

        impl<T> Index<$name> for [T] {
            type Output = T;

            fn index(&self, index: $name) -> &T {
                &self[index.0]
            }
        }

        impl<T> IndexMut<$name> for [T] {
            fn index_mut(&mut self, index: $name) -> &mut T {
                &mut self[index.0]
            }
        }

        impl<T> Index<$name> for Vec<T> {
            type Output = T;

            fn index(&self, index: $name) -> &T {
                &self[index.0]
            }
        }

        impl<T> IndexMut<$name> for Vec<T> {
            fn index_mut(&mut self, index: $name) -> &mut T {
                &mut self[index.0]
            }
        }
    )*};
}

indices! {
    /// Place of a source in a scene, and of what belongs to it in a list with one for each.
    SourceIndex;
    /// Place of a detector in a scene, and of what belongs to it in a list with one for each.
    DetectorIndex;
    /// Place of a path in a scene, and of what belongs to it in a list with one for each.
    PathIndex;
}
