//! Cover points of registers, and of scans that a host sets.

mod talks;

pub(in crate::reference) use self::talks::{addresses, as_in_the_scene};

use super::{Hindered, PointFamily};
use crate::code::is_maximal;
use crate::reference::group_maker::GroupMaker;
use crate::reference::host::{Channel, HardwareEvent};
use crate::reference::planned::PlannedGroup;
use crate::scene::DetectorIndex;
use crate::sensor::interface::Interface;
use crate::sensor::registers::{
    CONTROL, RegisterPlan, SCAN_WORDS, SCANS_BITS, STATUS, Seed, state,
};

/// Clocks of a stall that is long: slaves have been seen to give up after a power of two of them.
pub(in crate::reference) const LONG_STALL: u32 = 300;

/// Something that a host does, or that scans do by its settings.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum RegisterPoint {
    /// A result of a scan that began with another value of a setting than the one before.
    Taken {
        /// Which setting.
        setting: usize,
    },
    /// What a scan with the least, or the largest, value of a setting shows of it: a result, or its last one of the number
    /// of groups.
    Extreme {
        /// Which setting.
        setting: usize,
        /// Which of the two.
        extreme: Extreme,
    },
    /// A result of a scan that began with other taps of a code.
    TapsTaken {
        /// Of which seed.
        seed: usize,
        /// Whether their polynomial is primitive.
        primitive: bool,
    },
    /// Settings are refused.
    Refused {
        /// Whose number does not fit.
        setting: usize,
    },
    /// A result of a scan that began otherwise than behind another.
    Began {
        /// How.
        how: ScanStart,
    },
    /// An answered write.
    Written {
        /// To what.
        to: RegisterKind,
    },
    /// A read word that was taken.
    Read {
        /// Of what.
        of: RegisterKind,
    },
    /// A count of a peak was read that is -1: of all bits of the word only those of the sign are not its own.
    MinusOne {
        /// Whose peak.
        detector: DetectorIndex,
    },
    /// A write whose address, or data, came first.
    Order {
        /// Which.
        first: First,
    },
    /// A response that had to wait for the host.
    Held {
        /// That of a read.
        read: bool,
    },
    /// A transfer that waited for long.
    Stalled {
        /// Whose.
        channel: Channel,
    },
    /// A bit of the state that was read as it has to be behind a clock in which host and hardware changed it.
    Met {
        /// What met.
        meeting: Meeting,
    },
    /// The flags were read behind so many losses that their number has gone round.
    LostGoesRound,
    /// The number of scans was read with this bit set.
    ScansCounted {
        /// The bit.
        bit: u32,
    },
    /// A read that waited while settings were taken over.
    Waited,
    /// A setting that was written while settings were taken over.
    WrittenMeanwhile,
    /// What came of a window, or of a scan that looked for a target, has shown: with the last result of the scan behind
    /// it, or in a word that was read.
    Tracked {
        /// What.
        what: TrackPoint,
    },
    /// A flag that was read, set and then cleared.
    Flag {
        /// Its bit.
        bit: u32,
        /// Cleared.
        cleared: bool,
    },
}

/// An end of a setting's range.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Extreme {
    /// Its least value.
    Least,
    /// Its largest.
    Most,
}

impl Extreme {
    fn text(self) -> &'static str {
        match self {
            Extreme::Least => "least",
            Extreme::Most => "largest",
        }
    }
}

/// A host writes 1 to a bit of the state, and in the same clock the hardware does something that changes the bit. It is 1
/// behind it: what is asked for in that clock is not done yet, and what happens in it has not been seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Meeting {
    /// The bit.
    pub bit: u32,
    /// What the hardware does.
    pub event: HardwareEvent,
}

impl Meeting {
    /// All of them.
    pub const ALL: [Meeting; 6] = [
        Meeting { bit: state::SINGLE, event: HardwareEvent::TakeOver },
        Meeting { bit: state::RUN, event: HardwareEvent::Refusal },
        Meeting { bit: state::REFUSED, event: HardwareEvent::Refusal },
        Meeting { bit: state::OVERRUN, event: HardwareEvent::Loss },
        Meeting { bit: state::SATURATED, event: HardwareEvent::Clamp },
        Meeting { bit: state::LOCK_LOST, event: HardwareEvent::TargetLost },
    ];

