//! Scans as a host sets them: when settings are taken over, when the codes begin, and what follows a scan.

use std::ops::Range;
use std::sync::Arc;

use super::{ReferenceModel, ScanState, Surroundings};
use crate::reference::canvas::Canvas;
use crate::reference::coverage::registers::{extremes, taken};
use crate::reference::coverage::{Extreme, RegisterPoint, ScanStart};
use crate::reference::host::HardwareEvent;
use crate::reference::host_ports::HostOutputs;
use crate::reference::pattern::chip_patterns;
use crate::reference::registers::{RegisterModel, ScanEvent, Sequence};
use crate::scan::{CHIPS_TO_PREPARATION, Group, Sample};
use crate::sensor::interface::Interface;
use crate::sensor::layout::Layout;
use crate::sensor::port::PortRole;
use crate::sensor::registers::{CHIPS_AHEAD, Settings};

use super::hosted_track::HostedTrack;

/// Settings by their numbers.
const GROUPS: usize = 1;
const FIRST_STEP: usize = 2;

/// No cycle of any run.
pub(super) const NEVER: u64 = u64::MAX / 4;

/// The registers, and where the scans stand that they ask for.
#[derive(Debug, Clone)]
pub(super) struct Hosted {
    registers: RegisterModel,
    /// As the scene has it; scans have its settings changed.
    base: Interface,
    /// Places of lasers and epoch.
    places: [(usize, u32); 2],
    phase: Phase,
    /// What has been read of the settings.
    words: Vec<u32>,
    /// First clock at which the lasers are dark.
    dark_from: u64,
    /// Whether the present scan has ended.
    has_ended: bool,
    /// First clock that is not predicted yet.
    next_clock: u64,
    /// How the next scan begins, if not behind another.
    start: Option<ScanStart>,
    /// The settings of the last take-over that fitted.
    last_words: Vec<u32>,
    /// Cover points that the next result with a hit proves, and those that the present scan's last one does.
    proves: Vec<RegisterPoint>,
    last_proves: Vec<RegisterPoint>,
    /// Counts of the present group if its scan began one step from where it does, at an end of the code period.
    pub(super) beside: Option<StepBeside>,
    /// What follows a target, if the hardware does.
    track: Option<HostedTrack>,
}

/// A scan that begins one step from the present one's first step, which is at an end of the code period: counts that
/// differ prove that step.
#[derive(Debug, Clone)]
pub(super) struct StepBeside {
    /// The end, whose cover point it is.
    extreme: Extreme,
    /// Counts of the present group, as [`ReferenceModel::counts`].
    pub(super) counts: Vec<i64>,
}

impl StepBeside {
    /// By how much its delay is larger, modulo a period of so many samples.
    pub(super) fn later(&self, period: u64) -> u64 {
        match self.extreme {
            Extreme::Least => 1,
            Extreme::Most => period - 1,
        }
    }
}

/// What the hardware is at.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Phase {
    /// It waits until scans are wanted.
    Idle,
    /// Settings are taken over, the first at this clock.
    Takes { from: u64 },
    /// Codes run.
    On,
}

impl Hosted {
    pub(super) fn new(interface: &Interface, layout: &Layout) -> Option<Box<Hosted>> {
        let place = |role| layout.outputs.place(role);
        Some(Box::new(Hosted {
            registers: RegisterModel::new(interface, layout)?,
            base: interface.clone(),
            places: [place(PortRole::Laser), place(PortRole::Epoch)],
            phase: Phase::Idle,
            words: Vec::new(),
            dark_from: 0,
            has_ended: true,
            next_clock: 0,
            start: None,
            last_words: Vec::new(),
            proves: Vec::new(),
            last_proves: Vec::new(),
            beside: None,
            track: interface.track().map(|plan| HostedTrack::new(*plan)),
        }))
    }

    /// As reset leaves it.
    pub(super) fn reset(&mut self) {
        self.registers.reset();
        self.phase = Phase::Idle;
        self.dark_from = 0;
        self.has_ended = true;
        self.start = None;
        self.proves.clear();
        self.last_proves.clear();
        self.beside = None;
        if let Some(track) = &mut self.track {
            track.reset();
        }
    }

    /// Scans are wanted, and the next one need not wait for what follows of the last.
    fn may_begin(&self, clock: u64) -> bool {
        self.registers.go() && !self.track.as_ref().is_some_and(|track| track.waits(clock))
    }

