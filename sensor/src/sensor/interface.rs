//! What the hardware promises at its ports: widths, latency, order of results.
//!
//! Both sides build on this and on nothing else in common: the emitter makes
//! Verilog that keeps it, the reference model predicts ports from it.

use std::sync::Arc;

use super::cells::Cells;
use super::histogram::{CLOCKS_TO_BIN, HistogramPlan};
use super::peak::{self, PeakPlan};
use super::registers::{RegisterPlan, RegisteredHardware, Settings};
use super::rows::{RowPlan, signed_bits};
use super::track::{CLOCKS_FROM_PEAK, TrackPlan};
use crate::code::Code;
use crate::scan::{Grouping, PERIODS_OF_PREPARATION, Timing};
use crate::scene::{
    Architecture, CellOutputs, FpgaTarget, Polarity, Readout, Registers, Scene, Source,
};

/// The hardware that a scene needs, as seen from outside.
#[derive(Debug, Clone)]
pub struct Interface {
    /// Level of `i_samples` while a detector's pulse lasts.
    pub polarity: Polarity,
    /// Clock, scan, and how many phase steps are correlated at once.
    pub timing: Timing,
    /// Code of each source; bit m of `o_laser` carries source m's chips.
    pub source_codes: Vec<Arc<Code>>,
    /// Code of each detector's reference; inputs d K .. (d + 1) K belong to detector d.
    pub reference_codes: Vec<Arc<Code>>,
    /// SPADs of each detector that have an input each, K: lanes i S .. (i + 1) S of `i_samples` belong
    /// to input i.
    pub input_cells: Cells,
    /// Bits of `m_axis_tdata`: a signed count, sign-extended to whole bytes, and above
    /// it the total count, zero-extended to whole bytes, if it is sent; or a row of a histogram.
    pub tdata_bits: u32,
    /// Clocks from the one at which a step's last sample word is on
    /// `i_samples` to the one after which `m_axis_tvalid` shows its count.
    pub result_latency_clocks: u32,
    /// What hits are counted by.
    pub counting: Counting,
    /// Scans that a board adds up before their counts go to its line; 1: none. Nothing of it is at these
    /// ports.
    pub accumulate: u32,
    /// The registers by which a host sets the scan, if there are any.
    pub registers: Option<Arc<RegisterPlan>>,
}

/// What hardware counts hits by.
#[derive(Debug, Clone, Copy)]
pub enum Counting {
    /// The sign of the reference at each phase step: counts go up and down.
    Correlator(Correlator),
    /// Their time in the code period. All phase steps are one group, whose results are the
    /// rows of the histogram.
    Histogram(HistogramPlan),
}

/// Correlators: signed counts, and what follows from these.
#[derive(Debug, Clone, Copy)]
pub struct Correlator {
    /// Pairs of samples in the word of a detector, or of all its cells where each one's edges count.
    /// At most one of two neighbours is a hit, because a rising edge needs a low sample.
    pub pairs: u32,
    /// Bits of a signed count that no stimulus can overflow: of as many hits as there are pairs in all
    /// chips.
    pub exact_count_bits: u32,
    /// Bits of the signed count in a result; less than `exact_count_bits` means
    /// that it saturates.
    pub count_bits: u32,
    /// The total counts beside the signed ones, if the hardware sends them.
    pub total: Option<TotalCount>,
    /// Phase steps whose correlators work in the same clock; those of the next
    /// bank are a clock behind.
    pub bank_steps: u32,
    /// Banks of correlators.
    pub banks: u32,
    /// How the exact count's adder is split.
    pub count_segments: CountSegments,
    /// The peak detector, if there is one.
    pub peak: Option<PeakPlan>,
    /// How counts are read out by rows, if they are.
    pub rows: Option<RowPlan>,
}

/// A count's carry chain in segments, each one clock behind the one below it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CountSegments {
    /// Number of segments, at least 1.
    pub count: u32,
    /// Bits of every segment but the top one; without effect if there is one.
    pub lower_bits: u32,
    /// Bits of the top segment.
    pub top_bits: u32,
}

