//! What a module is and how it is used, before it is printed.

use super::module::Module;

/// A constant of a module, or of one below it.
#[derive(Debug, Clone)]
pub struct Parameter {
    /// Name in this module; after the instance's name if it is handed on.
    pub name: String,
    /// Bits.
    pub width: u32,
    /// Description.
    pub about: String,
    /// Heading over it.
    pub heading: Option<String>,
    /// Value in each instance of the module, in the order of the design.
    pub values: Vec<u128>,
    /// Whether it belongs to a module below.
    pub is_handed_on: bool,
}

impl Parameter {
    /// What stands beside it in the module's list of parameters.
    pub fn said(&self) -> String {
        let parts = [self.heading.as_deref().unwrap_or(""), &self.about];
        let parts = parts.into_iter().filter(|part| !part.is_empty());
        parts.collect::<Vec<_>>().join("; ")
    }

    /// Whether instances differ in it.
    pub fn varies(&self) -> bool {
        self.values.iter().any(|v| *v != self.values[0])
    }
}

/// A module and how it is used.
#[derive(Debug)]
pub struct ModuleType {
    /// The module.
    pub module: Module,
    /// Its name, made unique.
    pub name: String,
    /// Its own constants, then those of its instances.
    pub parameters: Vec<Parameter>,
    /// For each instance in it: the module, and where its parameters begin in
    /// `parameters`.
    pub children: Vec<(usize, usize)>,
    /// What makes it the module that it is, apart from constants.
    pub(super) key: String,
}