    /// A count of the present scan.
    pub(super) fn count(&mut self, count: i64) {
        if let Some(track) = &mut self.track {
            track.counts.push(count);
        }
    }

    /// Cover points that a result with a hit proves, the last one of its scan or not.
    pub(super) fn take_proven(&mut self, is_last: bool) -> Vec<RegisterPoint> {
        let mut proven = std::mem::take(&mut self.proves);
        if is_last {
            proven.append(&mut self.last_proves);
        }
        proven
    }

    /// A group has ended: whether its counts, as they are shown, prove the first step of its scan.
    pub(super) fn compare_beside(&mut self, counts: &[i64], shown: impl Fn(i64) -> i64) {
        let Some(beside) = &mut self.beside else {
            return;
        };
        let pairs = counts.iter().zip(&beside.counts);
        if pairs.into_iter().any(|(&one, &other)| shown(one) != shown(other)) {
            self.proves
                .push(RegisterPoint::Extreme { setting: FIRST_STEP, extreme: beside.extreme });
        }
        beside.counts.fill(0);
    }

    /// A scan's last word has come; its last counts are told at `clock`.
    pub(super) fn scan_ends(&mut self, clock: u64) {
        self.has_ended = true;
        self.registers.tell(clock, ScanEvent::ScanCounted);
        if let Some(track) = &mut self.track {
            track.window_ends(clock, &mut self.registers);
        }
    }

    /// The scan that comes after one which nothing is known to follow.
    pub(super) fn no_scan(scan: u64, interface: &Interface) -> ScanState {
        ScanState { scan, from: NEVER, ..ScanState::start(interface) }
    }
}

impl ReferenceModel {
    /// What the slave of the registers shows after the blocks predicted so far.
    pub fn host_outputs(&self) -> HostOutputs {
        self.hosted.as_ref().map(|hosted| hosted.registers.shown()).unwrap_or_default()
    }

    /// Whether something happens to the registers in the clock behind the next one, as far as the clocks predicted so
    /// far tell: of a loss, that the stream is not free yet.
    pub(in crate::reference) fn comes(&self, event: HardwareEvent) -> bool {
        let Some(hosted) = &self.hosted else {
            return false;
        };
        let next = hosted.next_clock;
        let arrival = self.stream.next_arrival().filter(|arrival| arrival.clock == next);
        match event {
            HardwareEvent::TakeOver => hosted.phase == Phase::Idle && hosted.may_begin(next),
            HardwareEvent::Refusal => {
                let plan = hosted.registers.plan();
                let settings = plan.settings() as u64;
                matches!(hosted.phase, Phase::Takes { from } if next == from + settings + 1)
                    && !plan.fits(&hosted.registers.settings(&hosted.words))
            }
            HardwareEvent::Loss => arrival.is_some() && self.stream.axis.now.is_valid,
            HardwareEvent::Clamp => arrival.is_some_and(|arrival| arrival.saturated),
            HardwareEvent::TargetLost => hosted.registers.is_told(next + 1, event),
        }
    }

    /// Where the peak of the target that is followed is, in phase steps, and whether the last window had its light; after
    /// the blocks predicted so far, and what follows of them.
    pub fn target(&self) -> Option<(f64, bool)> {
        self.hosted.as_ref()?.track.as_ref()?.target()
    }

    /// A stretch of clocks without reset, of hardware with registers.
    pub(super) fn predict_hosted(
        &mut self,
        mut hosted: Box<Hosted>,
        clocks: Range<u64>,
        block: &Surroundings,
        hits: &[Vec<Sample>],
        expected: &mut impl Canvas,
    ) {
        let mut clock = clocks.start;
        while clock < clocks.end {
            clock = match hosted.phase {
                Phase::On => {
                    let group_end = self.released + 1 + self.scan.from + self.scan.chips;
                    let until = clocks.end.min(group_end.max(clock + 1));
                    hosted = self.predict_counts(hosted, clock..until, block, hits, expected);
                    self.go_through_scan(&mut hosted, clock..until, block, expected);
                    until
                }
                Phase::Idle | Phase::Takes { .. } => {
                    let until = match hosted.phase {
                        Phase::Idle if !hosted.registers.go() && hosted.registers.is_quiet() => {
                            let next = block.host.iter().find(|(range, _)| range.end > clock);
                            let next = next.map_or(clocks.end, |(range, _)| range.start);
                            next.clamp(clock + 1, clocks.end)
                        }
                        _ => clock + 1,
                    };
                    hosted = self.predict_counts(hosted, clock..until, block, hits, expected);
                    self.prepare(&mut hosted, clock..until, block, expected);
                    until
                }
            };
        }
        hosted.next_clock = clocks.end;
        for point in hosted.registers.take_points() {
            if let Some(number) = self.table.number(point) {
                self.stream.axis.exercise.covered.mark(number);
            }
        }
        self.hosted = Some(hosted);
    }

