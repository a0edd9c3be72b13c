//! A scene's hardware as Verilog files and what goes with them.

use std::thread;

use rust_hdl_core::block::Block;
use serde::Serialize;

use super::board::BoardProject;
use super::design::{EmittedDesign, EmittedFile, TOP};
use super::error::HdlError;
use super::flow::{Flow, record};
use super::formal::Formal;
use super::limits::check_limits;
use crate::document::{Body, Document};
use crate::parts::{Part, parts_left_out};
use crate::printable::printable_ascii;
use crate::rtl::back::{ModuleNetlist, ModuleText, Prefix, verilog_of};
use crate::rtl::blocks::{HistogramTop, ScanRegisters, SensorTop};
use crate::scene::SceneReference;
use crate::sensor::Sensor;
use crate::sensor::block_ram::block_ram;
use crate::sensor::interface::Counting;
use crate::sensor::port::Port;

/// Everything that `emit` makes.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct Emission {
    /// The scene.
    #[serde(skip)]
    pub scene: SceneReference,
    /// The command that made it.
    #[serde(skip)]
    pub command: String,
    /// Name of the top module: [`TOP`] after the prefix.
    pub top: String,
    /// One file for each module, the top module's last.
    pub files: Vec<EmittedFile>,
    /// The modules in them, and how they are connected.
    #[serde(skip)]
    pub netlists: Vec<ModuleNetlist>,
    /// Ports of the top module, in the order of the Verilog.
    pub ports: Vec<Port>,
    /// One clock cycle is one chip.
    pub clock_hz: f64,
    /// Parts that this scene does without.
    pub left_out: Vec<LeftOut>,
    /// From the clock at which a step's last sample word is on `i_samples` to
    /// the one after which `m_axis_tvalid` shows its count.
    pub result_latency_clocks: u32,
    /// What the hardware was built for.
    pub parameters: BuildParameters,
    /// The scan's counters, which simulations may move on to shorten steps and scans.
    pub scan_registers: ScanRegisters,
    /// What goes with the design: testbench, constraints, file list, core.
    #[serde(flatten)]
    pub flow: Flow,
    /// Proofs, in a folder of their own.
    pub formal: Formal,
    /// The project of a board, in a folder of its own, if one was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub board: Option<BoardProject>,
}

impl Emission {
    /// The document of `goldtof emit`, which is the manifest.
    pub fn document(&self) -> Document<&Emission> {
        Document {
            scene: Some(self.scene.clone()),
            ..Document::new(self, self.command.clone(), None)
        }
    }
}

impl Body for Emission {
    const NAME: &'static str = "emit";
}

/// A part that a scene does without.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, schemars::JsonSchema)]
pub struct LeftOut {
    /// The part.
    pub part: String,
    /// Why it is not needed.
    pub reason: String,
}

/// What the hardware was built for.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, schemars::JsonSchema)]
#[schemars(rename = "Parameters")]
pub struct BuildParameters {
    /// Light sources.
    pub sources: usize,
    /// Detectors.
    pub detectors: usize,
    /// Samples per chip, S.
    pub samples_per_chip: u32,
    /// Chips of the reference's code period, L'.
    pub code_period_chips: u64,
    /// Phase steps per code period, K.
    pub phase_steps_per_period: u64,
    /// First phase step of a scan.
    pub first_phase_step: u64,
    /// Phase steps of a scan.
    pub phase_steps: u64,
    /// Chips per phase step, D.
    pub integration_chips: u64,
    /// Whether a scan waits for the code's epoch.
    pub realigns: bool,
    /// Phase steps correlated at once.
    pub parallel: u32,
    /// Bits of a count.
    pub count_bits: u32,
    /// Bits of a count that nothing can overflow.
    pub exact_count_bits: u32,
    /// The total counts in `m_axis_tdata`, if they are sent.
    pub total_count: Option<TotalParameters>,
    /// The peak detector's ports, if it has one.
    pub peak: Option<PeakParameters>,
    /// The histogram, of hardware that keeps one; then `count_bits` are a bin's.
    pub histogram: Option<HistogramParameters>,
}

/// What the rows of a histogram hold: bin s in bits s b .. (s + 1) b of `m_axis_tdata`,
/// b bits wide, sample 0 of the chip lowest. A frame's rows come detector by detector, from
/// the first chip of the code period on.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, schemars::JsonSchema)]
pub struct HistogramParameters {
    /// Rows of a detector: chips of the code period, L'.
    pub rows: u64,
    /// Bins of a row: samples per chip, S.
    pub row_bins: u32,
    /// Bits that a bin takes in a row: whole bytes, above its own bits zeros.
    pub bin_data_bits: u32,
    /// Code periods of a frame.
    pub periods: u64,
    /// Neighbouring samples that share an adder: of several hits among them in a word the
    /// earliest counts.
    pub adder_samples: u32,
    /// Histograms that each detector has memory for: two take turns, or there is one.
    pub buffers: u32,
    /// Bits of memory, of all detectors.
    pub memory_bits: u64,
    /// Blocks of the target's block RAM that they take.
    pub block_ram_blocks: u64,
}

/// Where `m_axis_tdata` has a phase step's total count: the hits up and down
/// together. The signed count lies below it, in whole bytes.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, schemars::JsonSchema)]
pub struct TotalParameters {
    /// Its lowest bit.
    pub first_bit: u32,
    /// Its bits, unsigned; zeros fill the last byte.
    pub bits: u32,
    /// Bits of a total that nothing can overflow.
    pub exact_bits: u32,
}

