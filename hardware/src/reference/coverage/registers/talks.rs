//! What a host asks for on the way to the cover points of registers: its talks, in scans that cannot be shortened.

use super::{
    Extreme, LONG_STALL, Meeting, RegisterPoint, ScanStart, TrackNumber, TrackPoint,
    chips_to_an_epoch, ends_of,
};
use crate::code::is_maximal;
use crate::reference::group_maker::GroupMaker;
use crate::reference::host::{Channel, HardwareEvent, Request};
use crate::reference::planned::{Hits, PlannedGroup, ReceiverPlan};
use crate::scan::CHIPS_TO_PREPARATION;
use crate::scene::DetectorIndex;
use crate::sensor::interface::Interface;
use crate::sensor::registers::{
    CONTROL, IDENTITY_WORDS, LOST_BITS, PEAKS, RegisterPlan, SCAN_WORDS, STATUS, Seed,
    setting_address, state,
};
use crate::sensor::track::{MOST_PATIENCE, TrackSetting};

/// Most clocks of scans that are there to be counted: 2^16 of them take many times as long as all other talks.
const MOST_CLOCKS_OF_SCANS: u64 = 1 << 18;

/// What a host asks for, and what comes upon the sensor meanwhile.
struct Talk {
    requests: Vec<Request>,
    /// About as many clocks as it takes.
    clocks: u64,
    /// Hits of the groups behind its beginning; chance has those behind them.
    hits: Vec<Hits>,
    /// What the receiver does then, if anything else than to stall.
    receiver: Option<ReceiverPlan>,
}

impl Talk {
    /// Of so many clocks, with hits as chance has them.
    fn new(requests: Vec<Request>, clocks: u64) -> Talk {
        Talk { requests, clocks, hits: Vec::new(), receiver: None }
    }

    /// With more at its end, which takes hardly any longer.
    fn then(mut self, more: impl IntoIterator<Item = Request>) -> Talk {
        self.requests.extend(more);
        self
    }
}

/// Groups in which a host talks until it has reached a point. A few conversations have all of them; what depends on chance
/// shows when they are held again.
pub(super) fn recipe(
    point: RegisterPoint,
    maker: &GroupMaker,
) -> Result<Vec<PlannedGroup>, String> {
    let Some(plan) = &maker.interface.registers else {
        return Err("there are no registers".to_owned());
    };
    let Talk { requests, clocks, hits, receiver } = talk_of(point, maker.interface, plan);
    let most_clocks = match point {
        RegisterPoint::ScansCounted { .. } => MOST_CLOCKS_OF_SCANS,
        _ => u64::MAX,
    };
    if clocks > most_clocks.min(maker.reach.most_clocks_of_talk) {
        return Err(format!("it takes {clocks} clocks"));
    }
    let mut groups = vec![maker.fresh().asks(short_scans(plan))];
    let talks = PlannedGroup::random().after_reset(3, 4).received(ReceiverPlan::Stalls);
    groups.push(talks.asks(requests));
    groups.extend(receiver.map(|receiver| PlannedGroup::random().received(receiver)));
    groups.extend(hits.into_iter().map(|hits| PlannedGroup::random().with(hits)));
    groups.push(PlannedGroup::random().received(ReceiverPlan::Stalls));
    groups.push(PlannedGroup::random().asks(as_in_the_scene(maker.interface, plan)));
    groups.push(PlannedGroup::random());
    Ok(groups)
}