impl CountSegments {
    /// One segment if `longest` bits hold the count, else as many as are needed
    /// with the lower ones of one length.
    ///
    /// The lowest takes the sum of a word, of `addend_bits`.
    fn of(bits: u32, longest: u32, addend_bits: u32) -> CountSegments {
        if bits <= longest {
            return CountSegments { count: 1, lower_bits: bits, top_bits: bits };
        }
        let lower_bits = bits.div_ceil(bits.div_ceil(LONGEST_SEGMENT)).max(addend_bits);
        // The top one has a sign and a bit at least: wide sums make fewer segments.
        let count = (bits - 2) / lower_bits + 1;
        CountSegments { count, lower_bits, top_bits: bits - lower_bits * (count - 1) }
    }

    /// Clocks from the dump of the lowest segment to the whole count: one each,
    /// and one to pay what the lower ones owe.
    pub fn clocks(&self) -> u32 {
        self.count + u32::from(self.count > 1)
    }

    /// The same for the total beside the count, cut at the same bits: one dump
    /// serves both.
    pub fn of_total(self, total: TotalCount) -> CountSegments {
        CountSegments { top_bits: self.top_bits - (self.bits() - total.exact_bits), ..self }
    }

    /// Bits below each border between two segments.
    pub fn borders(self) -> impl Iterator<Item = u32> + Clone {
        (1..self.count).map(move |segment| segment * self.lower_bits)
    }

    /// Bits of all segments.
    pub fn bits(&self) -> u32 {
        self.lower_bits * (self.count - 1) + self.top_bits
    }
}

/// The number of hits of a phase step, up and down together: N beside r.
///
/// All steps of a group see the same light, so each detector has one for all of
/// them; it is sent with each.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TotalCount {
    /// Bits of a total that no stimulus can overflow, unsigned: one less than the
    /// signed count has, which needs a sign. Where a step is a single chip, as many:
    /// the adder takes a word's hits as a signed number.
    pub exact_bits: u32,
    /// Bits of a total in a result, unsigned; less than `exact_bits` means that it
    /// saturates. A total is as wide as a count, or exact.
    pub bits: u32,
    /// Bit of `m_axis_tdata` at which it begins.
    pub first_bit: u32,
}

impl TotalCount {
    /// Beside a signed count of `count_bits` bits, cut from one of `exact_count_bits`.
    fn of(count_bits: u32, exact_count_bits: u32, integration_chips: u64) -> TotalCount {
        let exact_bits = exact_count_bits - u32::from(integration_chips > 1);
        TotalCount {
            exact_bits,
            bits: count_bits.min(exact_bits),
            first_bit: whole_bytes(count_bits),
        }
    }

    /// Whether totals can saturate.
    pub fn saturates(&self) -> bool {
        self.bits < self.exact_bits
    }
}

/// Most correlators that a register reaches within a clock at 300 MHz in ECP5.
const BANK_STEPS: u32 = 4;

/// Phase steps of a bank of correlators: no more banks than a group has chips,
/// so that a count stays until those of the last bank are there.
fn bank_steps(scene: &Scene) -> u32 {
    let parallel = scene.hardware.parallel;
    let most_banks = scene.scan.integration_chips.clamp(1, u64::from(u32::MAX)) as u32;
    BANK_STEPS.max(parallel.div_ceil(most_banks))
}

/// Longest segment of a total in several: its carry has a way to go.
const LONGEST_SEGMENT: u32 = 12;

/// Longest carry chain in one piece that keeps a target's clock: 300 MHz in ECP5, 180 MHz
/// in iCE40.
pub fn longest_carry_chain(target: FpgaTarget) -> u32 {
    match target {
        FpgaTarget::Ecp525k6 | FpgaTarget::Xc7 => 22,
        FpgaTarget::Ice40Hx8k => 20,
    }
}

