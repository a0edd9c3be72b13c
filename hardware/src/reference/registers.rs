//! The registers of [`crate::sensor::registers`], clock by clock where a host does something: an AXI4-Lite slave, the
//! settings, and what is told of scans.

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

use super::canvas::Canvas;
use super::coverage::{First, LONG_STALL, Meeting, RegisterKind, RegisterPoint, TrackPoint};
use super::host::{Channel, HardwareEvent};
use super::host_ports::{HostInputs, HostOutputs};
use crate::scene::DetectorIndex;
use crate::sensor::interface::Interface;
use crate::sensor::layout::{Field, Layout, mask};
use crate::sensor::port::PortRole;
use crate::sensor::registers::{
    CONTROL, IDENTITY_WORDS, LOST_BITS, PEAKS, RegisterPlan, SCANS_BITS, STATUS, Settings, state,
};

/// What scans tell the registers.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum ScanEvent {
    /// A scan's last counts are there.
    ScanCounted,
    /// A group was lost.
    Lost,
    /// A count was clamped.
    Clamped,
    /// Step, from the scan's first, and count of each detector's peak.
    Peaks(Vec<(u64, i64)>),
    /// A window, or a scan that looked for a target, has been weighed: where it is, if there is one, and whether the
    /// window had its light.
    Tracked {
        /// Phase step and fraction.
        position: Option<u32>,
        /// It had.
        locked: bool,
    },
    /// A target was lost.
    TargetLost,
    /// What would have been told of the last window by other numbers; before a target that is lost with it.
    Decided(Vec<Rival>),
}

/// What would be told of a target that is followed by other numbers: a word that is read and differs from it proves a cover
/// point.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Rival {
    /// The point.
    pub(super) point: TrackPoint,
    /// Phase step and fraction.
    pub(super) position: u32,
    /// The window had its light.
    pub(super) locked: bool,
    /// The target is lost.
    pub(super) lost: bool,
}

impl ScanEvent {
    /// What it does to the registers of state, beside what a host may write at the same time.
    fn event(&self) -> Option<HardwareEvent> {
        match self {
            ScanEvent::Lost => Some(HardwareEvent::Loss),
            ScanEvent::Clamped => Some(HardwareEvent::Clamp),
            ScanEvent::TargetLost => Some(HardwareEvent::TargetLost),
            ScanEvent::ScanCounted
            | ScanEvent::Peaks(_)
            | ScanEvent::Tracked { .. }
            | ScanEvent::Decided(_) => None,
        }
    }
}

/// What the rest of the hardware is at, at a clock.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Sequence {
    /// The setting that is read.
    pub(super) taken: Option<usize>,
    /// Settings are refused.
    pub(super) refused: bool,
    /// A scan is under way, or prepared.
    pub(super) busy: bool,
}

/// What a write is to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Target {
    Setting(usize),
    Control,
    Status,
}

/// The registers.
#[derive(Debug, Clone)]
pub(super) struct RegisterModel {
    plan: Arc<RegisterPlan>,
    fields: Vec<Field>,
    words: Vec<u32>,
    /// A write takes place in this clock; what it is to.
    write: bool,
    target: Option<Target>,
    read: bool,
    /// The word that was read in the memory, in the clock before this.
    fetched: Option<Option<u32>>,
    shown: HostOutputs,
    runs: bool,
    single: bool,
    changed: bool,
    overrun: bool,
    saturated: bool,
    refused: bool,
    lost: u32,
    scans: u32,
    peaks: Vec<(u64, i64)>,
    position: u32,
    locked: bool,
    target_lost: bool,
    /// What is told at clocks to come.
    told: BTreeMap<u64, Vec<ScanEvent>>,
    /// What has shown, for the cover points.
    seen: Seen,
}

