//! Predicts every output port of `sensor_top` at every clock.
//!
//! The work follows events, not clocks: chips are copied period by period from
//! the code table, counts change only where there is a hit, and the result
//! stream only where a result arrives or is taken.

mod counting;
mod hosted;
mod hosted_track;
mod results;

use std::ops::Range;
use std::sync::Arc;

pub use self::counting::{GroupSigns, SampleSigns};
use self::hosted::Hosted;
use super::canvas::{Canvas, Changes, EveryClock, Unseen};
use super::coverage::{CoverTable, ResetPoint, ResetState, Running, ScanPoint};
use super::exercise::Exercised;
use super::histogram::HistogramModel;
use super::host_ports::HostClocks;
use super::pattern::{ChipPattern, chip_patterns};
use super::peak_ports::PeakPorts;
use super::resets::{PortState, ResetWatch, Upon};
use super::stream::{Ready, StreamModel};
use crate::scan::{Chip, Group, Sample};
use crate::scene::{DetectorIndex, SourceIndex};
use crate::sensor::cells::CellChange;
use crate::sensor::interface::Interface;
use crate::sensor::layout::Layout;
use crate::sensor::port::PortRole;

/// What the surroundings do to the hardware in a block of clocks, besides the
/// detectors' levels.
#[derive(Debug, Clone, Default)]
pub struct Surroundings {
    /// The block's clocks.
    pub clocks: Range<u64>,
    /// Clocks at which `i_rst` is high, in order; may reach beyond the block.
    pub resets: Vec<Range<u64>>,
    /// Clocks at which `m_axis_tready` is low, in order, disjoint; may reach
    /// beyond the block.
    pub stalls: Vec<Range<u64>>,
    /// Phase steps and scans that are cut short in the block, in order.
    pub skips: Vec<Skip>,
    /// What a host drives in the block.
    pub host: HostClocks,
    /// For each detector what its cells do in the block, if they have an input each: for cover points
    /// alone, beside the hits that follow from it.
    pub cells: Vec<Vec<CellChange>>,
}

impl Surroundings {
    /// Clocks at which an input has not the level at which it rests.
    pub fn away_from_rest(&self, input: PortRole) -> &[Range<u64>] {
        match input {
            PortRole::Reset => &self.resets,
            PortRole::Ready => &self.stalls,
            _ => &[],
        }
    }
}

/// A phase step, or a scan, is cut short: the scan controller's counters go forward
/// between two clocks, and nothing else changes. The delay of the reference goes on
/// from group to group as if nothing had been left out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Skip {
    /// Between the rising edges of the clock before this one and of this one.
    pub clock: u64,
    /// Chip of the present group that is counted then.
    pub chip: u64,
    /// The present group.
    pub group: Group,
    /// Chips by which the present group gets shorter.
    pub chips: u64,
    /// Groups that are left out before the next one.
    pub groups: u64,
}

/// Where a scan stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ScanPosition {
    /// First clock without reset.
    pub released: u64,
    /// Number of the scan since then.
    pub scan: u64,
    /// The present group, or the next.
    pub group: Group,
    /// First cycle of it.
    pub from: u64,
}

impl ScanPosition {
    /// Whether a scan is under way or prepared; without registers there always is one.
    pub fn is_scan(&self) -> bool {
        self.from != hosted::NEVER
    }

    /// The clock at which the group's first word is presented.
    pub fn first_word(&self) -> u64 {
        self.released + 1 + self.from
    }
}

/// A phase step whose integration is over.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StepResult {
    /// The clock after whose rising edge its group comes to the stream, if nothing
    /// stands there any more.
    pub clock: u64,
    /// Number of the scan since the last reset.
    pub scan: u64,
    /// The detector.
    pub detector: DetectorIndex,
    /// Number of the step within the scan, 0..steps.
    pub step: u64,
    /// The count, saturated as the hardware does.
    pub count: i64,
    /// The hits that were counted, up and down together; saturated as the hardware
    /// does where it sends them.
    pub total: u64,
    /// The count before it is saturated.
    pub exact: i64,
    /// The total before it is saturated.
    pub exact_total: u64,
}

/// Why an interface cannot be predicted.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ReferenceError {
    /// References of different length.
    #[error(
        "the detectors' reference codes have {0:?} chips per period; one scan walks all of them, \
         so they need one length"
    )]
    CodeLengths(Vec<u64>),
}