impl Correlator {
    /// The correlators of a scene.
    fn of(scene: &Scene, timing: &Timing, cells: &Cells) -> Correlator {
        let chips = scene.scan.integration_chips;
        let pairs = cells.edges() * scene.samples_per_chip.div_ceil(2);
        let exact_count_bits = signed_bits(u128::from(chips) * u128::from(pairs));
        let narrower = scene.hardware.counter_width.unwrap_or(exact_count_bits);
        let count_bits = narrower.min(exact_count_bits);
        let bank_steps = bank_steps(scene);
        let segments_of =
            |longest| CountSegments::of(exact_count_bits, longest, signed_bits(pairs.into()));
        let mut correlator = Correlator {
            pairs,
            exact_count_bits,
            count_bits,
            total: scene
                .sends_total_counts()
                .then(|| TotalCount::of(count_bits, exact_count_bits, chips)),
            bank_steps,
            banks: timing.parallel.div_ceil(bank_steps),
            count_segments: segments_of(longest_carry_chain(scene.hardware.target)),
            peak: None,
            rows: None,
        };
        if scene.hardware.readout == Readout::Rows {
            correlator.count_segments = segments_of(exact_count_bits);
            correlator.rows = Some(RowPlan::of(scene.detectors.len() as u64, chips, pairs));
        }
        if scene.hardware.peak_detector {
            let counts = peak::PeakCounts {
                bits: count_bits,
                saturate: correlator.saturates(),
                clocks_of_counting: correlator.clocks_of_counting(),
                latency_clocks: correlator.clocks_to_counted(),
            };
            let counted = match scene.hardware.registers {
                Registers::None => *timing,
                // A host sets the scan: steps are numbered from its first.
                Registers::Axi4Lite => timing.of_any_scan(),
            };
            correlator.peak = Some(PeakPlan::of(&counted, &counts));
        }
        correlator
    }

    /// Whether counts can saturate.
    pub fn saturates(&self) -> bool {
        self.count_bits < self.exact_count_bits
    }

    /// Clocks from a step's last one until the lowest segment of the total
    /// holds its hits: hits, lane pairs, one adder level per halving of the
    /// pairs, total. The segments of the count follow, and the result.
    pub fn clocks_to_dump(&self) -> u32 {
        let adder_levels = self.pairs.next_power_of_two().trailing_zeros();
        let (hits, lane_pairs, total) = (1, 1, 1);
        hits + lane_pairs + adder_levels + total
    }

    /// Clocks by which the end of a step is told before its last hits are in: a row of detectors takes
    /// its counters over at a register's word.
    pub fn dumps_early(&self) -> u32 {
        u32::from(self.rows.is_some())
    }

    /// Results of a group that is `results` long which wait in a queue at once.
    pub fn queued(&self, results: u32) -> u32 {
        if self.rows.is_some() { 1 } else { results }
    }

    /// Clocks from the first bits of a group's counts to the last.
    pub fn clocks_of_counting(&self) -> u32 {
        match self.rows {
            None => self.count_segments.clocks() + self.banks - 1,
            Some(_) => RowPlan::CLOCKS_OF_COUNTING,
        }
    }

    /// Clocks from a group's last sample word until its counts are there.
    pub fn clocks_to_counted(&self) -> u32 {
        self.clocks_to_dump() + self.clocks_of_counting()
    }

    /// Bits of `m_axis_tdata` that hold the signed count, sign-extended.
    pub fn signed_data_bits(&self) -> u32 {
        whole_bytes(self.count_bits)
    }

    /// Bits of `m_axis_tdata`.
    fn tdata_bits(&self) -> u32 {
        self.signed_data_bits() + self.total.map_or(0, |total| whole_bytes(total.bits))
    }
}

impl Interface {
    /// Derives the interface from a scene.
    pub fn of(scene: &Scene) -> Interface {
        let timing = scene.timing();
        let codes = |source: &Source| source.code.clone();
        let input_cells = match scene.detectors.first() {
            Some(spad) if spad.cell_outputs == CellOutputs::Separate => Cells::of(spad),
            _ => Cells::ONE,
        };
        let (counting, tdata_bits, result_latency_clocks) = match scene.hardware.architecture {
            Architecture::UpDown => {
                let correlator = Correlator::of(scene, &timing, &input_cells);
                let latency = correlator.clocks_to_counted();
                (Counting::Correlator(correlator), correlator.tdata_bits(), latency)
            }
            Architecture::Histogram => {
                let histogram = HistogramPlan::of(scene, &timing);
                let latency = histogram.latency_clocks();
                (Counting::Histogram(histogram), histogram.row_data_bits(), latency)
            }
        };
        let mut interface = Interface {
            polarity: scene.hardware.polarity,
            source_codes: scene.sources.iter().map(codes).collect(),
            reference_codes: scene
                .detectors
                .iter()
                .map(|detector| codes(&scene.sources[detector.reference]))
                .collect(),
            input_cells,
            timing,
            tdata_bits,
            result_latency_clocks,
            counting,
            accumulate: scene.hardware.accumulate,
            registers: None,
        };
        if scene.hardware.registers == Registers::Axi4Lite {
            let counting = interface.correlator().map_or(0, Correlator::clocks_of_counting);
            interface.registers = Some(Arc::new(RegisterPlan::of(&RegisteredHardware {
                timing: &interface.timing,
                source_codes: &interface.source_codes,
                detectors: interface.reference_codes.len(),
                clocks_of_counting: counting,
                least_chips_of_peak: interface.peak().map(|peak| peak.least_chips),
                sets_taps: scene.hardware.code_taps,
                longest_counter: longest_carry_chain(scene.hardware.target),
                track: interface.correlator().and_then(|correlator| {
                    TrackPlan::of(&scene.hardware, &interface.timing, correlator.count_bits)
                }),
                text: format!(
                    "{:?} {:?}{}{}",
                    interface.polarity,
                    interface.counting,
                    if scene.hardware.code_taps { " taps" } else { "" },
                    match interface.input_cells.count {
                        1 => String::new(),
                        _ => format!(" {:?}", interface.input_cells),
                    }
                ),
            })));
        }
        interface
    }