/// What has shown at the ports.
#[derive(Debug, Clone, Default)]
struct Seen {
    /// Points that have been reached.
    points: Vec<RegisterPoint>,
    /// The address, or the data, of the write under way came alone.
    first: Option<First>,
    /// What the last read was of.
    read: Option<RegisterKind>,
    /// Flags that have been read, and those of them that have been cleared.
    flags: u32,
    cleared: u32,
    /// The last write met the hardware; a read of the state is to show it.
    met: Option<Meeting>,
    /// The number of lost groups has gone round.
    lost_goes_round: bool,
    /// Clocks for which the present write, its response and that of a read have waited.
    waited: [u32; 3],
    /// The write was long in coming, whose response is to show that it was taken.
    stalled: Option<Channel>,
    /// What other numbers would have told, as long as what was told stands.
    rivals: Vec<Rival>,
    /// A target was followed up to the last clock, and is no longer, since scans are not wanted.
    has_stopped: bool,
}

impl RegisterModel {
    /// At power-up.
    pub(super) fn new(interface: &Interface, layout: &Layout) -> Option<RegisterModel> {
        let plan = interface.registers.clone()?;
        let mut words = plan.initial_words(&interface.timing, &interface.source_codes);
        words.resize(1 << plan.word_bits(), 0);
        let fields = layout.outputs.fields.iter();
        let is_own = |field: &&Field| field.port.role >= PortRole::WriteAddress;
        Some(RegisterModel::fresh(plan, fields.filter(is_own).cloned().collect(), words))
    }

    /// All but the memory.
    pub(super) fn reset(&mut self) {
        let (fields, words) = (std::mem::take(&mut self.fields), std::mem::take(&mut self.words));
        *self = RegisterModel::fresh(Arc::clone(&self.plan), fields, words);
    }

    fn fresh(plan: Arc<RegisterPlan>, fields: Vec<Field>, words: Vec<u32>) -> RegisterModel {
        RegisterModel {
            fields,
            words,
            write: false,
            target: None,
            read: false,
            fetched: None,
            shown: HostOutputs::default(),
            runs: true,
            single: false,
            changed: false,
            overrun: false,
            saturated: false,
            refused: false,
            lost: 0,
            scans: 0,
            peaks: vec![(0, 0); plan.peaks as usize],
            position: 0,
            locked: false,
            target_lost: false,
            told: BTreeMap::new(),
            seen: Seen::default(),
            plan,
        }
    }

    /// What they are like.
    pub(super) fn plan(&self) -> &Arc<RegisterPlan> {
        &self.plan
    }

    /// What the slave shows after the last clock.
    pub(super) fn shown(&self) -> HostOutputs {
        self.shown
    }

    /// Whether scans are wanted.
    pub(super) fn go(&self) -> bool {
        self.runs || self.single
    }

    /// Whether scans follow one another.
    pub(super) fn runs(&self) -> bool {
        self.runs
    }

    /// Whether settings were written, or a single scan was asked for, since the last take-over.
    pub(super) fn changed(&self) -> bool {
        self.changed
    }

    /// A setting as it is in the memory.
    pub(super) fn setting(&self, number: usize) -> u32 {
        self.words[IDENTITY_WORDS + number]
    }

    /// Settings, of their words.
    pub(super) fn settings(&self, words: &[u32]) -> Settings {
        self.plan.settings_in(words)
    }

    /// Takes the cover points that have been reached since the last call.
    pub(super) fn take_points(&mut self) -> Vec<RegisterPoint> {
        std::mem::take(&mut self.seen.points)
    }

    /// Something is told at a clock.
    pub(super) fn tell(&mut self, clock: u64, told: ScanEvent) {
        self.told.entry(clock).or_default().push(told);
    }

    /// Whether something is told at a clock.
    pub(super) fn is_told(&self, clock: u64, event: HardwareEvent) -> bool {
        let told = self.told.get(&clock);
        told.is_some_and(|told| told.iter().any(|told| told.event() == Some(event)))
    }