    /// Codes, counts, results and peaks of a stretch of clocks.
    fn predict_counts(
        &mut self,
        mut hosted: Box<Hosted>,
        clocks: Range<u64>,
        block: &Surroundings,
        hits: &[Vec<Sample>],
        expected: &mut impl Canvas,
    ) -> Box<Hosted> {
        let dark_from = match hosted.phase {
            Phase::On => u64::MAX,
            _ => hosted.dark_from,
        };
        let lit = clocks.start.max(self.released)..clocks.end.min(dark_from);
        if !lit.is_empty() {
            for pattern in &self.chips {
                expected.or_code(pattern, lit.clone(), lit.start - self.released);
            }
            self.mark_codes(lit.end - self.released);
        }
        if hosted.phase == Phase::On {
            hosted.has_ended = false;
            self.hosted = Some(hosted);
            self.count(clocks.clone(), block, hits);
            hosted = self.hosted.take().expect("it was put there");
        }
        self.stream.predict(clocks.clone(), &block.stalls, expected);
        for (clock, told) in self.stream.take_told() {
            hosted.registers.tell(clock, told);
        }
        if let Some(peak) = &mut self.peak {
            for (clock, peaks) in
                peak.predict(clocks, expected, &mut self.stream.axis.exercise.covered)
            {
                if let Some(track) = &mut hosted.track {
                    track.scan_found(clock, peaks[0], &mut hosted.registers);
                }
                hosted.registers.tell(clock, ScanEvent::Peaks(peaks));
            }
        }
        hosted
    }

    /// A stretch of a scan, which may be its last.
    fn go_through_scan(
        &mut self,
        hosted: &mut Hosted,
        clocks: Range<u64>,
        block: &Surroundings,
        expected: &mut impl Canvas,
    ) {
        let busy = Sequence { busy: true, ..Sequence::default() };
        if !hosted.has_ended {
            return hosted.registers.run(clocks, &block.host, busy, expected);
        }
        let last = clocks.end - 1;
        hosted.registers.run(clocks.start..last, &block.host, busy, expected);
        let (go, changed) = (hosted.may_begin(last), hosted.registers.changed());
        hosted.registers.run(last..clocks.end, &block.host, busy, expected);
        let end = last - self.released;
        let to_epoch = end.next_multiple_of(hosted.registers.plan().period_chips) - end;
        let how = match (go && !changed, self.interface.realigns()) {
            (true, false) => Some(ScanStart::GoesOn),
            (true, true) => (to_epoch <= CHIPS_TO_PREPARATION).then_some(ScanStart::EndsAtEpoch),
            (false, realigns) if go && !realigns => Some(ScanStart::ChangedWhole),
            // What follows of a scan is waited for.
            (false, _) if hosted.registers.go() && !go => None,
            (false, false) if !changed => Some(ScanStart::AfterStopWhole),
            (false, _) => Some(if go { ScanStart::Changed } else { ScanStart::AfterStop }),
        };
        if go && !changed {
            hosted.proves.extend(how.map(|how| RegisterPoint::Began { how }));
            self.scan = match self.interface.realigns() {
                true => ScanState {
                    scan: self.scan.scan,
                    from: self.next_scan(end),
                    ..ScanState::start(&self.interface)
                },
                // It goes on where the one before it ended.
                false => ScanState { from: end, ..self.scan },
            };
            hosted.has_ended = false;
        } else {
            hosted.start = how;
            hosted.phase = Phase::Idle;
            hosted.dark_from = last + 1 + CHIPS_AHEAD;
        }
    }