    /// The same hardware with these settings, which fit.
    pub fn with_settings(&self, plan: &RegisterPlan, settings: &Settings) -> Interface {
        let mut interface = self.clone();
        let scan = &mut interface.timing.scan;
        scan.integration_chips = settings.chips;
        scan.steps = settings.groups * u64::from(self.parallel());
        scan.first_step = settings.first_step;
        let seeds = plan.seeds.iter().zip(&settings.seeds);
        let set: Vec<Arc<Code>> = seeds
            .map(|(seed, &value)| match &self.source_codes[seed.source] {
                code if seed.of(code) == value => code.clone(),
                code => Arc::new(seed.code(code, value)),
            })
            .collect();
        for code in interface.source_codes.iter_mut().chain(&mut interface.reference_codes) {
            if let Some(number) = plan.seed_number(code, &self.source_codes) {
                *code = set[number].clone();
            }
        }
        interface
    }

    /// Why a host should not write a word to a register, though the hardware takes it ([`RegisterPlan::doubt`]).
    pub fn doubt(&self, address: u32, word: u32) -> Option<String> {
        self.registers.as_ref()?.doubt(&self.source_codes, address, word)
    }

    /// The correlators, if hits are counted up and down.
    pub fn correlator(&self) -> Option<&Correlator> {
        match &self.counting {
            Counting::Correlator(correlator) => Some(correlator),
            Counting::Histogram(_) => None,
        }
    }

    /// The histogram, if hits are counted by their time.
    pub fn histogram(&self) -> Option<&HistogramPlan> {
        match &self.counting {
            Counting::Correlator(_) => None,
            Counting::Histogram(histogram) => Some(histogram),
        }
    }

    /// How counts are read out by rows, if they are.
    pub fn rows(&self) -> Option<&RowPlan> {
        self.correlator()?.rows.as_ref()
    }

    /// The total counts, if the hardware sends them.
    pub fn total(&self) -> Option<&TotalCount> {
        self.correlator()?.total.as_ref()
    }

    /// The peak detector, if there is one.
    pub fn peak(&self) -> Option<&PeakPlan> {
        self.correlator()?.peak.as_ref()
    }

    /// What follows a target, if the hardware does.
    pub fn track(&self) -> Option<&TrackPlan> {
        self.registers.as_ref()?.track.as_ref()
    }

    /// Clocks from a scan's last sample word to its peak; 0 without a peak detector.
    pub fn peak_latency_clocks(&self) -> u32 {
        self.peak().map_or(0, |peak| peak.latency_clocks)
    }

    /// Clocks from the end of reset to the one after whose rising edge the lasers show their codes' first chips.
    pub fn start_clocks(&self) -> u64 {
        self.registers.as_ref().map_or(0, |plan| plan.start_clocks())
    }

    /// Clocks from the end of reset to the first word of the first scan, less one.
    pub fn lead_clocks(&self) -> u64 {
        self.start_clocks() + self.timing.preparation_chips
    }

    /// Chips from the first of a window to that of the next.
    pub fn window_pitch_chips(&self, track: &TrackPlan) -> u64 {
        track.window_steps() * self.timing.scan.integration_chips + self.window_turn_chips(track)
    }

    /// Chips from the last of a window to the first of the next: until its last count is there and has been weighed, until
    /// codes have begun anew, and a scan's preparation.
    pub fn window_turn_chips(&self, track: &TrackPlan) -> u64 {
        self.turn_chips(self.result_latency_clocks + track.decision_clocks())
    }