    /// Goes through some clocks in which `sequence` is one thing, and shows the ports.
    pub(super) fn run(
        &mut self,
        clocks: Range<u64>,
        host: &[(Range<u64>, HostInputs)],
        sequence: Sequence,
        expected: &mut impl Canvas,
    ) {
        let mut clock = clocks.start;
        let first = host.partition_point(|(range, _)| range.end <= clock);
        let mut host = &host[first..];
        while clock < clocks.end {
            if let Some((_, rest)) = host.split_first().filter(|((r, _), _)| r.end <= clock) {
                host = rest;
            }
            let next = host.first().map_or(u64::MAX, |(range, _)| range.start);
            if clock < next && self.is_quiet() && sequence.taken.is_none() && !sequence.refused {
                let until = next.min(clocks.end);
                let events: Vec<u64> = self.told.range(..until).map(|(&clock, _)| clock).collect();
                for clock in events {
                    self.meet(clock, None, 0, Sequence::default());
                    self.hear(clock);
                }
                self.follow(self.go());
                self.seen.has_stopped = false;
                self.target = None;
                self.show(clock..until, expected);
                clock = until;
                continue;
            }
            let inputs = match host.first() {
                Some((range, inputs)) if range.contains(&clock) => *inputs,
                _ => HostInputs::default(),
            };
            self.step(clock, &inputs, sequence);
            self.show(clock..clock + 1, expected);
            clock += 1;
        }
    }

    /// Whether nothing changes without a host, but what scans tell.
    pub(super) fn is_quiet(&self) -> bool {
        let shown = &self.shown;
        !(self.write
            || self.read
            || self.fetched.is_some()
            || shown.write_response_valid
            || shown.read_valid)
    }

    /// The rising edge of a clock.
    fn step(&mut self, clock: u64, host: &HostInputs, sequence: Sequence) {
        let is_free = sequence.taken.is_none();
        let before = self.state(sequence.busy);
        let goes = self.go();
        self.watch(host, is_free, before);
        let (write, target, read) = (self.write, self.target, self.read);
        let fetched = self.fetched.take();
        let shown = self.shown;
        let next = &mut self.shown;
        // Writes.
        self.write =
            host.write_address_valid && host.write_valid && !write && !shown.write_response_valid;
        if write {
            next.write_response_valid = true;
            next.write_error = target.is_none();
        } else if host.write_response_ready {
            next.write_response_valid = false;
        }
        // Reads.
        let asks = host.read_address_valid && !read && fetched.is_none() && !shown.read_valid;
        self.read = asks || (read && !is_free);
        if read && is_free {
            self.fetched = Some(self.words.get(host.read_address as usize / 4).copied());
        }
        if let Some(fetched) = fetched {
            let word = fetched.or_else(|| self.word_at(host.read_address.into(), before));
            self.shown.read_valid = true;
            self.shown.read_error = word.is_none();
            self.shown.read_data = word.unwrap_or(0);
        } else if host.read_ready {
            self.shown.read_valid = false;
        }
        // What scans do, then what the host does.
        if sequence.refused {
            (self.runs, self.single) = (false, false);
        }
        if sequence.taken == Some(0) {
            (self.single, self.changed) = (false, false);
        }
        self.meet(clock, target.filter(|_| write), host.write_data, sequence);
        match target.filter(|_| write) {
            Some(Target::Setting(number)) => {
                self.words[IDENTITY_WORDS + number] = host.write_data;
                self.changed = true;
            }
            Some(Target::Control) => {
                let bit = |bit: u32| host.write_data >> bit & 1 == 1;
                (self.runs, self.single) = (bit(state::RUN), bit(state::SINGLE));
                self.changed |= self.single;
            }
            Some(Target::Status) => {
                let keeps = |bit: u32| host.write_data >> bit & 1 == 0;
                self.overrun &= keeps(state::OVERRUN);
                self.saturated &= keeps(state::SATURATED);
                self.refused &= keeps(state::REFUSED);
                self.target_lost &= keeps(state::LOCK_LOST);
                if !keeps(state::LOCK_LOST) {
                    self.seen.rivals.clear();
                }
            }
            None => {}
        }
        self.refused |= sequence.refused;
        self.hear(clock);
        self.follow(goes);
        let whole = host.write_strobe == 0xf;
        self.target = self.target_at(host.write_address.into()).filter(|_| whole);
        self.shown.write_ready = self.write;
        self.shown.read_address_ready = self.fetched.is_some();
    }

