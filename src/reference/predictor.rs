//! Predicts every output port of `sensor_top` at every clock.
//!
//! The work follows events, not clocks: chips are copied period by period from
//! the code table, counts change only where there is a hit, and the result
//! stream only where a result arrives or is taken.

use crate::scene::{DetectorIndex, SourceIndex};
use std::ops::Range;
use std::sync::Arc;

use super::canvas::{Canvas, Changes, EveryClock};
use super::coverage::{CoverPoint, CoverTable, Place, Running};
use super::exercise::{Counted, Exercise};
use super::histogram::HistogramModel;
use super::pattern::{ChipPattern, chip_patterns};
use super::peak_ports::PeakPorts;
use super::resets::{ResetWatch, Upon};
use super::stream::{Arrival, Beat, ResultStream};
use crate::scan::{Group, Step};
use crate::sensor::interface::Interface;
use crate::sensor::layout::{Layout, mask};

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
pub struct Position {
    /// First clock without reset.
    pub released: u64,
    /// Number of the scan since then.
    pub scan: u64,
    /// The present group, or the next.
    pub group: Group,
    /// First cycle of it.
    pub from: u64,
}

impl Position {
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

/// Why a interface cannot be predicted.
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
pub struct Reference {
    interface: Interface,
    /// chi of the chips of each detector's reference (eq. 10).
    signs: Vec<Vec<i8>>,
    chips: Vec<ChipPattern>,
    words: usize,
    stream: ResultStream,
    peak: Option<PeakPorts>,
    /// In place of counts and stream, if the hardware keeps a histogram.
    histogram: Option<HistogramModel>,
    /// First clock without reset; before it every output is 0.
    released: u64,
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

/// The signs with which one group's correlators count hits, for one detector.
#[derive(Debug, Clone, Copy)]
pub struct GroupSigns<'a> {
    /// Of each chip of the detector's code.
    signs: &'a [i8],
    /// log2 of the samples per chip.
    lanes_log2: u32,
    /// Sample of the code's period that the group's first step has at the group's first.
    first: u64,
}

impl GroupSigns<'_> {
    /// Whether the correlator of the group's step `step` counts a hit up at a sample,
    /// numbered from the group's first.
    pub fn counts_up(&self, step: u64, sample: u64) -> bool {
        let period = (self.signs.len() as u64) << self.lanes_log2;
        // Almost never: a division costs more than all the rest.
        let step = if step < period { step } else { step % period };
        let delayed = (self.first + sample + period - step) % period;
        self.signs[(delayed >> self.lanes_log2) as usize] > 0
    }
}