/// The talk that should reach a point.
fn talk_of(point: RegisterPoint, interface: &Interface, plan: &RegisterPlan) -> Talk {
    let timing = &interface.timing;
    let scan = timing.preparation_chips + 2 * timing.code_chips() + 4 * plan.least_chips;
    match point {
        RegisterPoint::Began {
            how: ScanStart::GoesOn | ScanStart::ChangedWhole | ScanStart::AfterStopWhole,
        } => {
            let whole = plan.whole_groups.unwrap_or(0).saturating_mul(plan.least_chips);
            Talk::new(whole_scans(plan, scan + whole), 10 * (scan + whole))
        }
        RegisterPoint::Extreme { setting, extreme } => extreme_scans(plan, scan, setting, extreme),
        RegisterPoint::Stalled { channel } => stalls(channel, scan),
        RegisterPoint::Met { meeting } => meets(plan, scan, meeting),
        RegisterPoint::MinusOne { detector } => minus_one(plan, detector, scan),
        RegisterPoint::LostGoesRound => many_losses(plan, scan),
        RegisterPoint::ScansCounted { bit } => many_scans(timing.preparation_chips, plan, bit),
        RegisterPoint::Tracked {
            what: TrackPoint::Number { number: TrackNumber::Threshold, extreme },
        } => dim_windows(plan, scan, extreme),
        RegisterPoint::Tracked {
            what: TrackPoint::Number { number: TrackNumber::Patience, extreme },
        } => {
            let patience = if extreme == Extreme::Least { 1 } else { MOST_PATIENCE };
            let talk = patient_windows(plan, scan, patience);
            let looks = looks(plan, plan.least_chips, talk.clocks);
            talk.then(looks)
        }
        _ => {
            let (mut requests, (track, waits)) =
                (conversation(interface, plan, scan), track_conversation(plan, scan));
            requests.extend(track);
            Talk::new(requests, 96 * scan + 2_000 + waits)
        }
    }
}

/// Scans with a setting at an end of its range, otherwise as short as may be, and their clocks.
fn extreme_scans(plan: &RegisterPlan, scan: u64, setting: usize, extreme: Extreme) -> Talk {
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
    Talk::new(talk, 4 * scan + clocks + 200)
}

/// Writes or reads of which one transfer is stalled for long, the second time beyond any number of bits that a
/// slave may count in.
fn stalls(channel: Channel, scan: u64) -> Talk {
    let (transfer, longest) = match channel {
        // Scans go on, and are counted: one has ended meanwhile, however long it takes.
        Channel::Read => (Request::Read { address: STATUS }, scan),
        _ => (Request::write(setting_address(1), 2), 0),
    };
    let longest = u32::try_from(longest).unwrap_or(u32::MAX).max(2 * LONG_STALL);
    let stall = |clocks| [Request::Stall { channel, clocks }, transfer];
    let requests = [LONG_STALL, longest].into_iter().flat_map(stall).collect();
    Talk::new(requests, 2 * u64::from(LONG_STALL.saturating_add(longest)))
}

/// Scans of one group that each have a single hit, which all of its steps count down, and whose peaks are read.
fn minus_one(plan: &RegisterPlan, detector: DetectorIndex, scan: u64) -> Talk {
    const SCANS: usize = 12;
    let settings = [plan.period_chips.max(plan.least_chips), 1].into_iter().enumerate();
    let mut talk: Vec<Request> = settings
        .map(|(setting, word)| Request::write(setting_address(setting), word as u32))
        .collect();
    let clocks = scan + plan.period_chips;
    let look = [
        Request::Wait { clocks: clocks / 2 },
        Request::Read { address: PEAKS + 4 * (2 * detector.0 as u32 + 1) },
    ];
    talk.extend(look.repeat(2 * SCANS));
    let hits = vec![Hits::OneForAll { detector, up: false }; SCANS];
    Talk { hits, ..Talk::new(talk, (SCANS as u64 + 2) * clocks) }
}

/// Scans of many groups, none of which is taken, until the number of the lost ones has gone round.
fn many_losses(plan: &RegisterPlan, scan: u64) -> Talk {
    let groups = (1 << plan.groups_bits) - 1;
    let lost = (1 << LOST_BITS) + 16;
    let clocks = lost * plan.least_chips + (lost.div_ceil(groups) + 3) * scan;
    let mut talk = short_scans(plan);
    talk.push(Request::write(setting_address(1), groups as u32));
    talk.extend([Request::Wait { clocks }, Request::Read { address: STATUS }]);
    let receiver = Some(ReceiverPlan::StopsAt { beat: 0, clocks });
    Talk { receiver, ..Talk::new(talk, clocks) }
}

