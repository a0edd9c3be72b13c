//! What the hardware takes of an FPGA: measured where this very sensor was built, else
//! fitted to all builds of docs/resources.md.

mod fit;
mod histogram;
mod measured;

use serde::Serialize;

use self::fit::{Fit, Terms};
use self::histogram::HistogramSize;
use self::measured::Build;
use super::Part;
use super::cells::FpgaCells;
use crate::code::Generator;
use crate::scene::FpgaTarget;
use crate::sensor::block_ram::block_ram;
use crate::sensor::{self, Sensor};

/// What the hardware of a sensor takes.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct Resources {
    /// The family and the tools' options that stand behind the numbers.
    pub family: &'static str,
    /// What is counted as a look-up table.
    pub lut: &'static str,
    /// The cells.
    #[serde(flatten)]
    pub cells: FpgaCells,
    /// Block RAMs, in the blocks that the plan names: only histograms have memories.
    pub block_rams: u64,
    /// Where the numbers come from.
    pub basis: Basis,
}

/// Where numbers of cells come from.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case", tag = "kind")]
pub enum Basis {
    /// This sensor was synthesized.
    Measured,
    /// A fit to others that were.
    Fitted {
        /// Sensors that were synthesized.
        builds: usize,
        /// The fit is off by no more than this share at any of them.
        largest_relative_error: f64,
        /// Root mean square of the share by which it is off at each of them when
        /// fitted to the others.
        cross_validation_relative_error: f64,
    },
}

impl Resources {
    /// LUTs, about so many if fitted, and blocks of memory, if it has any.
    pub fn in_short(&self) -> String {
        let about = match self.basis {
            Basis::Measured => "",
            Basis::Fitted { .. } => "about ",
        };
        let blocks = match self.block_rams {
            0 => String::new(),
            blocks => format!(", {blocks} block RAM"),
        };
        format!("{about}{} LUTs{blocks}", self.cells.luts)
    }
}

/// What decides the cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Size {
    /// Flip-flops of all LFSRs, those of references included.
    lfsr_bits: u32,
    /// Interleaving depths of all generators together.
    interleaving: u32,
    samples_per_chip: u32,
    detectors: u32,
    parallel: u32,
    /// Bits of a count that nothing overflows, and of those that are sent.
    exact_bits: u32,
    count_bits: u32,
    segmented: bool,
    realigns: bool,
    total_counts: bool,
    peak_detector: bool,
    /// Cells with an input each.
    input_cells: sensor::cells::Cells,
}

/// Bits that one carry chain holds at full clock, as the sensor's interface has it.
fn longest_carry_chain(target: FpgaTarget) -> u32 {
    match target {
        FpgaTarget::Ecp525k6 | FpgaTarget::Xc7 => 22,
        FpgaTarget::Ice40Hx8k => 20,
    }
}

impl Size {
    /// `None` for codes that were not measured, for rows of detectors, and for histograms.
    fn of(sensor: &Sensor) -> Option<Size> {
        let interface = sensor.interface();
        let correlator = interface.correlator().filter(|correlator| correlator.rows.is_none())?;
        let mut generators: Vec<_> = interface.reference_codes.clone();
        for (index, code) in interface.source_codes.iter().enumerate() {
            if !interface.source_codes[..index].contains(code) {
                generators.push(code.clone());
            }
        }
        let bits = generators.iter().map(|code| match &code.generator {
            Generator::Gold { u, v } => Some(u.degree + v.degree),
            Generator::MSequence(lfsr) => Some(lfsr.degree),
            Generator::Square => Some(0),
            Generator::Chips(_) => None,
        });
        Some(Size {
            lfsr_bits: bits.sum::<Option<u32>>()?,
            interleaving: generators.iter().map(|code| code.interleave).sum(),
            samples_per_chip: interface.lanes(),
            detectors: interface.reference_codes.len() as u32,
            parallel: interface.parallel(),
            exact_bits: correlator.exact_count_bits,
            count_bits: correlator.count_bits,
            segmented: correlator.count_segments.count > 1,
            realigns: interface.realigns(),
            total_counts: correlator.total.is_some(),
            peak_detector: correlator.peak.is_some(),
            input_cells: interface.input_cells,
        })
    }
}

/// What the hardware of `sensor` takes in its target; `None` where nothing like it was
/// measured.
pub fn resources(sensor: &Sensor) -> Option<Resources> {
    let target = sensor.scene().hardware.target;
    let (cells, basis, block_rams) = match sensor.interface().histogram() {
        None => {
            let size = Size::of(sensor)?;
            let (cells, basis) = looked_up(&size, &measured::builds(target))?;
            (cells, basis, 0)
        }
        Some(plan) => {
            let size = HistogramSize::of(sensor, plan)
                .filter(|size| size.has_a_measured_length(target))
                .filter(|_| sensor.interface().input_cells.count == 1)?;
            let (cells, basis) = looked_up(&size, &histogram::builds(target))?;
            let detectors = sensor.scene().detectors.len();
            let blocks = block_ram(target).blocks_of_histograms(plan, detectors);
            (cells, basis, blocks)
        }
    };
    Some(Resources {
        family: match target {
            FpgaTarget::Ecp525k6 => "ECP5-25k, speed 6 (synth_ecp5 -abc9)",
            FpgaTarget::Ice40Hx8k => "iCE40 HX8K (synth_ice40 -abc9 -device hx)",
            FpgaTarget::Xc7 => "7-series (synth_xilinx -family xc7 -flatten -abc9)",
        },
        lut: match target {
            FpgaTarget::Ecp525k6 => "LUT4, two for each CCU2C",
            FpgaTarget::Ice40Hx8k => "LUT4",
            FpgaTarget::Xc7 => "LUT, of any number of inputs",
        },
        cells,
        block_rams,
        basis,
    })
}

/// Cells of the build that has this size, or fitted to all; `None` of a few builds, which
/// any fit would meet.
fn looked_up<S: Terms + PartialEq>(size: &S, builds: &[Build<S>]) -> Option<(FpgaCells, Basis)> {
    if let Some(build) = builds.iter().find(|build| build.size == *size) {
        return Some((build.cells, Basis::Measured));
    }
    if builds.len() < 2 * size.terms().len() {
        return None;
    }
    let fit = Fit::of(builds);
    Some((fit.cells(size), fit.basis(builds)))
}

/// What a part of the hardware that `sensor` leaves out would take, by the fit: one
/// level of interleaving, two phase steps at once. `None` where that was not measured
/// apart.
pub fn saved_by(sensor: &Sensor, part: &Part) -> Option<FpgaCells> {
    let size = Size::of(sensor)?;
    let mut with = size;
    match part.bare_name() {
        "interleaver" => with.interleaving += 2,
        "parallel_correlators" => with.parallel *= 2,
        "count_segments" => with.segmented = true,
        "total_counts" => with.total_counts = true,
        "peak_detector" => with.peak_detector = true,
        _ => return None,
    }
    let fit = Fit::of(&measured::builds(sensor.scene().hardware.target));
    let [without, with] = [size, with].map(|size| fit.cells(&size));
    Some(FpgaCells {
        luts: with.luts.checked_sub(without.luts)?,
        flip_flops: with.flip_flops.checked_sub(without.flip_flops)?,
    })
}