/// What the peak detector's ports hold: detector d's value in bits d b .. (d + 1) b
/// of a port, b bits wide.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, schemars::JsonSchema)]
pub struct PeakParameters {
    /// Bits of a detector's phase step in `o_peak_step`, unsigned.
    pub step_bits: u32,
    /// Bits of a detector's count in `o_peak_count`, signed.
    pub count_bits: u32,
    /// From the clock at which a scan's last sample word is on `i_samples` to
    /// the one after which `o_peak_valid` is high.
    pub latency_clocks: u32,
}

/// Makes the Verilog that `scene` needs. `command` is what the user typed; it
/// stands in every file, in characters that are no more than a comment there.
pub fn emit(sensor: &Sensor, command: &str) -> Result<Emission, HdlError> {
    emit_prefixed(sensor, &Prefix::default(), command)
}

/// [`emit`], with `prefix` before the name of every module, file and macro: designs
/// with different prefixes can be parts of one.
pub fn emit_prefixed(
    sensor: &Sensor,
    prefix: &Prefix,
    command: &str,
) -> Result<Emission, HdlError> {
    let interface = sensor.interface();
    check_limits(sensor, interface)?;
    // The testbench's run takes longer than the design, of which it knows nothing.
    let (made, recording) = thread::scope(|scope| {
        let recording = scope.spawn(|| record(sensor));
        let made = modules(sensor, prefix, command);
        let recording = recording.join();
        (made, recording.unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
    });
    let (files, netlists) = made?;
    let command = printable_ascii(command);
    let made_by = made_by(&command);
    let design = EmittedDesign { sensor, files: &files, prefix, made_by: &made_by };
    let formal = Formal::of(&design);
    let flow = Flow::of(&design, &formal, recording?);
    Ok(Emission {
        scene: sensor.scene().reference(),
        command: command.into_owned(),
        top: prefix.of(TOP),
        files,
        netlists,
        ports: interface.ports(),
        clock_hz: sensor.clock().frequency_hz(),
        left_out: left_out(sensor),
        result_latency_clocks: interface.result_latency_clocks,
        parameters: parameters(sensor),
        scan_registers: ScanRegisters::of(interface).in_design_of(prefix),
        flow,
        formal,
        board: None,
    })
}

/// The modules of the design alone, which [`emit_prefixed`] puts more beside: a testbench
/// takes longer than they do.
///
/// # Errors
/// As there.
pub fn verilog(
    sensor: &Sensor,
    prefix: &Prefix,
    command: &str,
) -> Result<Vec<EmittedFile>, HdlError> {
    check_limits(sensor, sensor.interface())?;
    Ok(modules(sensor, prefix, command)?.0)
}

/// The modules' files, and how they are connected, of what is within the [limits](check_limits).
fn modules(
    sensor: &Sensor,
    prefix: &Prefix,
    command: &str,
) -> Result<(Vec<EmittedFile>, Vec<ModuleNetlist>), HdlError> {
    let interface = sensor.interface();
    let top: Box<dyn Block> = match interface.counting {
        Counting::Correlator(counts) => Box::new(SensorTop::new(interface.clone(), counts)),
        Counting::Histogram(counts) => Box::new(HistogramTop::new(interface.clone(), counts)),
    };
    let modules = verilog_of(&*top, prefix, &made_by(&printable_ascii(command)))?;
    let netlists = modules.iter().filter_map(|module| module.netlist.clone()).collect();
    let file =
        |module: ModuleText| EmittedFile { name: format!("{}.v", module.name), text: module.text };
    Ok((modules.into_iter().map(file).collect(), netlists))
}

/// What files say of their origin.
pub(super) fn made_by(command: &str) -> String {
    format!("{command} (goldtof {})", env!("CARGO_PKG_VERSION"))
}

fn parameters(sensor: &Sensor) -> BuildParameters {
    let interface = sensor.interface();
    let detectors = interface.reference_codes.len();
    BuildParameters {
        sources: interface.source_codes.len(),
        detectors: interface.reference_codes.len(),
        samples_per_chip: interface.lanes(),
        code_period_chips: interface.reference_codes[0].len(),
        phase_steps_per_period: interface.timing.scan.steps_per_period,
        first_phase_step: interface.timing.scan.first_step,
        phase_steps: interface.timing.scan.steps,
        integration_chips: interface.timing.scan.integration_chips,
        realigns: interface.realigns(),
        parallel: interface.parallel(),
        count_bits: interface.count_bits(),
        exact_count_bits: interface.exact_count_bits(),
        total_count: interface.total().map(|total| TotalParameters {
            first_bit: total.first_bit,
            bits: total.bits,
            exact_bits: total.exact_bits,
        }),
        peak: interface.peak().map(|peak| PeakParameters {
            step_bits: peak.step_bits,
            count_bits: peak.count_bits,
            latency_clocks: peak.latency_clocks,
        }),
        histogram: interface.histogram().map(|plan| HistogramParameters {
            rows: plan.rows,
            row_bins: plan.row_bins,
            bin_data_bits: plan.bin_data_bits(),
            periods: plan.periods,
            adder_samples: plan.adder_samples,
            buffers: plan.buffers,
            memory_bits: plan.memory_bits(detectors) as u64,
            block_ram_blocks: block_ram(sensor.scene().hardware.target)
                .blocks_of_histograms(plan, detectors),
        }),
    }
}

/// As the plan names them.
fn left_out(sensor: &Sensor) -> Vec<LeftOut> {
    let parts = parts_left_out(sensor).into_iter();
    parts.map(|Part { part, reason, .. }| LeftOut { part, reason }).collect()
}