    /// Whether the bit is written in the control register, and not in the flags.
    pub fn is_of_control(&self) -> bool {
        matches!(self.bit, state::RUN | state::SINGLE)
    }

    fn address(&self) -> u32 {
        if self.is_of_control() { CONTROL } else { STATUS }
    }

    fn text(&self) -> String {
        let written = match self.bit {
            state::RUN => "RUN written",
            state::SINGLE => "SINGLE written",
            state::OVERRUN => "the flag of overrun cleared",
            state::SATURATED => "the flag of saturation cleared",
            state::LOCK_LOST => "the flag of a lost target cleared",
            _ => "the flag of refusal cleared",
        };
        let event = match self.event {
            HardwareEvent::TakeOver => "of a take-over",
            HardwareEvent::Refusal => "of a refusal",
            HardwareEvent::Loss => "in which a group is lost",
            HardwareEvent::Clamp => "in which a count is clamped",
            HardwareEvent::TargetLost => "in which a target is lost",
        };
        format!("{written} in the clock {event}")
    }
}

/// What came of a window, or of a scan that looked for a target.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum TrackPoint {
    /// A target was found.
    Found,
    /// No count was positive.
    Nothing,
    /// The window had the light.
    Lit,
    /// It had not, and the next may.
    Missed,
    /// As many had not as patience has.
    Lost,
    /// It moved.
    Moved {
        /// To smaller phase steps.
        back: bool,
    },
    /// One half had all of the light.
    Most,
    /// It moved over the end of the code period.
    OverTheEnd,
    /// A host stopped scans while it had the light, and read the state in the first clock in which that no longer counts.
    Stopped,
    /// A word was read that would be another one if a number at an end of its range were the one next to it.
    Number {
        /// Which number.
        number: TrackNumber,
        /// Which end.
        extreme: Extreme,
    },
}

/// A number of the setting by which a target is followed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum TrackNumber {
    /// The share of the way that a window moves.
    Gain,
    /// The share of the light below which a window has lost it.
    Threshold,
    /// The windows without light behind which the target is lost.
    Patience,
}

impl TrackPoint {
    const ALL: [TrackPoint; 16] = [
        TrackPoint::Found,
        TrackPoint::Nothing,
        TrackPoint::Lit,
        TrackPoint::Missed,
        TrackPoint::Lost,
        TrackPoint::Moved { back: false },
        TrackPoint::Moved { back: true },
        TrackPoint::Most,
        TrackPoint::OverTheEnd,
        TrackPoint::Stopped,
        TrackPoint::Number { number: TrackNumber::Gain, extreme: Extreme::Least },
        TrackPoint::Number { number: TrackNumber::Gain, extreme: Extreme::Most },
        TrackPoint::Number { number: TrackNumber::Threshold, extreme: Extreme::Least },
        TrackPoint::Number { number: TrackNumber::Threshold, extreme: Extreme::Most },
        TrackPoint::Number { number: TrackNumber::Patience, extreme: Extreme::Least },
        TrackPoint::Number { number: TrackNumber::Patience, extreme: Extreme::Most },
    ];

    fn text(self) -> String {
        let text = match self {
            TrackPoint::Found => "a window at a target that a scan has found",
            TrackPoint::Nothing => "a scan behind one that has found no target",
            TrackPoint::Lit => "a scan behind a window with its target's light",
            TrackPoint::Missed => "a window behind one without light",
            TrackPoint::Lost => "a scan for a target that was lost",
            TrackPoint::Moved { back: false } => "a window that has moved on",
            TrackPoint::Moved { back: true } => "a window that has moved back",
            TrackPoint::Most => "a window behind one with all light in one half",
            TrackPoint::OverTheEnd => "a window that has moved over the end of the code period",
            TrackPoint::Stopped => {
                "a target that is no longer followed, read as soon as that shows"
            }
            TrackPoint::Number { number, extreme } => {
                let number = match number {
                    TrackNumber::Gain => "gain",
                    TrackNumber::Threshold => "threshold",
                    TrackNumber::Patience => "patience",
                };
                return format!(
                    "a word that the {} {number} alone makes of a window",
                    extreme.text()
                );
            }
        };
        text.to_owned()
    }
}

