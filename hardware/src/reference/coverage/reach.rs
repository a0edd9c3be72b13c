//! Which cover points an interface has, and which of them nothing can reach.

use super::{BinPoint, CoverPoint, CoverTable, PeakKind, Place, ResetState};
use crate::scan::Step;
use crate::scene::{DetectorIndex, SourceIndex};
use crate::sensor::histogram::{CLOCKS_TO_ROW, HistogramPlan};
use crate::sensor::interface::{Correlator, Counting, Interface};

/// Most phase steps that are looked at for a sign: a code that has none in these has
/// hardly one at all.
const MOST_STEPS_LOOKED_AT: u64 = 1 << 16;
/// Hits for which a total's carry is waited.
const MOST_HITS: u64 = 1 << 22;

/// Clocks that may be spent on first losses row by row.
const MOST_CLOCKS_OF_LOSSES: u64 = 1 << 18;

const ONE_SIGN: &str = "no step has a chip of that sign for that lane";
const SHORT_STEPS: &str =
    "steps are shorter than the pipeline: a group's end is never that long ago";

/// Fills the table.
pub(super) fn fill(interface: &Interface, table: &mut CoverTable) {
    let detectors = interface.reference_codes.len();
    match &interface.counting {
        Counting::Correlator(correlator) => {
            for detector in DetectorIndex::first(detectors) {
                hits(interface, table, detector);
                counting(interface, correlator, table, detector);
                if correlator.peak.is_some() {
                    peaks(interface, table, detector);
                }
            }
            stream(interface, table);
            resets(interface, table);
            scans(interface, table);
        }
        Counting::Histogram(plan) => {
            for detector in DetectorIndex::first(detectors) {
                bins(plan, table, detector);
            }
            frames(interface, plan, table);
            resets(interface, table);
            codes(interface, table);
        }
    }
}

fn steps(interface: &Interface) -> std::ops::Range<usize> {
    // A scan of fewer steps than there are correlators leaves the last ones out.
    0..u64::from(interface.parallel()).min(interface.timing.scan.steps) as usize
}

fn bins(plan: &HistogramPlan, table: &mut CoverTable, detector: DetectorIndex) {
    let mut add = |point, hindrance: Option<&'static str>| {
        table.add_or(CoverPoint::Bin { detector, point }, hindrance);
    };
    for lane in 0..plan.row_bins {
        for later in [false, true] {
            let single = later && plan.periods == 1;
            let reason = single.then_some("a frame is a single code period");
            add(BinPoint::Hit { lane, later }, reason);
        }
        add(BinPoint::Emptied { lane }, None);
        for memory in 0..if plan.takes_turns() { 2 } else { 1 } {
            add(BinPoint::Top { lane, memory }, None);
        }
        if plan.saturates() {
            add(BinPoint::Full { lane }, None);
        }
    }
    for adder in 0..plan.adders() {
        for bit in 0..plan.bin_bits {
            add(BinPoint::Carry { adder, bit }, None);
        }
        if plan.adder_samples > 2 {
            add(BinPoint::Extra { adder }, None);
        }
        if plan.saturates() {
            add(BinPoint::Clamped { adder }, None);
        }
    }
    // Without a second sample a word after one with a hit has none.
    add(BinPoint::FullRow, None);
    for first in [false, true] {
        add(BinPoint::Border { first }, None);
    }
}

/// Rows of a frame: its first ones, one in the middle, and those round the places where
/// detectors change and the frame ends, as far as the reader is ahead of the stream.
pub(in crate::reference) fn rows_at_borders(
    interface: &Interface,
    plan: &HistogramPlan,
) -> Vec<usize> {
    let rows = plan.rows as usize;
    let detectors = interface.reference_codes.len();
    let ahead = CLOCKS_TO_ROW as usize + 2;
    let mut beats: Vec<usize> = vec![0, 1, 2, rows / 2];
    beats.extend((1..=detectors).flat_map(|d| d * rows - ahead..d * rows + 2));
    beats.retain(|&beat| beat < detectors * rows);
    beats.sort_unstable();
    beats.dedup();
    beats
}

/// Rows at which the first loss since reset is looked for: all of them, or where frames are
/// long those at borders. A loss takes two frames of its own.
pub(in crate::reference) fn rows_that_may_be_lost(
    interface: &Interface,
    plan: &HistogramPlan,
) -> Vec<usize> {
    let beats = interface.beats_of_group();
    let clocks = beats.saturating_mul(2 * interface.timing.scan.integration_chips);
    match clocks <= MOST_CLOCKS_OF_LOSSES {
        true => (0..beats as usize).collect(),
        false => rows_at_borders(interface, plan),
    }
}