    /// Clocks without a scan: one, or many in which nothing happens.
    fn prepare(
        &mut self,
        hosted: &mut Hosted,
        clocks: Range<u64>,
        block: &Surroundings,
        expected: &mut impl Canvas,
    ) {
        let clock = clocks.start;
        let settings = hosted.registers.plan().settings() as u64;
        let mut sequence = Sequence::default();
        let mut next = hosted.phase;
        match hosted.phase {
            Phase::Idle if hosted.may_begin(clock) => {
                next = Phase::Takes { from: clock + 1 };
            }
            Phase::Idle if !hosted.registers.go() => {
                if let Some(track) = &mut hosted.track {
                    track.stops(clocks.end - 1);
                }
            }
            Phase::Takes { from } => {
                let at = clock - from;
                sequence.busy = true;
                if at < settings {
                    let word = hosted.registers.setting(at as usize);
                    if at == 0 {
                        hosted.words.clear();
                        if let Some(track) = &mut hosted.track {
                            track.begins();
                        }
                        if !hosted.registers.runs() {
                            hosted.start = Some(ScanStart::Single);
                        }
                    }
                    hosted.words.push(word);
                    sequence.taken = Some(at as usize);
                } else if at == settings + 2 {
                    let mut settings = hosted.registers.settings(&hosted.words);
                    if let Some(track) = &mut hosted.track {
                        track.takes(&mut settings);
                    }
                    sequence.refused = !hosted.registers.plan().fits(&settings);
                    if sequence.refused {
                        hosted.start = Some(ScanStart::AfterStop);
                        if let Some(track) = &mut hosted.track {
                            track.refused();
                        }
                        let plan = Arc::clone(hosted.registers.plan());
                        let is_bad = [
                            settings.chips < plan.least_chips,
                            settings.groups == 0,
                            settings.first_step >> plan.sample_bits >= plan.period_chips,
                        ];
                        let bad = is_bad.into_iter().enumerate().filter(|(_, is)| *is);
                        for (setting, _) in bad {
                            let number = self.table.number(RegisterPoint::Refused { setting });
                            number.map(|number| self.stream.axis.exercise.covered.mark(number));
                        }
                    }
                    next = if sequence.refused { Phase::Idle } else { Phase::On };
                    if !sequence.refused {
                        self.take_over(hosted, &settings, clock + 1 + CHIPS_AHEAD);
                    }
                }
            }
            _ => {}
        }
        hosted.registers.run(clocks, &block.host, sequence, expected);
        hosted.phase = next;
    }

    /// Scans have these settings from now on; the lasers show their codes' first chips after the rising edge of
    /// `released`.
    fn take_over(&mut self, hosted: &mut Hosted, settings: &Settings, released: u64) {
        let plan = Arc::clone(hosted.registers.plan());
        let how = hosted.start.take().map(|how| RegisterPoint::Began { how });
        hosted.proves.clear();
        hosted.proves.extend(how);
        hosted.proves.extend(taken(&plan, &hosted.words, &hosted.last_words));
        hosted.last_proves.clear();
        hosted.beside = None;
        let is_window = hosted.track.as_ref().is_some_and(HostedTrack::is_window);
        for (setting, extreme) in extremes(&plan, &hosted.words) {
            let point = RegisterPoint::Extreme { setting, extreme };
            match setting {
                // A window has groups and first step of its own.
                GROUPS | FIRST_STEP if is_window => {}
                GROUPS => hosted.last_proves.push(point),
                FIRST_STEP => {
                    let counts = vec![0; self.counts.len()];
                    hosted.beside = Some(StepBeside { extreme, counts });
                }
                _ => hosted.proves.push(point),
            }
        }
        if let Some(track) = &mut hosted.track {
            let points = track.take_points().into_iter();
            hosted.last_proves.extend(points.map(|what| RegisterPoint::Tracked { what }));
        }
        hosted.last_words.clone_from(&hosted.words);
        let interface = hosted.base.with_settings(&plan, settings);
        let is_other = |(one, other): (&Arc<_>, &Arc<_>)| one != other;
        let codes = interface.source_codes.iter().zip(&self.interface.source_codes);
        if codes.into_iter().any(is_other) {
            self.signs = super::signs(&interface);
            self.chips = chip_patterns(&interface, hosted.places[0], hosted.places[1]);
        }
        self.interface = interface;
        self.released = released;
        self.scan = ScanState {
            scan: self.scan.scan,
            from: self.interface.timing.preparation_chips,
            ..ScanState::start(&self.interface)
        };
        if let Some(peak) = &mut self.peak {
            peak.last_group = Group(self.interface.groups() - 1);
        }
    }
}