/// How a scan began.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ScanStart {
    /// Scans had been stopped.
    AfterStop,
    /// It was the only one that was asked for.
    Single,
    /// Settings had been written.
    Changed,
    /// It is over the whole code period, and goes on where the one before it ended.
    GoesOn,
    /// The same was under way when settings were written.
    ChangedWhole,
    /// The same was under way when scans were stopped.
    AfterStopWhole,
    /// A scan before it ended less than five chips before a code period's first.
    EndsAtEpoch,
}

/// What an address is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum RegisterKind {
    /// Identification.
    Identity,
    /// A setting.
    Setting,
    /// The control register.
    Control,
    /// The flags.
    Status,
    /// A peak.
    Peak,
    /// Nothing.
    Nowhere,
    /// A register, but not all bytes of it.
    Partly,
}

/// What of a write came first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum First {
    /// The address.
    Address,
    /// The data.
    Data,
    /// Neither.
    Neither,
}

impl RegisterKind {
    fn text(self) -> &'static str {
        match self {
            RegisterKind::Identity => "identification",
            RegisterKind::Setting => "a setting",
            RegisterKind::Control => "the control register",
            RegisterKind::Status => "the status register",
            RegisterKind::Peak => "a peak",
            RegisterKind::Nowhere => "no register",
            RegisterKind::Partly => "some bytes of a register",
        }
    }
}

/// What a setting is called.
fn setting_text(setting: usize) -> String {
    match setting {
        0 => "the chips of a step".to_owned(),
        1 => "the groups of a scan".to_owned(),
        2 => "the first step".to_owned(),
        seed => format!("seed {}", seed - 3),
    }
}

/// Whether a 128th of the light that a scan may find is a hit at least, as a window shows it that has one: with a hit
/// on every other sample of half of the chips.
fn has_dim_windows(interface: &Interface, plan: &RegisterPlan) -> bool {
    let samples = ((1u64 << plan.chips_bits) - 1) << plan.sample_bits;
    let count = (samples / 4).min((1 << (interface.count_bits() - 1)) - 1);
    count << plan.sample_bits >= 128
}

/// Points of registers.
pub(super) fn points(interface: &Interface, plan: &RegisterPlan) -> Vec<Hindered<RegisterPoint>> {
    let mut points = Vec::new();
    let mut add = |point| points.push((point, None));
    let own = plan.track_setting();
    let settings = (0..plan.settings()).filter(|setting| Some(*setting) != own);
    for setting in settings {
        add(RegisterPoint::Taken { setting });
        for extreme in [Extreme::Least, Extreme::Most] {
            add(RegisterPoint::Extreme { setting, extreme });
        }
    }
    for (seed, _) in plan.seeds.iter().enumerate().filter(|(_, seed)| seed.has_taps()) {
        for primitive in [true, false] {
            add(RegisterPoint::TapsTaken { seed, primitive });
        }
    }
    let refuses = |setting: usize| match setting {
        // Every number of so many bits may be a delay.
        2 => plan.period_chips >> plan.delay_bits == 0,
        _ => true,
    };
    (0..3).filter(|&setting| refuses(setting)).for_each(|setting| {
        add(RegisterPoint::Refused { setting });
    });
    for how in [ScanStart::AfterStop, ScanStart::Single, ScanStart::Changed] {
        add(RegisterPoint::Began { how });
    }
    if chips_to_an_epoch(plan) >> plan.chips_bits == 0 {
        add(RegisterPoint::Began { how: ScanStart::EndsAtEpoch });
    }
    if plan.whole_groups.is_some_and(|groups| groups >> plan.groups_bits == 0) {
        for how in [ScanStart::GoesOn, ScanStart::ChangedWhole, ScanStart::AfterStopWhole] {
            add(RegisterPoint::Began { how });
        }
    }
    let peak = (plan.peaks > 0).then_some(RegisterKind::Peak);
    let places = [
        RegisterKind::Identity,
        RegisterKind::Setting,
        RegisterKind::Control,
        RegisterKind::Status,
        RegisterKind::Nowhere,
    ];
    for place in places.into_iter().chain(peak) {
        add(RegisterPoint::Written { to: place });
        add(RegisterPoint::Read { of: place });
    }
    for (detector, code) in interface.reference_codes.iter().enumerate() {
        if plan.peaks > 0 && has_hits_for_all(interface, plan, &code.chips) {
            add(RegisterPoint::MinusOne { detector: DetectorIndex(detector) });
        }
    }
    add(RegisterPoint::Written { to: RegisterKind::Partly });
    for first in [First::Address, First::Data, First::Neither] {
        add(RegisterPoint::Order { first });
    }
    for read in [false, true] {
        add(RegisterPoint::Held { read });
    }
    for channel in CHANNELS {
        add(RegisterPoint::Stalled { channel });
    }
    add(RegisterPoint::LostGoesRound);
    // The way to the highest bit has all others.
    (0..SCANS_BITS).rev().for_each(|bit| add(RegisterPoint::ScansCounted { bit }));
    add(RegisterPoint::Waited);
    add(RegisterPoint::WrittenMeanwhile);
    for meeting in Meeting::ALL {
        let can_be = match meeting.event {
            HardwareEvent::Clamp => interface.saturates(),
            HardwareEvent::TargetLost => own.is_some(),
            _ => true,
        };
        if can_be {
            add(RegisterPoint::Met { meeting });
        }
    }
    let saturated = interface.saturates().then_some(state::SATURATED);
    let lock_lost = own.map(|_| state::LOCK_LOST);
    for bit in [state::OVERRUN, state::REFUSED].into_iter().chain(saturated).chain(lock_lost) {
        for cleared in [false, true] {
            add(RegisterPoint::Flag { bit, cleared });
        }
    }
    if own.is_some() {
        let hindrance = |what| match what {
            TrackPoint::Number { number: TrackNumber::Threshold, extreme: Extreme::Least } => {
                (!has_dim_windows(interface, plan)).then_some("a 128th of any light is no hit")
            }
            _ => None,
        };
        let tracked = |what| (RegisterPoint::Tracked { what }, hindrance(what));
        points.extend(TrackPoint::ALL.into_iter().map(tracked));
    }
    points
}

