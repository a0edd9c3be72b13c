//! What goes with the Verilog into an FPGA team's flow: a self-checking testbench
//! with its vectors, clock constraints, a file list and a FuseSoC core.

mod constraints;
mod core;
mod file_list;
mod header;
mod registers;
mod run_length;
mod stimulus;
mod testbench;
mod vhdl;

pub use stimulus::adversary as testbench_adversary;
pub(super) use stimulus::{Recording, record};

use serde::Serialize;

pub use self::constraints::Constraints;
pub use self::registers::RegisterFiles;
pub use self::testbench::Testbench;
use super::design::{EmittedDesign, EmittedFile};
use super::formal::Formal;

/// Files round the design, by role. In JSON a file is its name.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct Flow {
    /// The testbench that compares every output port at every clock.
    pub testbench: Testbench,
    /// The clock, in the languages of the tools.
    pub constraints: Constraints,
    /// The widths of the ports as macros, for Verilog round the design.
    pub header: EmittedFile,
    /// The top module as a component, for VHDL round the design.
    pub vhdl: EmittedFile,
    /// The design's files, for `-f` of simulators and linters.
    pub file_list: EmittedFile,
    /// FuseSoC core description (CAPI2).
    pub core: EmittedFile,
    /// The registers, if the design has any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub registers: Option<RegisterFiles>,
}

impl Flow {
    /// All that goes with a design whose testbench has a recorded run.
    pub(super) fn of(design: &EmittedDesign, formal: &Formal, recording: Recording) -> Flow {
        let testbench = testbench::testbench(design, recording);
        let constraints = constraints::constraints(design);
        let header = header::header(design);
        let file_list = file_list::file_list(design);
        let parts = core::CoreFiles {
            header: &header,
            testbench: &testbench,
            constraints: &constraints,
            formal,
        };
        let core = core::core(design, &parts);
        Flow {
            testbench,
            constraints,
            header,
            vhdl: vhdl::package(design),
            file_list,
            core,
            registers: RegisterFiles::of(design),
        }
    }

    /// Every file, in no order that matters.
    pub fn files(&self) -> impl Iterator<Item = &EmittedFile> {
        let constraints = &self.constraints;
        self.testbench
            .files
            .iter()
            .chain(&self.testbench.vectors)
            .chain([&constraints.sdc, &constraints.lpf, &constraints.xdc])
            .chain([&self.header, &self.vhdl, &self.file_list])
            .chain([&self.testbench.file_list, &self.core])
            .chain(self.registers.iter().flat_map(RegisterFiles::files))
    }
}