    /// A target is followed as long as scans are wanted.
    fn follow(&mut self, goes: bool) {
        self.seen.has_stopped = self.locked && !goes;
        self.locked &= goes;
        if !goes {
            self.seen.rivals.clear();
        }
    }

    /// Notes what the hardware does in a clock, and what a write does in the same.
    fn meet(&mut self, clock: u64, target: Option<Target>, data: u32, sequence: Sequence) {
        let happens = |event| match event {
            HardwareEvent::TakeOver => sequence.taken == Some(0),
            HardwareEvent::Refusal => sequence.refused,
            told => self.is_told(clock, told),
        };
        // What comes once more shows what the write had hidden.
        let is_over = |meeting: &Meeting| target.is_some() || happens(meeting.event);
        let met = match target {
            Some(Target::Control | Target::Status) => Meeting::ALL.into_iter().find(|meeting| {
                let is_its = meeting.is_of_control() == (target == Some(Target::Control));
                is_its && data >> meeting.bit & 1 == 1 && happens(meeting.event)
            }),
            _ => None,
        };
        self.seen.met = met.or(self.seen.met.filter(|meeting| !is_over(meeting)));
    }

    /// What scans tell at a clock.
    fn hear(&mut self, clock: u64) {
        for told in self.told.remove(&clock).into_iter().flatten() {
            match told {
                ScanEvent::ScanCounted => self.scans = (self.scans + 1) & mask(SCANS_BITS) as u32,
                ScanEvent::Lost => {
                    self.overrun = true;
                    self.lost = (self.lost + 1) & mask(LOST_BITS) as u32;
                    self.seen.lost_goes_round |= self.lost == 0;
                }
                ScanEvent::Clamped => self.saturated = true,
                ScanEvent::Peaks(peaks) => self.peaks = peaks,
                ScanEvent::Tracked { position, locked } => {
                    self.position = position.unwrap_or(self.position);
                    self.locked = locked;
                    self.seen.rivals.clear();
                }
                ScanEvent::Decided(mut rivals) => {
                    // The flag stays until it is cleared.
                    rivals.iter_mut().for_each(|rival| rival.lost |= self.target_lost);
                    self.seen.rivals = rivals;
                }
                ScanEvent::TargetLost => self.target_lost = true,
            }
        }
    }

    /// What the control and status registers read as.
    fn state(&self, busy: bool) -> u32 {
        let flags = [
            (state::RUN, self.runs),
            (state::SINGLE, self.single),
            (state::BUSY, busy),
            (state::OVERRUN, self.overrun),
            (state::SATURATED, self.saturated),
            (state::REFUSED, self.refused),
            (state::LOCKED, self.locked),
            (state::LOCK_LOST, self.target_lost),
        ];
        let flags = flags.into_iter().fold(0, |word, (bit, is)| word | u32::from(is) << bit);
        flags | self.lost << state::LOST | self.scans << state::SCANS
    }

