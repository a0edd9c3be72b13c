//! Declares keys: a table of them, the struct that they are read into, the values of a choice.

pub(super) use super::keys::{
    Absent::{Needed, Or, Otherwise},
    BOOLEAN, Form, Key, KeyKind, KeyTable, choice, integer, names, number, quantity, ratio, table,
    words,
};
pub(super) use super::reader::Section;
pub(super) use super::units::Quantity::{self, *};

/// Declares tables, each key of them once: `key = kind, when left out, example; "meaning" "why
/// these bounds";`. Of a table that is a struct, `key => field: type = ...` is a field, which is
/// read as it is written, and in braces stand the fields that other keys decide.
macro_rules! tables {
    () => {};
    (
        $(#[$about:meta])*
        $vis:vis struct $Struct:ident { $($(#[$doc:meta])* $other:ident: $other_type:ty,)* }
        of $name:ident = $path:literal $(and $shared:ident)* {
            $($key:ident $(=> $field:ident: $type:ty)? = $kind:expr, $absent:expr, $example:literal;
              $meaning:literal $($why:literal)?;)*
        }
        $($rest:tt)*
    ) => {
        $(#[$about])*
        $vis struct $Struct {
            $($(#[doc = $meaning] pub $field: $type,)?)*
            $($(#[$doc])* pub $other: $other_type,)*
        }

        impl $Struct {
            /// The keys that are fields, as they are read, beside defaults; what is wrong with
            /// them is reported.
            fn keys(section: &Section) -> Option<$Struct> {
                $($(let $field = <$type as Plain>::read(section, stringify!($key));)?)*
                Some($Struct {
                    $($($field: $field?,)?)*
                    $($other: Default::default(),)*
                })
            }
        }

        impl Default for $Struct {
            /// Of an empty table.
            fn default() -> $Struct {
                $Struct {
                    $($($field: <$type as Plain>::left_out($name.key(stringify!($key))),)?)*
                    $($other: Default::default(),)*
                }
            }
        }

        tables! {
            $name = $path $(and $shared)* {
                $($key = $kind, $absent, $example; $meaning $($why)?;)*
            }
            $($rest)*
        }
    };
    (
        $name:ident = $path:literal $(and $shared:ident)* {
            $($key:ident = $kind:expr, $absent:expr, $example:literal; $meaning:literal $($why:literal)?;)*
        }
        $($rest:tt)*
    ) => {
        pub(in crate::scene) static $name: KeyTable = KeyTable::new(
            $path,
            &[$(Key {
                name: stringify!($key),
                kind: $kind,
                absent: $absent,
                example: $example,
                meaning: $meaning,
                why: concat!("", $($why)?),
            },)*],
            &[$(&$shared),*],
        );

        tables! { $($rest)* }
    };
}

/// Declares the values of a key, each with the name that scenes use.
macro_rules! choices {
    (
        $(#[$about:meta])*
        pub enum $Enum:ident { $($(#[$doc:meta])* $Value:ident = $name:literal,)* }
    ) => {
        $(#[$about])*
        pub enum $Enum { $($(#[$doc])* $Value,)* }

        impl $Enum {
            const CHOICES: &'static [&'static str] = &[$($name),*];

            /// Each of them, under the name that scenes use.
            pub const NAMES: &'static [(&'static str, $Enum)] = &[$(($name, $Enum::$Value)),*];
        }

        impl Plain for $Enum {
            fn read(section: &Section, name: &'static str) -> Option<$Enum> {
                section.choice(name, $Enum::NAMES)
            }

            fn left_out(key: &Key) -> $Enum {
                let is_default = |(name, _): &&(&str, $Enum)| key.default() == Some(*name);
                $Enum::NAMES.iter().find(is_default).unwrap_or(&$Enum::NAMES[0]).1
            }
        }
    };
}

pub(super) use {choices, tables};

/// A field of a scene that is what its key says.
pub(super) trait Plain: Sized {
    /// The key's value, or its default; `None` if it has neither, or is wrong, which is reported.
    fn read(section: &Section, name: &'static str) -> Option<Self>;

    /// The value of a key that is left out.
    fn left_out(key: &Key) -> Self;
}

impl Plain for f64 {
    fn read(section: &Section, name: &'static str) -> Option<f64> {
        match section.key(name).kind {
            KeyKind::Quantity { .. } => section.quantity(name),
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