/// Those of which a transfer can wait.
const CHANNELS: [Channel; 4] =
    [Channel::WriteAddress, Channel::WriteData, Channel::WriteResponse, Channel::Read];

impl PointFamily for RegisterPoint {
    fn text(&self) -> String {
        match *self {
            RegisterPoint::Taken { setting } => {
                format!("a scan with another value of {}", setting_text(setting))
            }
            RegisterPoint::Extreme { setting, extreme } => {
                format!("a scan with the {} value of {}", extreme.text(), setting_text(setting))
            }
            RegisterPoint::TapsTaken { seed, primitive } => {
                let polynomial = if primitive { "another" } else { "no" };
                format!("a scan with taps of {polynomial} primitive polynomial in seed {seed}")
            }
            RegisterPoint::Refused { setting } => {
                format!("settings that are refused for {}", setting_text(setting))
            }
            RegisterPoint::Began { how } => match how {
                ScanStart::AfterStop => "a scan after scans had been stopped".to_owned(),
                ScanStart::AfterStopWhole => {
                    "a scan after a stop behind one over the whole code period".to_owned()
                }
                ScanStart::Single => "a single scan".to_owned(),
                ScanStart::Changed => "a scan that begins anew for written settings".to_owned(),
                ScanStart::GoesOn => {
                    "a scan over the whole code period that goes on where the last ended".to_owned()
                }
                ScanStart::ChangedWhole => {
                    "a scan that begins anew behind one over the whole code period".to_owned()
                }
                ScanStart::EndsAtEpoch => {
                    "a scan behind one that ended just before a code period".to_owned()
                }
            },
            RegisterPoint::Written { to } => format!("a write to {}", to.text()),
            RegisterPoint::Read { of } => format!("a read of {}", of.text()),
            RegisterPoint::MinusOne { detector } => {
                format!("a read of the count of a peak of -1 of detector {}", detector.0)
            }
            RegisterPoint::Order { first } => match first {
                First::Address => "a write whose address comes first".to_owned(),
                First::Data => "a write whose data come first".to_owned(),
                First::Neither => "a write whose address and data come at once".to_owned(),
            },
            RegisterPoint::Held { read } => {
                format!("the response to a {} that waits", if read { "read" } else { "write" })
            }
            RegisterPoint::Tracked { what } => what.text(),
            RegisterPoint::Stalled { channel } => {
                let transfer = match channel {
                    Channel::WriteAddress => "a write whose address is long in coming",
                    Channel::WriteData => "a write whose data are long in coming",
                    Channel::WriteResponse => "the response to a write that waits for long",
                    Channel::Read => "a read of flags that waits for long, while they change",
                };
                transfer.to_owned()
            }
            RegisterPoint::Met { meeting } => meeting.text(),
            RegisterPoint::LostGoesRound => {
                "the number of lost groups read when it has gone round".to_owned()
            }
            RegisterPoint::ScansCounted { bit } => {
                format!("the number of scans read with bit {bit} set")
            }
            RegisterPoint::Waited => "a read that waits for a take-over".to_owned(),
            RegisterPoint::WrittenMeanwhile => "a setting written during a take-over".to_owned(),
            RegisterPoint::Flag { bit, cleared } => {
                let flag = match bit {
                    state::OVERRUN => "overrun",
                    state::SATURATED => "saturation",
                    state::LOCK_LOST => "a lost target",
                    _ => "refusal",
                };
                format!("the flag of {flag}, {}", if cleared { "cleared" } else { "read" })
            }
        }
    }

