//! Cover points of registers, and of scans that a host sets.

use super::{Hindered, PointFamily};
use crate::code::is_maximal;
use crate::reference::group_maker::GroupMaker;
use crate::reference::host::{Channel, HardwareEvent, Request};
use crate::reference::planned::{Hits, PlannedGroup, ReceiverPlan};
use crate::scene::DetectorIndex;
use crate::sensor::interface::Interface;
use crate::sensor::registers::{
    CONTROL, IDENTITY_WORDS, LOST_BITS, PEAKS, RegisterPlan, SCAN_WORDS, STATUS, Seed,
    setting_address, state,
};
use crate::sensor::track::TrackSetting;

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
    /// A read that waited while settings were taken over.
    Waited,
    /// A setting that was written while settings were taken over.
    WrittenMeanwhile,
    /// A result of a scan that follows from a window, or from a scan that looked for a target.
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
    /// A target was lost behind as many windows as the largest patience has.
    LostLast,
    /// A window had no light but for the least threshold, or had it but for the largest.
    Threshold {
        /// Which of the two.
        extreme: Extreme,
    },
}

impl TrackPoint {
    const ALL: [TrackPoint; 12] = [
        TrackPoint::Found,
        TrackPoint::Nothing,
        TrackPoint::Lit,
        TrackPoint::Missed,
        TrackPoint::Lost,
        TrackPoint::Moved { back: false },
        TrackPoint::Moved { back: true },
        TrackPoint::Most,
        TrackPoint::OverTheEnd,
        TrackPoint::LostLast,
        TrackPoint::Threshold { extreme: Extreme::Least },
        TrackPoint::Threshold { extreme: Extreme::Most },
    ];

