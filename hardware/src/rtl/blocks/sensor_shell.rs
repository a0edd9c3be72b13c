//! What every sensor has, whatever it counts: its ports, and what drives the lasers.
//!
//! Sources that follow one code share its generator; docs/resources.md has what each option costs.

use std::sync::Arc;

use super::code_source::seed_of;
use super::register_file::RegisterPorts;
use super::{CellCombiner, CodeSource};
use crate::code::Code;
use crate::rtl::front::prelude::*;
use crate::scene::Polarity;
use crate::sensor::interface::{Correlator, Counting, Interface};
use crate::sensor::registers::{CHIPS_AHEAD, is_same};

/// Headings in the list of ports.
const FLAGS: &str = "Flags, high until reset";
const PEAK: &str = "Peak of a scan, steady until the next scan's";

/// Lasers, samples, the stream and its flags, and what the peak detector shows; and the generators
/// of the lasers' codes.
#[block]
pub struct SensorShell {
    interface: Interface,
    #[set(distinct_codes(&interface.reference_codes[0], &interface.source_codes))]
    pub(super) codes: DistinctCodes,
    /// Whether a host sets the scan.
    #[set(interface.registers.is_some())]
    is_set: bool,
    /// Whether the generators have a load, which only a host uses.
    #[set(interface.correlator().is_some() && interface.realigns())]
    reloads: bool,
    #[set(interface.reference_codes.len())]
    detectors: usize,
    /// Whether the samples are low during a pulse; everything behind `pulses` takes it for high.
    #[set(interface.polarity == Polarity::Low)]
    is_low: bool,
    #[set(interface.peak().is_some())]
    has_peak: bool,
    /// Heading of the stream.
    #[set(match interface.counting {
        Counting::Correlator(_) => "Results, AXI4-Stream",
        Counting::Histogram(_) => "Rows of the histograms, AXI4-Stream",
    })]
    stream: &'static str,
    /// What a beat of it is.
    #[set(match interface.counting {
        Counting::Correlator(_) => ("a result waits", "it is the scan's last"),
        Counting::Histogram(_) => ("a row waits", "it is the frame's last"),
    })]
    beat: (&'static str, &'static str),
    /// chip of each source, bit m for source m
    #[under("Lasers")]
    #[width(interface.source_codes.len())]
    pub o_laser: Output<Word>,
    /// o_laser shows the first chip of the reference's code
    pub o_epoch: Output<bool>,
    /// {samples_about(&interface)}
    #[under("Detector")]
    #[width(width(&interface, "i_samples"))]
    pub i_samples: Input<Word>,
    /// {data_about(&interface)}
    #[under(stream)]
    #[width(width(&interface, "m_axis_tdata"))]
    pub m_axis_tdata: Output<Word>,
    /// {beat.0}
    pub m_axis_tvalid: Output<bool>,
    /// the receiver takes it
    pub m_axis_tready: Input<bool>,
    /// {beat.1}
    pub m_axis_tlast: Output<bool>,
    /// What is lost when the receiver is too slow.
    #[under(FLAGS)]
    #[about(match interface.counting {
        Counting::Correlator(_) => "a result was lost since reset",
        Counting::Histogram(plan) if plan.takes_turns() => "a frame was lost since reset",
        Counting::Histogram(_) => "a row was lost since reset",
    })]
    pub o_overrun: Output<bool>,
    /// A count was clamped since reset.
    #[when(interface.saturates())]
    #[about(match interface.counting {
        Counting::Correlator(Correlator { total: None, .. }) => "a count was clamped since reset",
        Counting::Correlator(_) => "a count or a total was clamped since reset",
        Counting::Histogram(_) => "a bin was full and had a hit since reset",
    })]
    pub o_saturated: Optional<Output<bool>>,
    /// {peak_about(detectors, "step k of the last scan's peak")}
    #[under(PEAK)]
    #[when(has_peak)]
    #[width(width(&interface, "o_peak_step"))]
    pub o_peak_step: Optional<Output<Word>>,
    /// {peak_about(detectors, "the count, signed")}
    #[when(has_peak)]
    #[width(width(&interface, "o_peak_count"))]
    pub o_peak_count: Optional<Output<Word>>,
    /// high for one clock when they have changed
    #[when(has_peak)]
    pub o_peak_valid: Optional<Output<bool>>,
    /// by which a host sets the scan
    #[when(is_set)]
    #[is(RegisterPorts::new())]
    pub registers: Optional<RegisterPorts>,
    /// levels of the SPADs, high during a pulse
    #[width(width(&interface, "i_samples"))]
    pub(super) pulses: Local<Word>,
    /// Levels of the detectors, where cells that have an input each make one together.
    #[each(_detector in 0..if interface.input_cells.gates().is_some() { detectors } else { 0 })]
    #[is(CellCombiner::new(interface.lanes() as usize, interface.input_cells))]
    pub(super) combiner: Vec<CellCombiner>,
    #[width(codes.of_sources.len())]
    pub(super) laser: Register<Word>,
    pub(super) epoch: Register<bool>,
    #[each(code in codes.all.iter())]
    #[is(if is_set { CodeSource::seeded(code, seed_of(&interface, code)) } else { CodeSource::new(code, 0, reloads) })]
    pub(super) transmit: Vec<CodeSource>,
    /// chips on their way to the lasers
    #[when(is_set)]
    #[width(CHIPS_AHEAD as usize * codes.of_sources.len())]
    pub(super) ahead: Optional<Register<Word>>,
    /// first chips of the reference's code on their way
    #[when(is_set)]
    #[width(CHIPS_AHEAD as u32)]
    pub(super) epoch_ahead: Optional<Register<Word>>,
    #[width(codes.of_sources.len())]
    pub(super) chips: Local<Word>,
}

