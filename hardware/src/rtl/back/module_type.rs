//! What a module is and how it is used, before it is printed.

use super::module::VerilogModule;
use super::sheet::Sheet;
use crate::rtl::front::Size;

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
    /// Whether it is a number, and not a pattern of bits.
    pub is_number: bool,
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

    /// Its value in one of the instances, as Verilog.
    pub fn literal(&self, instance: usize) -> String {
        let Parameter { width, is_number, .. } = *self;
        let value = self.values[instance];
        match is_number {
            true => format!("{width}'d{value}"),
            false if width == 1 => format!("1'b{value}"),
            false => format!("{width}'h{value:0digits$x}", digits = width.div_ceil(4) as usize),
        }
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
    pub module: VerilogModule,
    /// Its text, if that is given.
    pub given: Option<&'static str>,
    /// What a given module holds at power-up: a parameter, as Verilog.
    pub contents: Option<(String, String)>,
    /// How it is printed.
    pub sheet: Sheet,
    /// Its name, made unique.
    pub name: String,
    /// Its own constants, then those of its instances.
    pub parameters: Vec<Parameter>,
    /// For each instance in it: the module, and where its parameters begin in
    /// `parameters`.
    pub children: Vec<(usize, usize)>,
    /// Instances that are printed together.
    pub families: Vec<Vec<usize>>,
    /// What instances may differ in, as the first has it.
    pub sizes: Vec<Size>,
    /// Sizes of each kind of instance, and how it would be printed alone.
    pub(super) variants: Vec<(Vec<u32>, Sheet)>,
    /// What makes it the module that it is, apart from sizes and constants.
    pub(super) key: String,
}

impl ModuleType {
    /// The sizes that instances differ in.
    pub fn varying_sizes(&self) -> Vec<&Size> {
        let varies = |index: usize| {
            self.variants.iter().any(|(sizes, _)| sizes[index] != self.variants[0].0[index])
        };
        (0..self.sizes.len()).filter(|i| varies(*i)).map(|i| &self.sizes[i]).collect()
    }
}