    /// Notes what a host's part in this clock shows.
    fn watch(&mut self, host: &HostInputs, is_free: bool, state: u32) {
        let (address, data) = (host.write_address_valid, host.write_valid);
        if address != data && !self.write {
            self.seen.waited[0] += 1;
            self.seen.first.get_or_insert(if address { First::Address } else { First::Data });
        }
        if self.write {
            let first = self.seen.first.take().unwrap_or(First::Neither);
            let to = match (host.write_strobe, self.place(host.write_address.into())) {
                (0xf, place) => place,
                (_, RegisterKind::Setting | RegisterKind::Control | RegisterKind::Status) => {
                    RegisterKind::Partly
                }
                (_, place) => place,
            };
            let is_long = std::mem::take(&mut self.seen.waited[0]) >= LONG_STALL;
            self.seen.stalled = is_long.then_some(match first {
                First::Data => Channel::WriteAddress,
                _ => Channel::WriteData,
            });
            self.seen.points.push(RegisterPoint::Order { first });
            self.seen.points.push(RegisterPoint::Written { to });
            if self.target == Some(Target::Status) {
                self.seen.cleared |= self.seen.flags & host.write_data;
                self.seen.flags &= !host.write_data;
            }
        }
        if self.fetched.is_some() {
            let of = self.place(host.read_address.into());
            self.seen.read = Some(of);
            self.prove_numbers(host.read_address.into());
            self.prove_minus_one(host.read_address.into());
            if matches!(of, RegisterKind::Control | RegisterKind::Status) {
                let met = self.seen.met.take().filter(|meeting| state >> meeting.bit & 1 == 1);
                self.seen.points.extend(met.map(|meeting| RegisterPoint::Met { meeting }));
                let what = TrackPoint::Stopped;
                let stopped = self.seen.has_stopped.then_some(RegisterPoint::Tracked { what });
                self.seen.points.extend(stopped);
                let is_round = std::mem::take(&mut self.seen.lost_goes_round);
                self.seen.points.extend(is_round.then_some(RegisterPoint::LostGoesRound));
                let counted = (0..SCANS_BITS).filter(|bit| state >> (state::SCANS + bit) & 1 == 1);
                let counted = counted.map(|bit| RegisterPoint::ScansCounted { bit });
                self.seen.points.extend(counted);
                for bit in [state::OVERRUN, state::SATURATED, state::REFUSED, state::LOCK_LOST] {
                    let is_set = state >> bit & 1 == 1;
                    if is_set {
                        self.seen.flags |= 1 << bit;
                        self.seen.points.push(RegisterPoint::Flag { bit, cleared: false });
                    } else if self.seen.cleared >> bit & 1 == 1 {
                        self.seen.cleared &= !(1 << bit);
                        self.seen.points.push(RegisterPoint::Flag { bit, cleared: true });
                    }
                }
            }
        }
        if self.read && !is_free {
            self.seen.points.push(RegisterPoint::Waited);
        }
        if self.write && !is_free && matches!(self.target, Some(Target::Setting(_))) {
            self.seen.points.push(RegisterPoint::WrittenMeanwhile);
        }
        if self.shown.read_valid {
            let point = match (host.read_ready, self.seen.read) {
                (true, Some(of)) => Some(RegisterPoint::Read { of }),
                (true, None) => None,
                (false, _) => Some(RegisterPoint::Held { read: true }),
            };
            self.seen.points.extend(point);
        }
        if self.shown.write_response_valid {
            if !host.write_response_ready {
                self.seen.points.push(RegisterPoint::Held { read: false });
            }
            let stalled = self.seen.stalled.take();
            self.seen.points.extend(stalled.map(|channel| RegisterPoint::Stalled { channel }));
        }
        let responses = [
            (1, self.shown.write_response_valid, host.write_response_ready, Channel::WriteResponse),
            (2, self.shown.read_valid, host.read_ready, Channel::Read),
        ];
        for (at, is_there, is_taken, channel) in responses {
            if is_there && is_taken {
                let is_long = std::mem::take(&mut self.seen.waited[at]) >= LONG_STALL;
                // A word that waits stays what it was, whatever it would read as by now.
                let is_old = channel != Channel::Read || self.shows_old_state(state);
                let is_long = is_long && is_old;
                self.seen.points.extend(is_long.then_some(RegisterPoint::Stalled { channel }));
            }
            self.seen.waited[at] += u32::from(is_there && !is_taken);
        }
    }