#[kernel]
impl SensorShell {
    /// The generators run, and their chips go to the lasers, unless a host sets when they do; and cells make
    /// detectors' levels.
    pub(super) fn transmit(&mut self) {
        for g in 0..self.transmit.len() {
            self.transmit[g].i_advance.next = true;
        }
        self.chips.next = gather(self.codes.of_sources.len(), |source| {
            self.transmit[self.codes.of_sources[source]].o_chip.val()
        });
        if !self.is_set {
            self.laser.next = self.chips.val();
            self.epoch.next = self.transmit[0].o_epoch.val();
        }
        connect! { self: laser, epoch }
        self.pulses.next = if self.is_low { !self.i_samples.val() } else { self.i_samples.val() };
        let bits = self.interface.lanes() as usize * self.interface.input_cells.count as usize;
        for d in 0..self.combiner.len() {
            self.combiner[d].i_samples.next = self.pulses.val().slice(bits * d, bits);
        }
    }
}

/// What is said of a sensor's clock, and of its outputs in reset.
pub(super) fn about_clock(lanes: u32, outputs: &str) -> String {
    format!(
        "One clock cycle is one chip of {lanes} samples. The sample word of a chip is expected on \
         i_samples one cycle after o_laser shows the chip. In reset all {outputs} are 0."
    )
}

/// What is said of a sensor that counts in `unit`s before its reset.
pub(super) fn about_power_up(unit: &str) -> String {
    format!(
        "Registers have no values at power-up: before the first {unit} i_rst has to be high at one \
         rising edge of i_clk at least. Without that the outputs mean nothing."
    )
}

/// Codes of which each has one generator.
#[derive(Debug, Clone)]
pub(super) struct DistinctCodes {
    /// Each once, the reference's first.
    pub(super) all: Vec<Arc<Code>>,
    /// For each source the index of its code.
    pub(super) of_sources: Vec<usize>,
}

pub(super) fn distinct_codes(reference: &Arc<Code>, sources: &[Arc<Code>]) -> DistinctCodes {
    let mut codes = DistinctCodes { all: vec![reference.clone()], of_sources: Vec::new() };
    for code in sources {
        let index = codes.all.iter().position(|known| is_same(known, code)).unwrap_or_else(|| {
            codes.all.push(code.clone());
            codes.all.len() - 1
        });
        codes.of_sources.push(index);
    }
    codes
}

/// Bits of a port that the interface has.
fn width(interface: &Interface, name: &str) -> u32 {
    let port = interface.ports().into_iter().find(|p| p.name == name);
    port.map_or(1, |p| p.width)
}

fn peak_about(detectors: usize, about: &str) -> String {
    match detectors {
        1 => about.to_owned(),
        _ => format!("{about}; detector 0 lowest"),
    }
}

fn data_about(interface: &Interface) -> String {
    match interface.counting {
        Counting::Correlator(Correlator { total: None, .. }) => {
            "count of a phase step, signed".to_owned()
        }
        Counting::Correlator(Correlator { total: Some(total), .. }) => {
            format!("from bit {} its hits, below its signed count", total.first_bit)
        }
        Counting::Histogram(plan) => {
            format!("bins of a row, {} bits each, bit 0 earliest", plan.bin_data_bits())
        }
    }
}

fn samples_about(interface: &Interface) -> String {
    let lanes = interface.lanes();
    let about = match (interface.reference_codes.len(), interface.input_cells.count) {
        (1, 1) => "SPAD level, bit 0 earliest".to_owned(),
        (_, 1) => format!("SPAD levels, {lanes} samples per detector, bit 0 earliest"),
        (detectors, cells) => format!(
            "SPAD levels, {lanes} samples per cell, bit 0 earliest; {cells} cells{}",
            if detectors == 1 { "" } else { " per detector" }
        ),
    };
    match interface.polarity {
        Polarity::High => about,
        Polarity::Low => about + ", low during a pulse",
    }
}