    /// The same of a scan that has found a target, and the first window: its peak is waited for.
    pub fn search_turn_chips(&self) -> u64 {
        self.turn_chips(self.peak_latency_clocks() + CLOCKS_FROM_PEAK)
    }

    fn turn_chips(&self, decision_clocks: u32) -> u64 {
        let start = u64::from(decision_clocks) + 1 + self.start_clocks();
        start + PERIODS_OF_PREPARATION * self.timing.code_chips()
    }

    /// Results that a group sends: one for each phase step and detector, or the rows of
    /// their histograms.
    pub fn beats_of_group(&self) -> u64 {
        let results = match &self.counting {
            Counting::Correlator(_) => u64::from(self.parallel()),
            Counting::Histogram(histogram) => histogram.rows,
        };
        results * self.reference_codes.len() as u64
    }

    /// Clocks that a hit takes to the total, or to its bin.
    pub fn clocks_of_hit(&self) -> u32 {
        match self.counting {
            Counting::Correlator(correlator) => correlator.clocks_to_dump(),
            Counting::Histogram(_) => CLOCKS_TO_BIN,
        }
    }

    /// Inputs with samples of their own: one for each detector, or for each of its cells.
    pub fn inputs(&self) -> usize {
        self.reference_codes.len() * self.input_cells.count as usize
    }

    /// Samples per clock and input, S.
    pub fn lanes(&self) -> u32 {
        self.timing.clock.samples_per_chip
    }

    /// Phase steps correlated at once.
    pub fn parallel(&self) -> u32 {
        self.timing.parallel
    }

    /// Groups of phase steps in a scan: `parallel` steps share their light.
    pub fn groups(&self) -> u64 {
        self.timing.groups()
    }

    /// How the scan's steps share their light.
    pub fn grouping(&self) -> Grouping {
        self.timing.grouping()
    }

    /// Phase steps of a scan's last group.
    pub fn last_group_steps(&self) -> u64 {
        self.grouping().steps_of_last()
    }

    /// Clocks of a scan; `u64::MAX` if there are more.
    pub fn scan_clocks(&self) -> u64 {
        u64::try_from(self.timing.scan_chips()).unwrap_or(u64::MAX)
    }

    /// Bits of a count in a result: of a signed one, or of a bin.
    pub fn count_bits(&self) -> u32 {
        match &self.counting {
            Counting::Correlator(correlator) => correlator.count_bits,
            Counting::Histogram(histogram) => histogram.bin_bits,
        }
    }

    /// Bits of a count that no stimulus can overflow.
    pub fn exact_count_bits(&self) -> u32 {
        match &self.counting {
            Counting::Correlator(correlator) => correlator.exact_count_bits,
            Counting::Histogram(histogram) => histogram.exact_bits,
        }
    }

    /// Whether counts can saturate, so that the clamp and its flag exist. Totals
    /// cannot where counts cannot.
    pub fn saturates(&self) -> bool {
        self.count_bits() < self.exact_count_bits()
    }

    /// Whether a scan is followed by a pause until the next epoch.
    pub fn realigns(&self) -> bool {
        !self.timing.is_gapless()
    }
}

/// Bits of the bytes that hold `bits` bits: AXI4-Stream data come in bytes.
fn whole_bytes(bits: u32) -> u32 {
    bits.div_ceil(8) * 8
}

#[cfg(test)]
mod tests {
    use super::CountSegments;

    /// A word of 64 cells of 64 samples has a sum of 13 bits, more than a segment of most counts.
    #[test]
    fn segments_make_up_the_count_and_the_lowest_takes_a_words_sum() {
        for (bits, longest, addend_bits) in (2..=64_u32)
            .flat_map(|bits| (1..=13.min(bits)).map(move |addend_bits| (bits, addend_bits)))
            .flat_map(|(bits, addend)| [11, 24, 31].map(|longest| (bits, longest, addend)))
        {
            let made = CountSegments::of(bits, longest, addend_bits);
            assert_eq!(made.lower_bits * (made.count - 1) + made.top_bits, bits);
            let one = made.count == 1 && made.top_bits == bits;
            let several = made.lower_bits >= addend_bits && made.top_bits >= 2;
            assert!(one || several, "{bits} bits, {longest} at most, {addend_bits}: {made:?}");
        }
    }
}