/// What can become of the rows of a frame.
fn frames(interface: &Interface, plan: &HistogramPlan, table: &mut CoverTable) {
    let lost = rows_that_may_be_lost(interface, plan);
    for &beat in &lost {
        table.add(CoverPoint::Held { beat });
    }
    // Out of a single memory every row that is held, but the last, stands while one is lost.
    if plan.takes_turns() {
        let rows = plan.rows as usize;
        let detectors = 1..=interface.reference_codes.len();
        let mut beats = vec![0, 1, 2, rows / 2];
        beats.extend(detectors.flat_map(|d| [d * rows - 2, d * rows - 1, d * rows]));
        for beat in beats.into_iter().filter(|&beat| beat < interface.beats_of_group() as usize) {
            table.add(CoverPoint::HeldAcross { beat });
        }
    }
    for beat in lost {
        table.add(CoverPoint::FirstLost { beat });
    }
    for point in [
        CoverPoint::Lost { place: Place::Last },
        CoverPoint::LastHeldAcross,
        CoverPoint::BackToBack,
        CoverPoint::TooLate,
        CoverPoint::Burst,
        CoverPoint::AfterLost,
    ] {
        table.add(point);
    }
    for later_scan in [false, true] {
        let place = Place::Last;
        table.add(CoverPoint::Result { place, later_scan });
    }
}

fn hits(interface: &Interface, table: &mut CoverTable, detector: DetectorIndex) {
    let signs = Signs::of(interface, detector);
    for step in steps(interface) {
        for lane in 0..interface.lanes() {
            let reached = signs.reached(interface, step, lane);
            for up in [false, true] {
                let point = CoverPoint::Hit { detector, step, lane, up };
                table.add_or(point, (!reached[usize::from(up)]).then_some(ONE_SIGN));
            }
        }
    }
    if interface.lanes() >= 4 && signs.are_both() {
        for up in [false, true] {
            table.add(CoverPoint::FullWord { detector, up });
        }
    }
    table.add(CoverPoint::FirstSample { detector });
    table.add(CoverPoint::BeforeScan { detector });
    for first in [false, true] {
        let point = CoverPoint::StepBorder { detector, first };
        let single = first && interface.groups() == 1;
        table.add_or(point, single.then_some("a scan has a single group of steps"));
    }
}

fn counting(
    interface: &Interface,
    correlator: &Correlator,
    table: &mut CoverTable,
    detector: DetectorIndex,
) {
    let segments = correlator.count_segments;
    let borders = segments.borders();
    for step in steps(interface) {
        for bit in borders.clone().chain([segments.bits()]) {
            for up in [false, true] {
                table.add(CoverPoint::Carry { detector, step, bit, up });
            }
        }
        for bit in borders.clone() {
            table.add(CoverPoint::Borrow { detector, step, bit });
        }
    }
    if let Some(total) = correlator.total {
        for bit in borders.filter(|&bit| bit <= MOST_HITS.ilog2()) {
            for borrow in [false, true] {
                table.add(CoverPoint::TotalCarry { detector, bit, borrow });
            }
        }
        if total.saturates() {
            for beyond in [false, true] {
                table.add(CoverPoint::TotalSaturation { detector, beyond });
            }
        }
    }
    if !correlator.saturates() {
        return;
    }
    for up in [false, true] {
        for step in steps(interface) {
            table.add(CoverPoint::Limit { detector, step, up });
            table.add(CoverPoint::Saturation { detector, step, up });
        }
        let last_steps = interface.last_group_steps() as usize;
        for step in (0..last_steps).filter(|_| interface.groups() > 1) {
            table.add(CoverPoint::LastSaturation { detector, step, up });
        }
        for step in last_steps..interface.parallel() as usize {
            table.add(CoverPoint::AbsentSaturation { detector, step, up });
        }
    }
}

fn peaks(interface: &Interface, table: &mut CoverTable, detector: DetectorIndex) {
    let single = interface.timing.scan.steps == 1;
    if interface.parallel() > 1 {
        for step in steps(interface) {
            let kind = PeakKind::Step(step);
            table.add(CoverPoint::Peak { detector, kind });
        }
    }
    for kind in PeakKind::PLAIN {
        let hindrance = match kind {
            PeakKind::First | PeakKind::Equal if single => Some("a scan has a single step"),
            PeakKind::First if interface.groups() == 1 => {
                Some("a scan has a single group of steps")
            }
            _ => None,
        };
        table.add_or(CoverPoint::Peak { detector, kind }, hindrance);
    }
}

fn stream(interface: &Interface, table: &mut CoverTable) {
    let groups = interface.groups();
    let of_group = interface.reference_codes.len() * steps(interface).len();
    for beat in 0..of_group {
        table.add(CoverPoint::Held { beat });
        table.add(CoverPoint::HeldAcross { beat });
    }
    for place in places(groups) {
        table.add(CoverPoint::Lost { place });
    }
    for point in [CoverPoint::LastHeldAcross, CoverPoint::BackToBack, CoverPoint::TooLate] {
        table.add(point);
    }
    if of_group > 1 {
        let chips = interface.timing.scan.integration_chips;
        let hurried = chips < of_group as u64 && groups > 1;
        let reason = "a group has more results than its steps have clocks";
        table.add_or(CoverPoint::Burst, hurried.then_some(reason));
    }
}

/// The places that a scan of so many groups has.
fn places(groups: u64) -> impl Iterator<Item = Place> {
    [(Place::First, 2), (Place::Middle, 3), (Place::Last, 1)]
        .into_iter()
        .filter_map(move |(place, least)| (groups >= least).then_some(place))
}