impl Reference {
    /// A model of the hardware with this interface.
    ///
    /// # Errors
    /// When the interface asks for hardware that is not modelled.
    pub fn new(interface: Interface) -> Result<Reference, ReferenceError> {
        let lengths = interface.reference_codes.iter().map(|code| code.len());
        if lengths
            .clone()
            .any(|length| length != interface.reference_codes[0].len())
        {
            return Err(ReferenceError::CodeLengths(lengths.collect()));
        }
        let layout = Layout::of(&interface);
        let place = |name| {
            let field = layout.outputs.field(name);
            (field.word, field.shift)
        };
        let table = CoverTable::of(&interface);
        Ok(Reference {
            signs: interface
                .reference_codes
                .iter()
                .map(|code| code.chips.iter().map(|&chip| 2 * chip as i8 - 1).collect())
                .collect(),
            chips: chip_patterns(&interface, place("o_laser"), place("o_epoch")),
            words: layout.outputs.words,
            stream: ResultStream::new(&interface, &layout, Arc::clone(&table)),
            peak: PeakPorts::new(&interface, &layout),
            histogram: HistogramModel::new(&interface, &layout, Arc::clone(&table)),
            released: 0,
            scan: ScanState::start(&interface),
            table,
            running: Running::of(&interface),
            resets: ResetWatch::of(&interface),
            before_scan: vec![false; interface.reference_codes.len()],
            counts: match interface.histogram {
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
    pub fn position(&self) -> Position {
        Position {
            released: self.released,
            scan: self.scan.scan,
            group: self.scan.group,
            from: self.scan.from,
        }
    }

    /// How the present group's correlators of a detector count.
    pub fn group_signs(&self, detector: DetectorIndex) -> GroupSigns<'_> {
        let signs = &self.signs[detector][..];
        let lanes = u64::from(self.interface.lanes());
        let period = signs.len() as u64 * lanes;
        let first = self.scan.from % signs.len() as u64 * lanes;
        GroupSigns {
            signs,
            lanes_log2: lanes.ilog2(),
            first: (first + period - self.delay() % period) % period,
        }
    }

    /// What the outputs have shown in the blocks predicted so far.
    pub fn exercise(&self) -> &Exercise {
        &self.stream.exercise
    }

    /// Predicts a block. Blocks follow one another without a gap.
    ///
    /// `hits` are, for each detector, the first samples of the runs of high
    /// samples that start in the block, in order, numbered as in
    /// [`super::level::Level::paint`]. `expected` has `words()` entries per
    /// clock and is overwritten.
    pub fn predict(&mut self, block: &Surroundings, hits: &[Vec<u64>], expected: &mut [u64]) {
        expected.fill(0);
        let mut every_clock = EveryClock {
            first_clock: block.clocks.start,
            words: self.words,
            records: expected,
        };
        self.predict_into(block, hits, &mut every_clock);
    }

    /// [`Reference::predict`], of blocks of any length, and only where outputs change
    /// that do not follow a code. What holds at a block's end changes there, and back
    /// at the next one's start.
    pub fn predict_changes(
        &mut self,
        block: &Surroundings,
        hits: &[Vec<u64>],
        changes: &mut Changes,
    ) {
        self.predict_into(block, hits, changes);
    }

    fn predict_into(
        &mut self,
        block: &Surroundings,
        hits: &[Vec<u64>],
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
            if clock < self.released {
                clock = self.released.min(block.clocks.end);
                continue;
            }
            let mut until = block.clocks.end;
            if let Some(reset) = resets.peek() {
                until = until.min(reset.start);
            }
            if let Some(skip) = skips.peek() {
                until = until.min(skip.clock);
            }
            self.predict_released(clock..until, block, hits, expected);
            clock = until;
        }
    }

    fn reset(&mut self, reset: &Range<u64>, hits: &[Vec<u64>]) {
        // One that reaches into this block was told in the block before, too, perhaps
        // with an end that was not known yet.
        if reset.start >= self.released {
            self.stream.exercise.resets += 1;
            let in_pause = self.scan.group == Group(0)
                && self.scan.scan > 0
                && reset.start < self.released + 1 + self.scan.from;
            let lanes = u64::from(self.interface.lanes());
            let word = reset.start * lanes..(reset.start + 1) * lanes;
            let has_hit = |hits: &Vec<u64>| {
                let at = hits.partition_point(|&hit| hit < word.start);
                hits.get(at).is_some_and(|hit| word.contains(hit))
            };
            let upon = Upon {
                in_pause,
                has_hit: hits.iter().any(has_hit),
                ports: match &self.histogram {
                    Some(histogram) => histogram.state(),
                    None => self.stream.state(),
                },
            };
            self.resets.enters(reset, upon, &self.table);
        }
        self.released = reset.end;
        self.scan = ScanState::start(&self.interface);
        self.counts.fill(0);
        self.totals.fill(0);
        self.running.reset();
        self.before_scan.fill(false);
        self.stream.reset();
        if let Some(histogram) = &mut self.histogram {
            histogram.reset();
        }
        if let Some(peak) = &mut self.peak {
            peak.reset();
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
        hits: &[Vec<u64>],
        expected: &mut impl Canvas,
    ) {
        for pattern in &self.chips {
            expected.or_code(pattern, clocks.clone(), clocks.start - self.released);
        }
        self.mark_codes(clocks.end - self.released);
        self.count(clocks.clone(), hits);
        if let Some(histogram) = &mut self.histogram {
            let exercise = &mut self.stream.exercise;
            return histogram.predict(clocks, &block.stalls, expected, exercise);
        }
        self.stream.predict(clocks.clone(), &block.stalls, expected);
        if let Some(peak) = &mut self.peak {
            peak.predict(clocks, expected, &mut self.stream.exercise.covered);
        }
    }

    /// So many cycles have shown.
    fn mark_codes(&mut self, cycles: u64) {
        for (source, code) in SourceIndex::all().zip(self.interface.source_codes.iter()) {
            if cycles > code.len()
                && let Some(point) = self.table.number(CoverPoint::CodeWraps { source })
            {
                self.stream.exercise.covered.mark(point);
            }
        }
    }

    /// Looks for hits on the last sample before a scan, if its clock is among these.
    fn watch_before_scan(&mut self, clocks: &Range<u64>, hits: &[Vec<u64>]) {
        let first_word = self.released + 1 + self.scan.from;
        let may_pause = self.scan.scan == 0 || self.interface.realigns();
        if self.scan.group != Group(0) || !may_pause || !clocks.contains(&(first_word - 1)) {
            return;
        }
        let sample = first_word * u64::from(self.interface.lanes()) - 1;
        for (seen, hits) in self.before_scan.iter_mut().zip(hits) {
            *seen = hits.binary_search(&sample).is_ok();
        }
    }

    /// Counts the hits of a stretch of clocks, group by group, and ends the
    /// groups whose last word is among them. The word of cycle n is presented
    /// one clock after the chip of cycle n shows on `o_laser`.
    fn count(&mut self, clocks: Range<u64>, hits: &[Vec<u64>]) {
        let lanes = u64::from(self.interface.lanes());
        let first_word = self.released + 1;
        let mut counted = clocks.start.max(first_word);
        loop {
            self.watch_before_scan(&clocks, hits);
            let group_end = first_word + self.scan.from + self.scan.chips;
            let until = group_end.min(clocks.end);
            let from = counted.max(first_word + self.scan.from);
            if from < until {
                for (detector, hits) in DetectorIndex::all().zip(hits.iter()) {
                    let first = hits.partition_point(|&s| s < from * lanes);
                    let end = first + hits[first..].partition_point(|&s| s < until * lanes);
                    self.count_detector(detector, &hits[first..end]);
                }
            }
            if group_end > clocks.end {
                return;
            }
            self.finish_group();
            counted = until;
        }
    }

    /// Counts one detector's hits up or down (eq. 11) in the present group.
    fn count_detector(&mut self, detector: DetectorIndex, hits: &[u64]) {
        let (Some(first_hit), Some(last_hit)) = (hits.first(), hits.last()) else {
            return;
        };
        let lanes_log2 = self.interface.lanes().trailing_zeros();
        let lane_of = |sample: u64| (sample & ((1 << lanes_log2) - 1)) as u32;
        if let Some(histogram) = &mut self.histogram {
            let first_sample = (self.released + 1) << lanes_log2;
            let frame_start = first_sample + (self.scan.from << lanes_log2);
            let samples = (first_sample, frame_start);
            return histogram.count(detector, hits, samples, &mut self.resets);
        }
        let delay = self.delay();
        let signs = &self.signs[detector][..];
        let steps_per_period = (signs.len() as u64) << lanes_log2;
        let parallel = u64::from(self.interface.parallel());
        let first_sample = (self.released + 1) << lanes_log2;
        self.totals[detector] += hits.len() as u64;
        let counts = &mut self.counts[detector.0 * parallel as usize..][..parallel as usize];
        let mut words = hits.chunk_by(|a, b| a >> lanes_log2 == b >> lanes_log2);
        // Start of a code period that is not after the sample.
        let mut period_start = first_sample;
        for word in &mut words {
            for &sample in word {
                // A division costs more than all the rest, and many hits share a period.
                if sample - period_start >= steps_per_period {
                    period_start = sample - (sample - period_start) % steps_per_period;
                }
                let mut delayed = sample - period_start + steps_per_period - delay;
                if delayed >= steps_per_period {
                    delayed -= steps_per_period;
                }
                for (step, count) in counts.iter_mut().enumerate() {
                    let sign = signs[(delayed >> lanes_log2) as usize];
                    *count += i64::from(sign);
                    self.running.hit(detector, step, lane_of(sample), sign > 0);
                    delayed = delayed.checked_sub(1).unwrap_or(steps_per_period - 1);
                }
            }
            self.running.word_ends(detector, word.len() as u32);
            self.resets.hits_in(word[0] >> lanes_log2);
        }
        let group_start = first_sample + (self.scan.from << lanes_log2);
        // A group may be as long as 64 bits tell, its end farther than they do.
        let last_sample = (self.scan.chips << lanes_log2) - 1;
        let first = *first_hit == group_start;
        let last = last_hit.checked_sub(group_start) == Some(last_sample);
        self.running.border(detector, first, last);
    }

    /// Sends the present group's counts on their way and goes on to the next.
    fn finish_group(&mut self) {
        let end = self.scan.from + self.scan.chips;
        if let Some(histogram) = &mut self.histogram {
            let exercise = &mut self.stream.exercise;
            let last_word = self.released + end;
            histogram.end_frame(last_word, self.scan.scan, &mut self.resets, exercise);
            return self.go_on(end, true);
        }
        let grouping = self.interface.grouping();
        let last = grouping.is_last(self.scan.group);
        let shows_at = self.released + end + u64::from(self.interface.result_latency_clocks);
        let (beats, clamps) = self.beats(shows_at);
        let saturated = clamps.counts + clamps.totals > 0;
        let proves = self.proven_points();
        self.stream.exercise.phase_steps += grouping.steps_of(self.scan.group).count() as u64;
        let is_counted = self.totals.iter().any(|&total| total > 0);
        self.resets
            .group_ends(self.released + end, last, is_counted);
        self.stream.push(Arrival {
            clock: shows_at,
            beats,
            saturated,
            last,
            place: Place::of(self.scan.group.0, self.interface.groups()),
            proves,
            proves_if_first: clamps
                .lone_point()
                .and_then(|point| self.table.number(point)),
        });
        if let Some(peak) = self.peak.as_mut().filter(|_| last) {
            peak.end_scan(self.released + end, &mut self.resets.of_peaks, &self.table);
        }
        self.counts.fill(0);
        self.totals.fill(0);
        self.go_on(end, last);
    }

    /// The results of the present group, in the order in which they are sent, and what
    /// was saturated.
    fn beats(&mut self, shows_at: u64) -> (Vec<Beat>, Clamps) {
        let parallel = self.interface.parallel() as usize;
        let grouping = self.interface.grouping();
        let steps = grouping.steps_of(self.scan.group).len();
        let first = grouping.step_of(self.scan.group, 0).0;
        let limit = 1i128 << (self.interface.count_bits - 1);
        let most = self
            .interface
            .total
            .map_or(u64::MAX, |total| mask(total.bits));
        let mut beats = Vec::with_capacity(self.counts.len());
        let mut clamps = Clamps::default();
        for (detector, counts) in DetectorIndex::all().zip(self.counts.chunks_exact(parallel)) {
            let total = self.totals[detector].min(most);
            if total != self.totals[detector] {
                clamps.totals += 1;
                clamps.total = detector;
            }
            for (step, &exact) in counts.iter().enumerate() {
                let count = i128::from(exact).clamp(-limit, limit - 1) as i64;
                let is_absent = step >= steps;
                clamps.count(is_absent, count != exact, (detector, step, exact > 0));
                if is_absent {
                    continue;
                }
                beats.push(Beat {
                    count,
                    total,
                    counted: Counted::new(detector, exact, self.totals[detector]),
                });
                let number = first + step as u64;
                if let Some(peak) = &mut self.peak {
                    // It counts the steps that it has seen.
                    let seen = Step(number - self.scan.left_out);
                    peak.count(
                        (detector, step),
                        self.interface.timing.scan.phase_step(seen),
                        count,
                        self.scan.group,
                    );
                }
                self.finished.push(StepResult {
                    clock: shows_at,
                    scan: self.scan.scan,
                    detector,
                    step: number,
                    count,
                    total,
                    exact,
                    exact_total: self.totals[detector],
                });
            }
        }
        (beats, clamps)
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

    /// Cover points that the results of the present group prove when they show.
    fn proven_points(&mut self) -> Vec<usize> {
        let parallel = u64::from(self.interface.parallel());
        let steps = self.interface.grouping().steps_of(self.scan.group).len();
        let begins_scan = self.scan.group.0 * parallel == self.scan.left_out;
        let mut points = self.running.end_group(&self.table, steps, begins_scan);
        let delay = self.delay();
        let mut add = |point| points.extend(self.table.number(point));
        for (detector, seen) in DetectorIndex::all().zip(self.before_scan.iter_mut()) {
            if std::mem::take(seen) {
                add(CoverPoint::BeforeScan { detector });
            }
        }
        if self.interface.saturates() {
            let limit = 1i64 << (self.interface.count_bits - 1);
            for (at, &count) in self.counts.iter().enumerate() {
                let detector = DetectorIndex(at / self.interface.parallel() as usize);
                let step = at % self.interface.parallel() as usize;
                if step < steps && (count == limit - 1 || count == -limit) {
                    let up = count > 0;
                    add(CoverPoint::Limit { detector, step, up });
                }
            }
            for (detector, &total) in DetectorIndex::all().zip(self.totals.iter()) {
                if self.interface.total.is_some_and(|t| total == mask(t.bits)) {
                    let beyond = false;
                    add(CoverPoint::TotalSaturation { detector, beyond });
                }
            }
        }
        if self.totals.iter().any(|&total| total > 0) {
            let place = Place::of(self.scan.group.0, self.interface.groups());
            let later_scan = self.scan.scan > 0;
            add(CoverPoint::Result { place, later_scan });
            if self.scan.chips == self.interface.timing.scan.integration_chips {
                add(CoverPoint::WholeStep);
            }
            if place == Place::Last && self.scan.left_out == 0 {
                add(CoverPoint::WholeScan);
            }
            let lanes = u64::from(self.interface.lanes());
            if let Some(previous) = self.scan.previous_delay {
                let period = previous > delay;
                if period || previous / lanes < delay / lanes {
                    add(CoverPoint::DelayWraps { period });
                }
            }
        }
        points.append(&mut self.resets.of_results);
        points
    }

    /// First cycle of the scan that follows one which ended before cycle `end`.
    fn next_scan(&self, end: u64) -> u64 {
        let next = self.interface.timing.next_scan_after(u128::from(end));
        u64::try_from(next).unwrap_or(u64::MAX)
    }
}

/// What was saturated in a group.
#[derive(Debug, Default)]
struct Clamps {
    counts: u32,
    totals: u32,
    absent: u32,
    /// The last of each kind: detector, step, whether beyond the largest count.
    count: (DetectorIndex, usize, bool),
    absent_count: (DetectorIndex, usize, bool),
    total: DetectorIndex,
}

impl Clamps {
    fn count(&mut self, is_absent: bool, is_clamped: bool, which: (DetectorIndex, usize, bool)) {
        if is_clamped && is_absent {
            self.absent += 1;
            self.absent_count = which;
        } else if is_clamped {
            self.counts += 1;
            self.count = which;
        }
    }

    /// The one thing that was saturated, if there is only one.
    fn lone_point(&self) -> Option<CoverPoint> {
        match (self.counts, self.totals, self.absent) {
            (1, 0, _) => {
                let (detector, step, up) = self.count;
                Some(CoverPoint::Saturation { detector, step, up })
            }
            (0, 0, 1) => {
                let (detector, step, up) = self.absent_count;
                Some(CoverPoint::AbsentSaturation { detector, step, up })
            }
            (0, 1, 0) => Some(CoverPoint::TotalSaturation {
                detector: self.total,
                beyond: true,
            }),
            _ => None,
        }
    }
}