    fn recipe(&self, maker: &GroupMaker) -> Result<Vec<PlannedGroup>, String> {
        talks::recipe(*self, maker)
    }
}

/// What a scan shows whose settings are these words, and those of the one before others.
pub(in crate::reference) fn taken(
    plan: &RegisterPlan,
    words: &[u32],
    last_words: &[u32],
) -> Vec<RegisterPoint> {
    let mut points = Vec::new();
    for (setting, (&word, &last)) in words.iter().zip(last_words).enumerate() {
        // What follows from how a target is followed has points of its own.
        if word == last || Some(setting) == plan.track_setting() {
            continue;
        }
        points.push(RegisterPoint::Taken { setting });
        let seed = setting.checked_sub(SCAN_WORDS);
        let Some((seed, &Seed { degree, .. })) =
            seed.and_then(|seed| Some((seed, plan.seeds.get(seed).filter(|it| it.has_taps())?)))
        else {
            continue;
        };
        if word >> degree != last >> degree {
            let primitive = is_maximal(degree, (word >> degree).into());
            points.push(RegisterPoint::TapsTaken { seed, primitive });
        }
    }
    points
}

/// The ends of the range of a setting that is not how a target is followed.
fn ends_of(plan: &RegisterPlan, setting: usize) -> [u32; 2] {
    let ones = |bits: u32| ((1u64 << bits) - 1) as u32;
    match setting {
        0 => [plan.least_chips as u32, ones(plan.chips_bits)],
        1 => [1, ones(plan.groups_bits)],
        2 => [0, (plan.period_chips << plan.sample_bits) as u32 - 1],
        seed => [0, plan.seeds.get(seed - SCAN_WORDS).map_or(0, |seed| ones(seed.bits))],
    }
}

/// The settings among these words that are at an end of their range.
pub(in crate::reference) fn extremes(
    plan: &RegisterPlan,
    words: &[u32],
) -> impl Iterator<Item = (usize, Extreme)> {
    let own = plan.track_setting();
    let settings = words.iter().enumerate().filter(move |(setting, _)| Some(*setting) != own);
    settings.flat_map(move |(setting, &word)| {
        let ends = ends_of(plan, setting).into_iter().zip([Extreme::Least, Extreme::Most]);
        ends.filter(move |(end, _)| *end == word).map(move |(_, extreme)| (setting, extreme))
    })
}

/// Whether there are hits that all steps of a group count down: a code has as many chips of 0 in a row, and a step has all
/// of a code's chips.
fn has_hits_for_all(interface: &Interface, plan: &RegisterPlan, chips: &[u8]) -> bool {
    let samples = u64::from(interface.lanes());
    let run = (u64::from(interface.parallel()) - 1).div_ceil(samples) as usize + 1;
    let twice = [chips, &chips[..run.min(chips.len())]].concat();
    twice.windows(run).any(|chips| chips.iter().all(|&chip| chip == 0))
        && plan.period_chips >> plan.chips_bits == 0
}

/// Chips of a step, not of the shortest, that is whole code periods.
fn chips_to_an_epoch(plan: &RegisterPlan) -> u64 {
    plan.least_chips.next_multiple_of(plan.period_chips) + plan.period_chips
}