/// The reference model. One per run; it starts in reset.
#[derive(Debug, Clone)]
pub struct ReferenceModel {
    interface: Interface,
    /// chi of the chips of each detector's reference (eq. 10).
    signs: Vec<Vec<i8>>,
    chips: Vec<ChipPattern>,
    words: usize,
    stream: StreamModel,
    peak: Option<PeakPorts>,
    /// The registers, if there are any; what follows from the scan is then as they were last taken over.
    hosted: Option<Box<Hosted>>,
    /// In place of counts and stream, if the hardware keeps a histogram.
    histogram: Option<HistogramModel>,
    /// First clock without reset; before it every output is 0.
    released: u64,
    /// End of the last reset; with registers the codes begin later.
    reset_until: u64,
    scan: ScanState,
    table: Arc<CoverTable>,
    running: Running,
    resets: ResetWatch,
    /// For each detector: a hit on the last sample before the present scan.
    before_scan: Vec<bool>,
    /// Counts of the present group: detector by detector, step by step.
    counts: Vec<i64>,
    /// Hits of the present group, detector by detector: all steps see the same.
    totals: Vec<u64>,
    finished: Vec<StepResult>,
}

/// chi of the chips of each detector's reference.
fn signs(interface: &Interface) -> Vec<Vec<i8>> {
    let codes = interface.reference_codes.iter();
    codes.map(|code| code.chips.iter().map(|&chip| 2 * chip as i8 - 1).collect()).collect()
}

/// Where the scan stands, in cycles since reset.
#[derive(Debug, Clone, Copy)]
struct ScanState {
    scan: u64,
    group: Group,
    /// First cycle of the group of steps.
    from: u64,
    /// Chips of the group.
    chips: u64,
    /// Steps that this scan has left out so far.
    left_out: u64,
    /// Steps that were left out since the delay began anew: it lags by as many.
    lag: u64,
    /// Delay of the group before, unless it began anew since.
    previous_delay: Option<u64>,
}

impl ScanState {
    fn start(interface: &Interface) -> ScanState {
        ScanState {
            scan: 0,
            group: Group(0),
            from: 0,
            chips: interface.timing.scan.integration_chips,
            left_out: 0,
            lag: 0,
            previous_delay: None,
        }
    }
}

impl ReferenceModel {
    /// A model of the hardware with this interface.
    ///
    /// # Errors
    /// When the interface asks for hardware that is not modelled.
    pub fn new(interface: Interface) -> Result<ReferenceModel, ReferenceError> {
        let lengths = interface.reference_codes.iter().map(|code| code.len());
        if lengths.clone().any(|length| length != interface.reference_codes[0].len()) {
            return Err(ReferenceError::CodeLengths(lengths.collect()));
        }
        let layout = Layout::of(&interface);
        let place = |role| layout.outputs.place(role);
        let table = CoverTable::of(&interface);
        Ok(ReferenceModel {
            signs: signs(&interface),
            chips: chip_patterns(&interface, place(PortRole::Laser), place(PortRole::Epoch)),
            words: layout.outputs.words,
            stream: StreamModel::new(&interface, &layout, Arc::clone(&table)),
            peak: PeakPorts::new(&interface, &layout),
            hosted: Hosted::new(&interface, &layout),
            histogram: HistogramModel::new(&interface, Arc::clone(&table)),
            released: 0,
            reset_until: 0,
            scan: ScanState::start(&interface),
            running: Running::of(&interface, &table),
            table,
            resets: ResetWatch::of(&interface),
            before_scan: vec![false; interface.reference_codes.len()],
            counts: match interface.histogram() {
                None => vec![0; interface.reference_codes.len() * interface.parallel() as usize],
                Some(_) => Vec::new(),
            },
            totals: vec![0; interface.reference_codes.len()],
            finished: Vec::new(),
            interface,
        })
    }

    /// What it predicts.
    pub fn interface(&self) -> &Interface {
        &self.interface
    }

    /// Words per clock of the expected outputs.
    pub fn words(&self) -> usize {
        self.words
    }

