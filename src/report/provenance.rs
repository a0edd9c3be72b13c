//! Where a report comes from.

/// Where a report comes from.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Provenance {
    /// Version of goldtof, with its commit where that is known.
    pub version: String,
    /// The command as it was typed.
    pub command: String,
    /// When, in UTC.
    pub date: String,
    /// Whether the report is to be the same, byte for byte, when it is made again
    /// (`SOURCE_DATE_EPOCH`): nothing that a clock on the wall says is in it then.
    pub reproducible: bool,
    /// The scene file.
    pub scene_text: String,
}