fn resets(interface: &Interface, table: &mut CoverTable) {
    let chips = interface.timing.scan.integration_chips;
    for age in 0..=interface.result_latency_clocks {
        let point = CoverPoint::ResetAge { age };
        // Unless it is the end of a scan, and a pause follows.
        let hidden = u64::from(age) >= chips && !interface.realigns();
        table.add_or(point, hidden.then_some(SHORT_STEPS));
    }
    for age in 0..interface.clocks_of_hit() {
        table.add(CoverPoint::ResetHit { age });
    }
    if let Some(peak) = interface.peak() {
        for age in 0..peak.latency_clocks {
            let hidden = u64::from(age) >= interface.scan_clocks();
            table.add_or(CoverPoint::PeakReset { age }, hidden.then_some(SHORT_STEPS));
        }
    }
    if let Some(plan) = interface.histogram() {
        for beat in rows_at_borders(interface, plan) {
            table.add(CoverPoint::ResetAtRow { beat });
        }
    }
    let states = [
        (ResetState::OneClock, true),
        (ResetState::TwoClocks, true),
        (ResetState::Long, true),
        (ResetState::Waiting, true),
        (ResetState::Stalled, true),
        (ResetState::Overrun, true),
        (ResetState::Hit, true),
        (ResetState::Saturated, interface.saturates()),
        (ResetState::Pause, interface.realigns() && !ends_at_epochs(interface)),
    ];
    for (state, exists) in states {
        if exists {
            table.add(CoverPoint::Reset { state });
        }
    }
}

/// Whether every scan ends just before an epoch, so that none waits for one.
fn ends_at_epochs(interface: &Interface) -> bool {
    let period = interface.reference_codes[0].len();
    interface.scan_clocks().is_multiple_of(period)
}

fn scans(interface: &Interface, table: &mut CoverTable) {
    for later_scan in [false, true] {
        for place in places(interface.groups()) {
            table.add(CoverPoint::Result { place, later_scan });
        }
    }
    let scan = &interface.timing.scan;
    let parallel = u64::from(interface.parallel());
    let grows = (interface.groups() - 1) * parallel;
    let lanes = u64::from(interface.lanes());
    let past_chip = scan.first_step % lanes + grows >= lanes;
    let point = CoverPoint::DelayWraps { period: false };
    table.add_or(point, (!past_chip).then_some("a scan's steps lie within a chip"));
    let past_period = !interface.realigns() || scan.first_step + grows >= scan.steps_per_period;
    let point = CoverPoint::DelayWraps { period: true };
    let reason = "a scan's steps do not reach the code's end";
    table.add_or(point, (!past_period).then_some(reason));
    table.add(CoverPoint::WholeStep);
    table.add(CoverPoint::WholeScan);
    codes(interface, table);
}

fn codes(interface: &Interface, table: &mut CoverTable) {
    for source in SourceIndex::of(&interface.source_codes) {
        table.add(CoverPoint::CodeWraps { source });
    }
}

/// The signs of a detector's reference.
struct Signs {
    /// Ones among the first n chips.
    ones: Vec<u64>,
    lanes: u64,
    detector_period: u64,
}

impl Signs {
    fn of(interface: &Interface, detector: DetectorIndex) -> Signs {
        let code = &interface.reference_codes[detector];
        let mut sum = 0;
        let ones = std::iter::once(0).chain(code.chips.iter().map(|&chip| {
            sum += u64::from(chip);
            sum
        }));
        Signs {
            ones: ones.collect(),
            lanes: u64::from(interface.lanes()),
            detector_period: code.len(),
        }
    }

    fn are_both(&self) -> bool {
        let ones = self.ones[self.ones.len() - 1];
        ones > 0 && ones < self.detector_period
    }

    fn up_to(&self, chip: u64) -> u64 {
        let (periods, rest) = (chip / self.detector_period, chip % self.detector_period);
        periods * self.ones[self.ones.len() - 1] + self.ones[rest as usize]
    }

    /// Whether some step that is the `step`-th of its group counts a hit of a lane down,
    /// and up.
    fn reached(&self, interface: &Interface, step: usize, lane: u32) -> [bool; 2] {
        let (scan, parallel) = (&interface.timing.scan, u64::from(interface.parallel()));
        let period = self.detector_period * self.lanes;
        let integration = scan.integration_chips.min(self.detector_period);
        let mut reached = [false; 2];
        let groups = interface.groups().min(MOST_STEPS_LOOKED_AT);
        for group in 0..groups {
            let number = group * parallel + step as u64;
            if number >= scan.steps {
                break;
            }
            let start = (group % self.detector_period)
                * (scan.integration_chips % self.detector_period)
                % self.detector_period;
            let sample = start * self.lanes + u64::from(lane) + period
                - scan.phase_step(Step(number)) % period;
            let chip = sample / self.lanes;
            let ups = self.up_to(chip + integration) - self.up_to(chip);
            reached[1] |= ups > 0;
            reached[0] |= ups < integration;
            if reached == [true; 2] {
                break;
            }
        }
        reached
    }
}