    /// Results of the steps that ended in the blocks predicted so far, in order,
    /// whether or not the stream had room for them. Empties the list.
    pub fn take_finished(&mut self) -> std::vec::Drain<'_, StepResult> {
        self.finished.drain(..)
    }

    /// What it is to be seen doing.
    pub fn cover_table(&self) -> &Arc<CoverTable> {
        &self.table
    }

    /// Where the scan stands after the blocks predicted so far.
    pub fn position(&self) -> ScanPosition {
        ScanPosition {
            released: self.released,
            scan: self.scan.scan,
            group: self.scan.group,
            from: self.scan.from,
        }
    }

    /// What the outputs have shown in the blocks predicted so far.
    pub fn exercise(&self) -> &Exercised {
        &self.stream.axis.exercise
    }

    /// Predicts a block. Blocks follow one another without a gap.
    ///
    /// `hits` are, for each detector, the first samples of the runs of high
    /// samples that start in the block, in order, numbered as in
    /// [`super::level::LevelPainter::paint`]. `expected` has `words()` entries per
    /// clock and is overwritten.
    pub fn predict(&mut self, block: &Surroundings, hits: &[Vec<Sample>], expected: &mut [u64]) {
        expected.fill(0);
        let mut every_clock =
            EveryClock { first_clock: block.clocks.start, words: self.words, records: expected };
        self.predict_into(block, hits, &mut every_clock);
    }

    /// [`ReferenceModel::predict`], of blocks of any length, and only where outputs change
    /// that do not follow a code. What holds at a block's end changes there, and back
    /// at the next one's start.
    pub fn predict_changes(
        &mut self,
        block: &Surroundings,
        hits: &[Vec<Sample>],
        changes: &mut Changes,
    ) {
        self.predict_into(block, hits, changes);
    }

    /// [`ReferenceModel::predict`], of blocks of any length, and only what [`ReferenceModel::take_finished`] has.
    pub fn predict_results(&mut self, block: &Surroundings, hits: &[Vec<Sample>]) {
        self.predict_into(block, hits, &mut Unseen);
    }

    fn predict_into(
        &mut self,
        block: &Surroundings,
        hits: &[Vec<Sample>],
        expected: &mut impl Canvas,
    ) {
        let mut clock = block.clocks.start;
        let mut resets = block.resets.iter().peekable();
        let mut skips = block.skips.iter().peekable();
        while resets.next_if(|r| r.end <= clock).is_some() {}
        while clock < block.clocks.end {
            if let Some(reset) = resets.next_if(|r| r.start <= clock) {
                self.reset(reset, hits);
            }
            while let Some(skip) = skips.next_if(|s| s.clock <= clock) {
                self.skip(skip);
            }
            let released = match self.hosted {
                None => self.released,
                // The codes begin later.
                Some(_) => self.reset_until,
            };
            if clock < released {
                clock = released.min(block.clocks.end);
                continue;
            }
            let mut until = block.clocks.end;
            if let Some(reset) = resets.peek() {
                until = until.min(reset.start);
            }
            if let Some(skip) = skips.peek() {
                until = until.min(skip.clock);
            }
            if self.resets.is_stalled {
                let ready = Ready::new(&block.stalls).first_from(clock);
                self.resets.is_stalled = ready > clock;
                until = until.min(ready.max(clock + 1));
            }
            self.predict_released(clock..until, block, hits, expected);
            self.watch_stall();
            clock = until;
        }
    }

    fn reset(&mut self, reset: &Range<u64>, hits: &[Vec<Sample>]) {
        // One that reaches into this block was told in the block before, too, perhaps
        // with an end that was not known yet.
        if reset.start >= self.reset_until {
            self.stream.axis.exercise.resets += 1;
            let in_pause = self.scan.group == Group(0)
                && self.scan.scan > 0
                && reset.start < self.released.saturating_add(1 + self.scan.from);
            let sampling = self.interface.timing.sampling();
            let word = sampling.samples(&(reset.start..reset.start + 1));
            let has_hit = |hits: &Vec<Sample>| {
                let at = hits.partition_point(|&hit| hit < word.start);
                hits.get(at).is_some_and(|hit| word.contains(hit))
            };
            let upon =
                Upon { in_pause, has_hit: hits.iter().any(has_hit), ports: self.port_state() };
            self.resets.enters(reset, upon, &self.table);
        }
        self.released = reset.end;
        self.reset_until = reset.end;
        self.scan = ScanState::start(&self.interface);
        self.counts.fill(0);
        self.totals.fill(0);
        self.running.reset();
        self.before_scan.fill(false);
        self.stream.reset();
        if let Some(histogram) = &mut self.histogram {
            histogram.reset(&mut self.stream.axis);
        }
        if let Some(peak) = &mut self.peak {
            peak.reset();
        }
        if let Some(hosted) = &mut self.hosted {
            hosted.reset();
            self.scan = Hosted::no_scan(0, &self.interface);
        }
    }

    fn skip(&mut self, skip: &Skip) {
        debug_assert_eq!(skip.group, self.scan.group);
        self.scan.chips -= skip.chips;
        self.scan.group.0 += skip.groups;
        let steps = skip.groups * u64::from(self.interface.parallel());
        self.scan.left_out += steps;
        self.scan.lag += steps;
    }

    /// The delay of the present group's first step, in samples.
    fn delay(&self) -> u64 {
        let first = self.interface.grouping().step_of(self.scan.group, 0);
        let period = self.interface.timing.scan.steps_per_period;
        (self.interface.timing.scan.phase_step(first) + period - self.scan.lag % period) % period
    }

    /// A stretch of clocks without reset.
    fn predict_released(
        &mut self,
        clocks: Range<u64>,
        block: &Surroundings,
        hits: &[Vec<Sample>],
        expected: &mut impl Canvas,
    ) {
        if let Some(hosted) = self.hosted.take() {
            return self.predict_hosted(hosted, clocks, block, hits, expected);
        }
        for pattern in &self.chips {
            expected.or_code(pattern, clocks.clone(), clocks.start - self.released);
        }
        self.mark_codes(clocks.end - self.released);
        self.count(clocks.clone(), block, hits);
        if let Some(histogram) = &mut self.histogram {
            return histogram.predict(clocks, &block.stalls, expected, &mut self.stream.axis);
        }
        self.stream.predict(clocks.clone(), &block.stalls, expected);
        if let Some(peak) = &mut self.peak {
            let _ = peak.predict(clocks, expected, &mut self.stream.axis.exercise.covered);
        }
    }

    /// Marks that a result waits, and nobody was ready to take one since a reset that came upon
    /// another.
    fn watch_stall(&mut self) {
        if !self.resets.is_stalled || !self.port_state().is_waiting {
            return;
        }
        self.resets.is_stalled = false;
        let point = ResetPoint::In { state: ResetState::Stalled };
        if let Some(number) = self.table.number(point) {
            self.stream.axis.exercise.covered.mark(number);
        }
    }

    /// What the result ports show.
    fn port_state(&self) -> PortState {
        match &self.histogram {
            Some(_) => HistogramModel::state(&self.stream.axis),
            None => self.stream.axis.state(),
        }
    }

    /// So many cycles have shown.
    fn mark_codes(&mut self, cycles: u64) {
        for (source, code) in SourceIndex::all().zip(self.interface.source_codes.iter()) {
            if cycles > code.len()
                && let Some(point) = self.table.number(ScanPoint::CodeWraps { source })
            {
                self.stream.axis.exercise.covered.mark(point);
            }
        }
    }

    /// Goes on to the next group behind the cycle before `end`.
    fn go_on(&mut self, end: u64, last: bool) {
        let chips = self.interface.timing.scan.integration_chips;
        let delay = Some(self.delay());
        self.scan = match last {
            false => ScanState {
                group: Group(self.scan.group.0 + 1),
                from: end,
                chips,
                previous_delay: delay,
                ..self.scan
            },
            // The registers say what follows.
            true if self.hosted.is_some() => ScanState {
                lag: self.scan.lag,
                previous_delay: delay,
                ..Hosted::no_scan(self.scan.scan + 1, &self.interface)
            },
            true if self.interface.realigns() => ScanState {
                scan: self.scan.scan + 1,
                from: self.next_scan(end),
                ..ScanState::start(&self.interface)
            },
            true => ScanState {
                scan: self.scan.scan + 1,
                group: Group(0),
                from: end,
                chips,
                left_out: 0,
                // A scan over the whole period goes on where the one before it ended.
                lag: self.scan.lag,
                previous_delay: delay,
            },
        };
    }

    /// First cycle of the scan that follows one which ended before cycle `end`.
    fn next_scan(&self, end: u64) -> u64 {
        let next = self.interface.timing.next_scan_after(Chip(u128::from(end)));
        u64::try_from(next.0).unwrap_or(u64::MAX)
    }
}