/// Scans of one group until this bit of their number has come to be set, as have those below it.
fn many_scans(preparation_chips: u64, plan: &RegisterPlan, bit: u32) -> Talk {
    // Its preparation begins with a code period.
    let chips = preparation_chips + plan.least_chips + CHIPS_TO_PREPARATION;
    let scan = chips.next_multiple_of(plan.period_chips);
    let read = Request::Read { address: STATUS };
    let mut talk = vec![
        Request::write(setting_address(0), plan.least_chips as u32),
        Request::write(setting_address(1), 1),
    ];
    talk.extend(
        (0..=bit).flat_map(|bit| [Request::Wait { clocks: scan << bit.saturating_sub(1) }, read]),
    );
    Talk::new(talk, scan << bit)
}

/// Writes in the very clock of what the hardware does.
fn meets(plan: &RegisterPlan, scan: u64, meeting: Meeting) -> Talk {
    // Chance has its part: whether the read comes soon enough, and whether a result was taken.
    const TIMES: u64 = 4;
    let Meeting { bit, event } = meeting;
    let talk_of = |within| {
        let (address, data) = (meeting.address(), 1 << bit);
        [Request::Meet { event, address, data, within }, Request::Read { address }]
    };
    if event == HardwareEvent::TargetLost {
        let talk = patient_windows(plan, scan, MOST_PATIENCE);
        let meets = talk_of(talk.clocks);
        return talk.then(meets);
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
    Talk { hits, ..Talk::new(talk, TIMES * (within + 100)) }
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

/// A target with light, and then windows that count down alone until it is lost with so much patience.
fn patient_windows(plan: &RegisterPlan, scan: u64, patience: u32) -> Talk {
    let Some((track, on)) = plan.track.as_ref().zip(track_with(plan, [0, 0, patience])) else {
        return Talk::new(Vec::new(), 0);
    };
    let steps = track.window_steps();
    let windows = u64::from(patience) + 3;
    let mut hits = vec![Hits::AllSteps { up: true }; LIT_GROUPS];
    // A scan without any hit would not show what came before it.
    hits.extend(vec![Hits::AllSteps { up: false }; (windows * steps) as usize]);
    let clocks = (windows + LIT_SCANS) * (scan + steps * plan.least_chips);
    let mut talk = short_scans(plan);
    talk.push(on);
    Talk { hits, ..Talk::new(talk, clocks) }
}

/// Reads of what is told of a target, one at least in each window with steps of so many chips, for so many clocks.
fn looks(plan: &RegisterPlan, chips: u64, clocks: u64) -> Vec<Request> {
    let window = plan.track.as_ref().map_or(0, |track| track.window_steps() * chips);
    let pause = window / 2;
    let look = [
        Request::Read { address: STATUS },
        Request::Read { address: plan.position_address() },
        Request::Wait { clocks: pause },
    ];
    look.repeat((clocks / pause.max(1)) as usize)
}

/// A target with light, and then windows with less and less of it until the threshold is between.
fn dim_windows(plan: &RegisterPlan, scan: u64, extreme: Extreme) -> Talk {
    let halvings = if extreme == Extreme::Least { 7 } else { 0 };
    let Some((track, on)) = plan.track.as_ref().zip(track_with(plan, [0, halvings, 15])) else {
        return Talk::new(Vec::new(), 0);
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
    let talk = vec![
        Request::write(setting_address(0), chips as u32),
        Request::write(setting_address(1), 2),
        on,
    ];
    Talk { hits, ..Talk::new(talk, clocks) }.then(looks(plan, chips, clocks))
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
    for clocks in [1, 0, 1, 2, 1, 3] {
        let stop = Request::Follow { address: CONTROL, data: 0, read: STATUS, clocks };
        requests.extend([stop, look[2], read(STATUS)]);
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
    let clocks = 516 * window + takes(longer);
    (requests, clocks)
}

/// Chips of a step that has many more hits than the shortest.
fn long_steps(plan: &RegisterPlan) -> u64 {
    // Of all the light a 128th is to be a hit at least, and every eighth sample has one, or so.
    let chips = (1024 >> plan.sample_bits).max(8 * plan.least_chips);
    chips.min((1 << plan.chips_bits) - 1)
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
