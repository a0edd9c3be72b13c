//! What a block tells the back end beside its kernel.
//!
//! rust-hdl asks every block for its Verilog ([`Logic::hdl`]), and its trees have no place
//! for a register's comment or a module that is written by hand. A block that is more than a kernel leaves a
//! [`Marker`] when it is asked, and [`told_by`], which asks, takes it: plain data all the way.

use std::cell::Cell;
use std::fmt;
use std::ops::RangeInclusive;
use std::sync::Arc;

use rust_hdl_core::ast::Verilog;
use rust_hdl_core::block::Block;
use rust_hdl_core::logic::Logic;
use rust_hdl_core::probe::Probe;

thread_local! {
    /// What the block left that was asked last.
    static LEFT: Cell<Option<Marker>> = const { Cell::new(None) };
}

/// What a block is, where that is not a kernel.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Marker {
    /// The scope is the description of the block that holds it, and its sizes.
    About(Description, Vec<Size>),
    /// The scope is a register with pins `d` and `q`.
    Register {
        /// Name in the Verilog, in place of the field's.
        name: Option<String>,
        /// Value after reset.
        reset_value: u128,
        /// Constant of the block that holds this value.
        reset_constant: Option<String>,
        /// What it holds.
        about: String,
    },
    /// The scope is a table of single bits with pins `address` and `data`.
    BitTable {
        /// Entry 0 first, each 0 or 1.
        bits: Vec<u8>,
        /// What it holds.
        about: String,
    },
    /// The scope is an instance of a module that is given as text and has a clock.
    Given {
        /// Its module.
        module: &'static str,
        /// The module's file.
        text: &'static str,
        /// Parameters of the instance.
        sizes: Vec<(String, u32)>,
        /// Whether it has a reset, too.
        sees_reset: bool,
        /// The parameter with what it holds at power-up, as Verilog; of all instances the same.
        contents: Option<(String, String)>,
        /// What it is.
        about: String,
    },
}

/// A module's name and header.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Description {
    /// Module name.
    pub module: String,
    /// One line: what the module is.
    pub title: String,
    /// Paragraphs: how it works and why.
    pub notes: Vec<String>,
    /// Labelled facts: polynomial, latency, rate.
    pub facts: Vec<(String, String)>,
    /// What simulation checks before it begins.
    pub checks: Vec<StateCheck>,
}

/// A width or a count that instances of a block may differ in. A module that some do is
/// written once, with a parameter.
#[derive(Clone)]
pub struct Size {
    /// Its name: the parameter's.
    pub name: String,
    /// What it is.
    pub about: String,
    /// Of this block.
    pub value: u32,
    /// Which of them the same circuit serves.
    pub takes: RangeInclusive<u32>,
    of_size: Arc<OfSize>,
}

/// The same block of another size.
type OfSize = dyn Fn(u32) -> Box<dyn Block> + Send + Sync;

impl Size {
    /// The same block of another size.
    pub fn of_size(&self, value: u32) -> Box<dyn Block> {
        (self.of_size)(value)
    }
}

impl fmt::Debug for Size {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} of {:?}", self.name, self.takes)
    }
}

impl PartialEq for Size {
    fn eq(&self, other: &Size) -> bool {
        (&self.name, self.value, &self.takes) == (&other.name, other.value, &other.takes)
    }
}

impl Eq for Size {}

/// A state of an LFSR that has to follow from another; both, and the taps, are
/// constants of the block.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StateCheck {
    /// The bits of the state whose XOR comes in at the top.
    pub taps: String,
    /// The state before the shifts.
    pub first: String,
    /// How many shifts.
    pub shifts: u64,
    /// The state after them.
    pub last: String,
}

impl Marker {
    /// The answer of a block that is this.
    pub(super) fn into_hdl(self) -> Verilog {
        LEFT.set(Some(self));
        Verilog::Empty
    }
}

/// Asks a block what it is: its kernel, and the marker that it left.
pub fn told_by(block: &dyn Block) -> (Verilog, Option<Marker>) {
    LEFT.set(None);
    let kernel = block.hdl();
    (kernel, LEFT.take())
}

/// Names and describes the block that has it as a field.
#[derive(Debug, Clone)]
pub struct About(Description, Vec<Size>);

impl About {
    /// A module `module` that is what `title` says.
    pub fn new(module: &str, title: impl Into<String>) -> About {
        let (module, title) = (module.to_owned(), title.into());
        let description = Description { module, title, ..Description::default() };
        About(description, Vec::new())
    }

    /// Adds a size that is `value`: the circuit is the same for each that it `takes`, and
    /// `of_size` makes it.
    pub fn size<B: Block + 'static>(
        mut self,
        (name, about): (&str, &str),
        value: usize,
        takes: RangeInclusive<usize>,
        of_size: impl Fn(usize) -> B + Send + Sync + 'static,
    ) -> About {
        self.1.push(Size {
            name: name.to_owned(),
            about: about.to_owned(),
            value: value as u32,
            takes: *takes.start() as u32..=*takes.end() as u32,
            of_size: Arc::new(move |value| Box::new(of_size(value as usize))),
        });
        self
    }

    /// Adds a paragraph on how it works and why.
    pub fn note(mut self, text: impl Into<String>) -> About {
        self.0.notes.push(text.into());
        self
    }

    /// Adds a paragraph where it holds.
    pub fn note_if(self, holds: bool, text: impl Into<String>) -> About {
        if holds { self.note(text) } else { self }
    }

    /// Adds a labelled fact.
    pub fn fact(mut self, label: &str, text: impl Into<String>) -> About {
        self.0.facts.push((label.to_owned(), text.into()));
        self
    }

    /// Adds a labelled fact where it holds.
    pub fn fact_if(self, holds: bool, label: &str, text: impl Into<String>) -> About {
        if holds { self.fact(label, text) } else { self }
    }

    /// Adds checks of constants.
    pub fn checks(mut self, checks: impl IntoIterator<Item = StateCheck>) -> About {
        self.0.checks.extend(checks);
        self
    }
}

impl Logic for About {
    fn update(&mut self) {}

    fn hdl(&self) -> Verilog {
        Marker::About(self.0.clone(), self.1.clone()).into_hdl()
    }
}

impl Block for About {
    fn connect_all(&mut self) {}
    fn update_all(&mut self) {}

    fn has_changed(&self) -> bool {
        false
    }

    fn accept(&self, name: &str, probe: &mut dyn Probe) {
        probe.visit_start_scope(name, self);
        probe.visit_end_scope(name, self);
    }
}
