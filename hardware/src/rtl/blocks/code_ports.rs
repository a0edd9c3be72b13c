//! What every source of chips has in common: its ports.

use crate::rtl::front::prelude::*;

/// Ports of a source of chips.
#[derive(Debug, Clone)]
pub struct CodePorts {
    /// Go on to the next chip.
    pub i_advance: Input<bool>,
    /// Start again from the chip that reset gives; wins over `i_advance`.
    pub i_load: Optional<Input<bool>>,
    /// The present chip.
    pub o_chip: Output<bool>,
    /// Whether the present chip is the one that reset gives.
    pub o_epoch: Output<bool>,
}

impl CodePorts {
    /// Ports, with `i_load` if `reloads`.
    pub fn new(reloads: bool) -> CodePorts {
        CodePorts {
            i_advance: Input::bit("go on to the next chip"),
            i_load: Optional::new(
                reloads,
                Input::bit("start again as after reset; wins over i_advance"),
            ),
            o_chip: Output::bit("present chip"),
            o_epoch: Output::bit("the present chip is the one that reset gives"),
        }
    }
}

impl Logic for CodePorts {
    fn update(&mut self) {}
}

impl Block for CodePorts {
    fn connect_all(&mut self) {
        self.o_chip.connect();
        self.o_epoch.connect();
    }

    fn update_all(&mut self) {
        self.i_advance.update_all();
        self.i_load.update_all();
        self.o_chip.update_all();
        self.o_epoch.update_all();
    }

    fn has_changed(&self) -> bool {
        self.i_advance.has_changed()
            || self.i_load.has_changed()
            || self.o_chip.has_changed()
            || self.o_epoch.has_changed()
    }

    fn accept(&self, name: &str, probe: &mut dyn probe::Probe) {
        probe.visit_start_namespace(name, self);
        self.i_advance.accept("i_advance", probe);
        self.i_load.accept("i_load", probe);
        self.o_chip.accept("o_chip", probe);
        self.o_epoch.accept("o_epoch", probe);
        probe.visit_end_namespace(name, self);
    }
}