    /// Whether the word that was read is of the state, which is another one by now.
    fn shows_old_state(&self, state: u32) -> bool {
        let is_state = matches!(self.seen.read, Some(RegisterKind::Control | RegisterKind::Status));
        is_state && self.shown.read_data != state
    }

    /// Marks the numbers for which what is read at an address would be another word.
    fn prove_numbers(&mut self, address: u32) {
        let (locked, target_lost, position) = (self.locked, self.target_lost, self.position);
        let differs = |rival: &&Rival| match address & !3 {
            CONTROL | STATUS => (rival.locked, rival.lost) != (locked, target_lost),
            address => address == self.plan.position_address() && rival.position != position,
        };
        let proven = self.seen.rivals.iter().filter(differs).map(|rival| rival.point);
        self.seen.points.extend(proven.map(|what| RegisterPoint::Tracked { what }));
    }

    /// Marks a count of -1 that is read.
    fn prove_minus_one(&mut self, address: u32) {
        let Some(word) = (address & !3).checked_sub(PEAKS).map(|from| from as usize / 4) else {
            return;
        };
        let is_count = word % 2 == 1 && self.peaks.get(word / 2).is_some_and(|peak| peak.1 == -1);
        let detector = DetectorIndex(word / 2);
        self.seen.points.extend(is_count.then_some(RegisterPoint::MinusOne { detector }));
    }

    /// What an address is of.
    fn place(&self, address: u32) -> RegisterKind {
        let word = (address & !3) as usize / 4;
        match self.target_at(address) {
            Some(Target::Setting(_)) => RegisterKind::Setting,
            Some(Target::Control) => RegisterKind::Control,
            Some(Target::Status) => RegisterKind::Status,
            None if word < self.words.len() => RegisterKind::Identity,
            None if self.word_at(address, 0).is_some() => RegisterKind::Peak,
            None => RegisterKind::Nowhere,
        }
    }

    /// What an address is of, if it may be written to.
    fn target_at(&self, address: u32) -> Option<Target> {
        let word = address & !3;
        let first = 4 * IDENTITY_WORDS as u32;
        match word {
            CONTROL => Some(Target::Control),
            STATUS => Some(Target::Status),
            _ => {
                let number = (word.checked_sub(first)? / 4) as usize;
                (number < self.plan.settings()).then_some(Target::Setting(number))
            }
        }
    }

    /// What is read at an address, if there is a register.
    fn word_at(&self, address: u32, state: u32) -> Option<u32> {
        let word = address & !3;
        if word == CONTROL || word == STATUS {
            return Some(state);
        }
        let number = word.checked_sub(PEAKS).map(|from| from / 4);
        if self.plan.track.is_some() && number == Some(2 * self.plan.peaks) {
            return Some(self.position);
        }
        if let Some(number) = number.map(|number| number as usize)
            && let Some(&(step, count)) = self.peaks.get(number / 2)
        {
            return Some(if number % 2 == 0 { step as u32 } else { count as u32 });
        }
        self.words.get(word as usize / 4).copied()
    }

    /// ORs the ports into the records of some clocks.
    fn show(&self, clocks: Range<u64>, expected: &mut impl Canvas) {
        let shown = &self.shown;
        for field in &self.fields {
            let value = match field.port.role {
                PortRole::WriteAddressReady | PortRole::WriteReady => shown.write_ready.into(),
                PortRole::WriteResponse => u64::from(shown.write_error) << 1,
                PortRole::WriteResponseValid => shown.write_response_valid.into(),
                PortRole::ReadAddressReady => shown.read_address_ready.into(),
                PortRole::ReadData => shown.read_data.into(),
                PortRole::ReadResponse => u64::from(shown.read_error) << 1,
                PortRole::ReadValid => shown.read_valid.into(),
                _ => 0,
            };
            if value != 0 {
                expected.or(clocks.clone(), field.word, value << field.shift);
            }
        }
    }
}
