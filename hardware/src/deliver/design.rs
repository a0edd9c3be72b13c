//! A design, as what goes with it sees it.

use serde::Serialize;

use crate::rtl::back::Prefix;
use crate::sensor::Sensor;
use crate::sensor::interface::Interface;

/// Name of the top module, without a prefix; the files round the design begin with it.
pub const TOP: &str = "sensor_top";

/// A design for which more is written.
pub(super) struct EmittedDesign<'a> {
    pub(super) sensor: &'a Sensor,
    /// One file for each module, the top module's last.
    pub(super) files: &'a [EmittedFile],
    /// What the modules' names begin with.
    pub(super) prefix: &'a Prefix,
    /// What stands in every file's header.
    pub(super) made_by: &'a str,
}

impl EmittedDesign<'_> {
    /// The name of the top module.
    pub(super) fn top(&self) -> String {
        self.prefix.of(TOP)
    }

    /// The name of a file that goes with the design.
    pub(super) fn file_name(&self, ending: &str) -> String {
        format!("{}{ending}", self.top())
    }

    /// What the design has to keep.
    pub(super) fn interface(&self) -> &Interface {
        self.sensor.interface()
    }
}

/// A file that `emit` writes. In JSON it is its name.
#[derive(Debug, Clone, PartialEq, Eq, schemars::JsonSchema)]
#[schemars(with = "String")]
pub struct EmittedFile {
    /// File name.
    pub name: String,
    /// Contents.
    pub text: String,
}

impl Serialize for EmittedFile {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(&self.name)
    }
}