    fn text(self) -> &'static str {
        match self {
            TrackPoint::Found => "a window at a target that a scan has found",
            TrackPoint::Nothing => "a scan behind one that has found no target",
            TrackPoint::Lit => "a scan behind a window with its target's light",
            TrackPoint::Missed => "a window behind one without light",
            TrackPoint::Lost => "a scan for a target that was lost",
            TrackPoint::Moved { back: false } => "a window that has moved on",
            TrackPoint::Moved { back: true } => "a window that has moved back",
            TrackPoint::Most => "a window behind one with all light in one half",
            TrackPoint::OverTheEnd => "a window that has moved over the end of the code period",
            TrackPoint::LostLast => "a scan for a target that was lost with the most patience",
            TrackPoint::Threshold { extreme: Extreme::Least } => {
                "a window behind one with light for the lowest threshold alone"
            }
            TrackPoint::Threshold { extreme: Extreme::Most } => {
                "a window behind one without light for the highest threshold alone"
            }
        }
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
    if own.is_some() {
        TrackPoint::ALL.into_iter().for_each(|what| add(RegisterPoint::Tracked { what }));
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
                let extreme = match extreme {
                    Extreme::Least => "least",
                    Extreme::Most => "largest",
                };
                format!("a scan with the {extreme} value of {}", setting_text(setting))
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
            RegisterPoint::Order { first } => match first {
                First::Address => "a write whose address comes first".to_owned(),
                First::Data => "a write whose data come first".to_owned(),
                First::Neither => "a write whose address and data come at once".to_owned(),
            },
            RegisterPoint::Held { read } => {
                format!("the response to a {} that waits", if read { "read" } else { "write" })
            }
            RegisterPoint::Tracked { what } => what.text().to_owned(),
            RegisterPoint::Stalled { channel } => {
                let transfer = match channel {
                    Channel::WriteAddress => "a write whose address is long in coming",
                    Channel::WriteData => "a write whose data are long in coming",
                    Channel::WriteResponse => "the response to a write that waits for long",
                    Channel::Read => "the response to a read that waits for long",
                };
                transfer.to_owned()
            }
            RegisterPoint::Met { meeting } => meeting.text(),
            RegisterPoint::LostGoesRound => {
                "the number of lost groups read when it has gone round".to_owned()
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

    /// A few conversations have all of it; what depends on chance shows when they are held again.
    fn recipe(&self, maker: &GroupMaker) -> Result<Vec<PlannedGroup>, String> {
        let Some(plan) = &maker.interface.registers else {
            return Err("there are no registers".to_owned());
        };
        let scan = maker.interface.timing.preparation_chips
            + 2 * maker.interface.timing.code_chips()
            + 4 * plan.least_chips;
        let whole = plan.whole_groups.unwrap_or(0).saturating_mul(plan.least_chips);
        let mut stall = None;
        let (talk, clocks, hits) = match *self {
            RegisterPoint::Began {
                how: ScanStart::GoesOn | ScanStart::ChangedWhole | ScanStart::AfterStopWhole,
            } => (whole_scans(plan, scan + whole), 10 * (scan + whole), Vec::new()),
            RegisterPoint::Extreme { setting, extreme } => {
                let (talk, clocks) = extreme_scans(plan, scan, setting, extreme);
                (talk, clocks, Vec::new())
            }
            RegisterPoint::Stalled { channel } => {
                (stalls(channel), 4 * u64::from(LONGEST_STALL), Vec::new())
            }
            RegisterPoint::Met { meeting } => meets(plan, scan, meeting),
            RegisterPoint::LostGoesRound => {
                let (talk, clocks) = many_losses(plan, scan);
                stall = Some(ReceiverPlan::StopsAt { beat: 0, clocks });
                (talk, clocks, Vec::new())
            }
            RegisterPoint::Tracked { what: TrackPoint::LostLast } => patient_windows(plan, scan),
            RegisterPoint::Tracked { what: TrackPoint::Threshold { extreme } } => {
                dim_windows(plan, scan, extreme)
            }
            _ => {
                let talk = conversation(maker.interface, plan, scan);
                let (track, waits) = track_conversation(plan, scan);
                let talk = talk.into_iter().chain(track).collect();
                (talk, 96 * scan + 2_000 + waits, Vec::new())
            }
        };
        if clocks > maker.reach.most_clocks_of_talk {
            return Err(format!("it takes {clocks} clocks"));
        }
        let mut groups = vec![maker.fresh().asks(short_scans(plan))];
        let talks = PlannedGroup::random().after_reset(3, 4).received(ReceiverPlan::Stalls);
        groups.push(talks.asks(talk));
        groups.extend(stall.map(|stall| PlannedGroup::random().received(stall)));
        groups.extend(hits.into_iter().map(|hits| PlannedGroup::random().with(hits)));
        groups.push(PlannedGroup::random().received(ReceiverPlan::Stalls));
        groups.push(PlannedGroup::random().asks(as_in_the_scene(maker.interface, plan)));
        groups.push(PlannedGroup::random());
        Ok(groups)
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

/// Scans with a setting at an end of its range, otherwise as short as may be, and their clocks.
fn extreme_scans(
    plan: &RegisterPlan,
    scan: u64,
    setting: usize,
    extreme: Extreme,
) -> (Vec<Request>, u64) {
    let [least, most] = ends_of(plan, setting);
    let word = if extreme == Extreme::Least { least } else { most };
    let [chips, groups] = match setting {
        0 => [word.into(), 2],
        1 => [plan.least_chips, word.into()],
        _ => [plan.least_chips, 2],
    };
    let clocks = scan + chips * groups;
    let settings = [(0, plan.least_chips as u32), (1, 2), (setting, word)];
    let mut talk: Vec<Request> = settings
        .into_iter()
        .map(|(setting, word)| Request::write(setting_address(setting), word))
        .collect();
    // The scan under way when they are written, one with them, and a part of the next.
    talk.push(Request::Wait { clocks: 2 * scan + clocks });
    talk.extend([Request::Read { address: STATUS }, Request::Wait { clocks: 2 * scan }]);
    (talk, 4 * scan + clocks + 200)
}

/// Clocks of the longest stall, beyond any number of bits that a slave may count in.
const LONGEST_STALL: u32 = 2 * LONG_STALL;

/// Writes and a read of which one transfer is stalled for long.
fn stalls(channel: Channel) -> Vec<Request> {
    let address = setting_address(1);
    let transfer = match channel {
        Channel::Read => Request::Read { address },
        _ => Request::write(address, 2),
    };
    let stall = |clocks| [Request::Stall { channel, clocks }, transfer];
    [LONG_STALL, LONGEST_STALL].into_iter().flat_map(stall).collect()
}

/// Scans of many groups, none of which is taken, until the number of the lost ones has gone round; and their clocks.
fn many_losses(plan: &RegisterPlan, scan: u64) -> (Vec<Request>, u64) {
    let groups = (1 << plan.groups_bits) - 1;
    let lost = (1 << LOST_BITS) + 16;
    let clocks = lost * plan.least_chips + (lost.div_ceil(groups) + 3) * scan;
    let mut talk = short_scans(plan);
    talk.push(Request::write(setting_address(1), groups as u32));
    talk.extend([Request::Wait { clocks }, Request::Read { address: STATUS }]);
    (talk, clocks)
}

/// Writes in the very clock of what the hardware does.
fn meets(plan: &RegisterPlan, scan: u64, meeting: Meeting) -> (Vec<Request>, u64, Vec<Hits>) {
    // Chance has its part: whether the read comes soon enough, and whether a result was taken.
    const TIMES: u64 = 4;
    let Meeting { bit, event } = meeting;
    let talk_of = |within| {
        let (address, data) = (meeting.address(), 1 << bit);
        [Request::Meet { event, address, data, within }, Request::Read { address }]
    };
    if event == HardwareEvent::TargetLost {
        let (mut talk, clocks, dark) = patient_windows(plan, scan);
        // In place of the wait at its end.
        talk.pop();
        talk.extend(talk_of(clocks));
        return (talk, clocks + 200, dark);
    }
    let least = plan.least_chips as u32;
    let most = (1u32 << plan.chips_bits) - 1;
    // Steps that are too short are refused; a count is clamped where all hits of a long one have one sign.
    let (chips, is_lit) = match event {
        HardwareEvent::Refusal => (least - 1, false),
        HardwareEvent::Clamp => (most, true),
        _ => (least, false),
    };
    let within = 4 * (scan + u64::from(chips));
    let (mut talk, mut hits) = (short_scans(plan), Vec::new());
    for _ in 0..TIMES {
        talk.push(Request::write(setting_address(0), chips));
        talk.push(Request::write(CONTROL, 1 << state::RUN));
        talk.extend(talk_of(within));
        hits.extend(vec![Hits::AllSteps { up: true }; if is_lit { 6 } else { 0 }]);
    }
    talk.extend([
        Request::write(setting_address(0), least),
        Request::write(CONTROL, 1 << state::RUN),
    ]);
    (talk, TIMES * (within + 100), hits)
}

/// Turns the window on, with gain, threshold and patience in the registers' own numbers.
fn track_with(plan: &RegisterPlan, numbers: [u32; 3]) -> Option<Request> {
    let [gain_halvings, threshold_halvings, patience] = numbers;
    let setting = TrackSetting { is_on: true, gain_halvings, threshold_halvings, patience };
    Some(Request::write(setting_address(plan.track_setting()?), setting.word()))
}

/// Groups that are lit until a host has turned the window on, and a scan has found a target; and about how many scans
/// and windows they are.
const LIT_GROUPS: usize = 40;
const LIT_SCANS: u64 = 12;

/// A target with light, and then windows that count down alone until it is lost with the most patience.
fn patient_windows(plan: &RegisterPlan, scan: u64) -> (Vec<Request>, u64, Vec<Hits>) {
    let Some((track, on)) = plan.track.as_ref().zip(track_with(plan, [0, 0, 15])) else {
        return (Vec::new(), 0, Vec::new());
    };
    let steps = track.window_steps();
    let windows = 18;
    let mut hits = vec![Hits::AllSteps { up: true }; LIT_GROUPS];
    // A scan without any hit would not show what came before it.
    hits.extend(vec![Hits::AllSteps { up: false }; (windows * steps) as usize]);
    let clocks = (windows + LIT_SCANS) * (scan + steps * plan.least_chips);
    let mut talk = short_scans(plan);
    talk.extend([on, Request::Wait { clocks }]);
    (talk, clocks, hits)
}

/// A target with light, and then windows with less and less of it until the threshold is between.
fn dim_windows(plan: &RegisterPlan, scan: u64, extreme: Extreme) -> (Vec<Request>, u64, Vec<Hits>) {
    let halvings = if extreme == Extreme::Least { 7 } else { 0 };
    let Some((track, on)) = plan.track.as_ref().zip(track_with(plan, [0, halvings, 15])) else {
        return (Vec::new(), 0, Vec::new());
    };
    let steps = track.window_steps();
    // Long steps, so that a few hits are between a 128th and a 64th of their light.
    let chips = long_steps(plan);
    let mut hits = vec![Hits::AllSteps { up: true }; LIT_GROUPS];
    let (detector, step) = (DetectorIndex(0), 0);
    // Counts, and of how many steps one has it.
    let counts = match extreme {
        Extreme::Least => [(1, 2), (1, 1), (2, 1), (4, 1)],
        Extreme::Most => [3, 2, 3, 2].map(|quarters| (quarters * chips as i64 / 4, 1)),
    };
    for (count, every) in counts {
        let of_step = |number: u64| match number % every {
            0 => Hits::Count { detector, step, count },
            _ => Hits::None,
        };
        hits.extend((0..2 * steps).map(of_step));
        hits.extend(vec![Hits::AllSteps { up: true }; 4 * steps as usize]);
    }
    let windows = 6 * counts.len() as u64 + LIT_SCANS;
    let clocks = windows * (scan + steps * chips);
    let mut talk = vec![
        Request::write(setting_address(0), chips as u32),
        Request::write(setting_address(1), 2),
    ];
    talk.extend([on, Request::Wait { clocks }]);
    (talk, clocks, hits)
}

/// Scans of two steps, as short as may be.
fn short_scans(plan: &RegisterPlan) -> Vec<Request> {
    vec![
        Request::write(setting_address(0), plan.least_chips as u32),
        Request::write(setting_address(1), 2),
    ]
}

/// The settings of the scene, and scans one after another.
pub(in crate::reference) fn as_in_the_scene(
    interface: &Interface,
    plan: &RegisterPlan,
) -> Vec<Request> {
    let settings = plan.settings_of(&interface.timing, &interface.source_codes);
    let words = settings.words().into_iter().enumerate();
    let mut requests: Vec<Request> =
        words.map(|(setting, word)| Request::write(setting_address(setting), word)).collect();
    requests.push(Request::write(CONTROL, 1 << state::RUN));
    requests
}

/// All that a host may do, in scans that take `scan` clocks each.
fn conversation(interface: &Interface, plan: &RegisterPlan, scan: u64) -> Vec<Request> {
    let settings = plan.settings_of(&interface.timing, &interface.source_codes);
    let wait = Request::Wait { clocks: scan };
    let read = |address| Request::Read { address };
    let status =
        |bits: &[u32]| Request::write(STATUS, bits.iter().fold(0, |word, bit| word | 1 << bit));
    let run =
        |bits: &[u32]| Request::write(CONTROL, bits.iter().fold(0, |word, bit| word | 1 << bit));
    let all = [state::OVERRUN, state::SATURATED, state::REFUSED];
    let mut requests = vec![wait, wait];
    // Flags, of results that nobody took: one and the others, none and all.
    for flag in all {
        let others: Vec<u32> = all.into_iter().filter(|&other| other != flag).collect();
        requests.extend([wait, read(STATUS), status(&others), read(STATUS)]);
        requests.extend([status(&[flag]), read(STATUS)]);
    }
    requests.extend([status(&[]), read(STATUS), status(&all), read(STATUS), read(CONTROL)]);
    // Every setting, each in a scan of its own.
    let others: Vec<u32> = {
        let delay = (plan.period_chips / 2) << plan.sample_bits | 1;
        let scan = [plan.least_chips + 5, 3, delay];
        let seeds = settings.seeds.iter().map(|seed| seed ^ 1);
        scan.into_iter().chain(seeds).map(|word| word as u32).collect()
    };
    for (setting, word) in others.into_iter().enumerate() {
        requests.extend([
            Request::write(setting_address(setting), word),
            wait,
            read(setting_address(setting)),
        ]);
    }
    // Taps of another primitive polynomial, and of x^n + 1, whose sequence of n chips does not fit into a period.
    let taps = plan.seeds.iter().zip(&settings.seeds).enumerate();
    for (number, (&Seed { degree, .. }, word)) in taps.filter(|(_, (seed, _))| seed.has_taps()) {
        let (chips, present) = (word & ((1 << degree) - 1), word >> degree);
        let primitive =
            (1 << (degree - 1)..).find(|&taps| taps != present && is_maximal(degree, taps));
        for (taps, chips) in primitive.map(|taps| (taps, chips)).into_iter().chain([(1, 1)]) {
            let word = (taps << degree | chips) as u32;
            requests.extend([
                Request::write(setting_address(SCAN_WORDS + number), word),
                wait,
                wait,
            ]);
        }
    }
    // Delays of every number of samples.
    if plan.fixed_samples.is_none() {
        for samples in 0..1 << plan.sample_bits {
            let delay = (u64::from(samples) * 5 % plan.period_chips) << plan.sample_bits;
            let word = delay as u32 | samples;
            requests.extend([Request::write(setting_address(2), word), wait]);
        }
    }
    // Scans of one group that end less than five chips before a code period.
    requests.push(Request::write(setting_address(1), 1));
    for short_by in 0..=4 {
        let chips = chips_to_an_epoch(plan) - short_by;
        if chips >> plan.chips_bits == 0 {
            requests.push(Request::write(setting_address(0), chips as u32));
            requests.extend([wait; 4]);
        }
    }
    requests.extend(short_scans(plan));
    // Settings at every moment of scans, take-overs among them.
    for turn in 0..64 {
        let clocks = 7 + turn % 5;
        requests.extend([Request::write(setting_address(1), 2), Request::Wait { clocks }]);
    }
    // Settings that do not fit.
    let (low, step) = (plan.least_chips as u32, 0);
    for (setting, bad, good) in [(0, low - 1, low), (1, 0, 2), (2, u32::MAX, step)] {
        requests.extend([Request::write(setting_address(setting), bad), wait, read(STATUS)]);
        requests.extend([status(&[state::REFUSED]), read(STATUS)]);
        requests.extend([Request::write(setting_address(setting), good), run(&[state::RUN]), wait]);
    }
    // Stopped, one scan, two at once, and on again.
    requests.extend([read(STATUS), run(&[]), wait, read(STATUS), status(&all), read(STATUS)]);
    requests.extend([run(&[state::SINGLE]), wait, wait]);
    requests.extend([run(&[state::RUN, state::SINGLE]), wait, run(&[state::RUN]), wait]);
    // What is not a register, or cannot be written.
    let beyond = 4 << plan.word_bits();
    for word in 0..IDENTITY_WORDS as u32 + plan.settings() as u32 + 1 {
        if (word as usize) < IDENTITY_WORDS || word as usize >= plan.words() {
            requests.extend([Request::write(4 * word, !0), read(4 * word)]);
        }
    }
    for address in [beyond, 0x3fc, 0x408, 0x4fc, 0x600, 0x800, 0xc00, 0xffc] {
        requests.extend([Request::write(address, !0), read(address)]);
    }
    for peak in 0..plan.readings() + 1 {
        requests.extend([Request::write(PEAKS + 4 * peak, !0), read(PEAKS + 4 * peak)]);
    }
    for strobe in [0, 1, 7, 8, 14] {
        for address in [setting_address(0), CONTROL, STATUS] {
            requests.push(Request::Write { address, data: !0, strobe });
        }
    }
    requests
}

/// All that a host may do with a target that is followed, in scans that take `scan` clocks each, and about how many
/// clocks that takes. Hits are as chance has them: with a threshold of a 128th every other window has light.
fn track_conversation(plan: &RegisterPlan, scan: u64) -> (Vec<Request>, u64) {
    let (Some(track), Some(own)) = (&plan.track, plan.track_setting()) else {
        return (Vec::new(), 0);
    };
    let takes = |chips| scan + track.window_steps() * chips + u64::from(track.decision_clocks());
    let window = takes(plan.least_chips);
    let set = |is_on, numbers: [u32; 3]| {
        let [gain_halvings, threshold_halvings, patience] = numbers;
        let setting = TrackSetting { is_on, gain_halvings, threshold_halvings, patience };
        Request::write(setting_address(own), setting.word())
    };
    let read = |address| Request::Read { address };
    let flag = Request::write(STATUS, 1 << state::LOCK_LOST);
    let look = [read(STATUS), read(plan.position_address()), Request::Wait { clocks: window }];
    let mut requests = short_scans(plan);
    let last_step = (plan.period_chips << plan.sample_bits) as u32 - 1;
    let longer = long_steps(plan);
    // Chips of a step, windows, and numbers. Of long steps halves may have counts of much more than all; of many windows some have
    // counts that cancel.
    let turns = [
        (plan.least_chips, 40, [0, 7, 15]),
        (plan.least_chips, 12, [1, 7, 1]),
        (plan.least_chips, 40, [2, 2, 3]),
        (plan.least_chips, 12, [7, 7, 15]),
        (plan.least_chips, 40, [0, 1, 1]),
        (plan.least_chips, 24, [0, 0, 9]),
        (plan.least_chips, 32, [0, 0, 13]),
        (longer, 30, [0, 7, 15]),
        (plan.least_chips, 12, [3, 3, 4]),
        (plan.least_chips, 12, [4, 4, 6]),
        (plan.least_chips, 12, [5, 5, 10]),
        (plan.least_chips, 12, [6, 6, 12]),
    ];
    for (turn, (chips, windows, numbers)) in turns.into_iter().enumerate() {
        // At either end of the code period, and scans of a single step, whose count is as often negative as not.
        let (first, groups) = if turn % 2 == 0 { (0, 1) } else { (last_step, 2) };
        let settings = [chips as u32, groups, first].into_iter().enumerate();
        requests
            .extend(settings.map(|(number, word)| Request::write(setting_address(number), word)));
        requests.push(set(true, numbers));
        (0..windows).for_each(|_| requests.extend(look));
        // Cleared is what is written 1.
        requests.extend([Request::write(STATUS, !(1 << state::LOCK_LOST)), read(STATUS)]);
        requests.extend([flag, read(STATUS)]);
    }
    // Stopped while it follows, and on again, when a window of long steps has passed; settings that do not fit; and turned off.
    requests.extend(short_scans(plan));
    requests.extend([set(true, [0, 7, 15]), Request::Wait { clocks: takes(longer) }]);
    for _ in 0..4 {
        requests.extend([Request::write(CONTROL, 0), look[2], read(STATUS)]);
        requests.extend([Request::write(CONTROL, 1 << state::RUN), look[2], look[2]]);
    }
    requests.extend([Request::write(setting_address(0), 1), look[2], look[2], read(STATUS)]);
    requests.push(Request::write(STATUS, 1 << state::REFUSED));
    requests.extend(short_scans(plan));
    requests.extend([Request::write(CONTROL, 1 << state::RUN), look[2], look[2]]);
    // A window that follows is the last, whether it has the light or loses what is no longer followed.
    for patience in [0, 15].repeat(6) {
        let threshold = if patience == 0 { 0 } else { 7 };
        requests.extend([set(true, [0, 7, 15]), look[2], look[2], look[2]]);
        requests.extend([set(false, [0, threshold, patience]), look[2], look[2]]);
        requests.extend([read(STATUS), flag]);
    }
    let clocks = 510 * window + takes(longer);
    (requests, clocks)
}

/// Chips of a step that has many more hits than the shortest.
fn long_steps(plan: &RegisterPlan) -> u64 {
    (8 * plan.least_chips).min((1 << plan.chips_bits) - 1)
}

/// Chips of a step, not of the shortest, that is whole code periods.
fn chips_to_an_epoch(plan: &RegisterPlan) -> u64 {
    plan.least_chips.next_multiple_of(plan.period_chips) + plan.period_chips
}

/// Scans over the whole code period, which take `scan` clocks each: some, settings in one of them, and a
/// stop behind one that another has followed.
fn whole_scans(plan: &RegisterPlan, scan: u64) -> Vec<Request> {
    let wait = Request::Wait { clocks: scan };
    let groups = plan.whole_groups.unwrap_or(1) as u32;
    vec![
        Request::write(setting_address(1), groups),
        wait,
        wait,
        Request::write(setting_address(0), plan.least_chips as u32 + 1),
        wait,
        wait,
        wait,
        Request::write(CONTROL, 0),
        wait,
        wait,
        Request::Read { address: STATUS },
        Request::write(CONTROL, 1 << state::RUN),
        wait,
    ]
}

/// Addresses that are worth reading, and some that are not.
pub(in crate::reference) fn addresses(plan: &RegisterPlan) -> Vec<u32> {
    let words = (0..1 << plan.word_bits()).map(|word| 4 * word);
    let peaks = (0..plan.readings() + 1).map(|word| PEAKS + 4 * word);
    words.chain([CONTROL, STATUS, 0x408, 0x800]).chain(peaks).collect()
}
