//! What goes with the Verilog into an FPGA team's flow: a self-checking testbench
//! with its vectors, clock constraints, a file list and a FuseSoC core.

mod constraints;
mod core;
mod header;
mod run_length;
mod stimulus;
mod testbench;

use serde::Serialize;

use super::emission::EmittedFile;
use super::error::HdlError;
use super::formal::Formal;
use crate::reference::cover_report::Coverage;
use crate::sensor::Sensor;
use crate::sensor::interface::Interface;

/// Files round the design, by role. In JSON a file is its name.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Flow {
    /// The testbench that compares every output port at every clock.
    pub testbench: Testbench,
    /// The clock, in the languages of the tools.
    pub constraints: Constraints,
    /// The widths of the ports as macros, for Verilog round the design.
    pub header: EmittedFile,
    /// The design's files, for `-f` of simulators and linters.
    pub file_list: EmittedFile,
    /// FuseSoC core description (CAPI2).
    pub core: EmittedFile,
}

/// The testbench and how much it covers.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Testbench {
    /// Its top module.
    pub top: &'static str,
    /// Its Verilog.
    pub files: Vec<EmittedFile>,
    /// The design's files and the testbench's, for `-f`.
    pub file_list: EmittedFile,
    /// What its Verilog reads at run time, from the folder it runs in.
    pub vectors: Vec<EmittedFile>,
    /// Clocks that it runs and compares.
    pub clocks: u64,
    /// Phase steps whose integration ends within these clocks.
    pub phase_steps: u64,
    /// Scans whose last phase step ends within these clocks.
    pub scans: u64,
    /// Hits that count up in the results that come to the stream, each once for
    /// every phase step that sees it.
    pub hits_up: u64,
    /// Hits that count down.
    pub hits_down: u64,
    /// How much of what the sensor can be made to do it covers.
    pub coverage: Coverage,
}

/// Clock constraints.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Constraints {
    /// Synopsys Design Constraints.
    pub sdc: EmittedFile,
    /// Lattice preference file, as nextpnr-ecp5 reads it.
    pub lpf: EmittedFile,
    /// Xilinx Design Constraints.
    pub xdc: EmittedFile,
}

impl Flow {
    /// All that goes with the design `files` of a scene.
    ///
    /// `made_by` stands in every file's header.
    ///
    /// # Errors
    /// When the reference model cannot predict the ports of this interface.
    pub(super) fn of(
        sensor: &Sensor,
        interface: &Interface,
        files: &[EmittedFile],
        formal: &Formal,
        made_by: &str,
    ) -> Result<Flow, HdlError> {
        let detectors = sensor.scene().detectors.iter();
        let names: Vec<String> = detectors.map(|detector| detector.name.clone()).collect();
        let testbench = testbench::testbench(interface, &names, files, made_by)?;
        let constraints = constraints::constraints(sensor.clock().chip_period_ps, made_by);
        let header = header::header(interface, made_by);
        let file_list = core::file_list(files, made_by);
        let parts = core::Parts {
            header: &header,
            testbench: &testbench,
            constraints: &constraints,
            formal,
        };
        let core = core::core(sensor, files, &parts, made_by);
        Ok(Flow {
            testbench,
            constraints,
            header,
            file_list,
            core,
        })
    }

    /// Every file, in no order that matters.
    pub fn files(&self) -> impl Iterator<Item = &EmittedFile> {
        let constraints = &self.constraints;
        self.testbench
            .files
            .iter()
            .chain(&self.testbench.vectors)
            .chain([&constraints.sdc, &constraints.lpf, &constraints.xdc])
            .chain([&self.header, &self.file_list])
            .chain([&self.testbench.file_list, &self.core])
    }
}
