//! Several SPADs in one lane: cells of a pixel, detectors that fire one another, or one that
//! each arrival makes blind anew.
//!
//! Light of all members is drawn from where the last arrival was, not from the end of a dead time:
//! one process of cells that are alike, each arrival of which falls on any of them (a thinned
//! Poisson process is as many independent ones). What falls on a member that is blind is lost,
//! or with passive recharge begins its dead time anew.
//!
//! What an avalanche causes is pending until it is due: crosstalk, and the first of its
//! afterpulses, with the expected number of later ones. Those follow one another as soon as each is due, fired or
//! not, because a Poisson process is drawn one by one as well as at once. Afterpulses of one
//! member are one process, so those that are left as one of them fires go on with the new ones,
//! less what decays in the dead time. There are as many places for what is pending as any lane has needed.

use super::arithmetic::{
    Floats, LANES, LaneWords, LookUp, choose, exponential, minus_log2, to_ticks, wrap,
};
use super::streams::LaneStreams;
use crate::photons::random::{RandomStream, StreamKey, scatter};

/// Nothing is pending: later than anything that is.
const FREE: u32 = u32::MAX;
/// Bits of what is pending: the member that it fires,
const MEMBER: u32 = 0xff;
/// whether its delay counts from the end of a dead time that is still going on,
const LATEST: u32 = 1 << 9;
/// and whether it has come already, and those that follow it are to be drawn.
const PAST: u32 = 1 << 10;

/// A number of each member.
#[derive(Debug, Clone)]
pub enum PerMember {
    Same(u32),
    Unlike(Box<LookUp>),
}

impl PerMember {
    pub fn new(values: &[u32]) -> PerMember {
        match values.windows(2).all(|two| two[0] == two[1]) {
            true => PerMember::Same(values[0]),
            false => PerMember::Unlike(Box::new(LookUp::new(values.iter().copied()))),
        }
    }

    /// Of numbers with a fraction, as bits.
    pub fn of_floats(values: impl Iterator<Item = f64>) -> PerMember {
        PerMember::new(&values.map(|value| (value as f32).to_bits()).collect::<Vec<_>>())
    }

    #[inline(always)]
    fn at(&self, members: &LaneWords) -> LaneWords {
        match self {
            PerMember::Same(value) => LaneWords::all(*value),
            PerMember::Unlike(table) => table.at(members),
        }
    }
}

/// On which members light falls.
#[derive(Debug, Clone)]
pub enum LitMembers {
    /// On each as much.
    All,
    One(u32),
    /// By chance: the thresholds to 31 random bits that the members but the last one end with.
    Shares(Vec<i32>),
}

/// Afterpulses of each member.
#[derive(Debug, Clone)]
pub struct Traps {
    /// Expected number of an avalanche.
    pub means: PerMember,
    pub half_lives: PerMember,
    /// Share that does not decay in the dead time, and goes on with those of the next avalanche.
    pub left: PerMember,
}

/// What an avalanche fires.
#[derive(Debug, Clone)]
pub enum CrosstalkTargets {
    /// One of the other cells, each as likely.
    Cells { threshold: i32, delay: u32 },
    /// By the one that fires: a threshold to 31 random bits, whom it fires and when.
    Link { thresholds: PerMember, targets: PerMember, delays: PerMember },
}

/// What members are like.
#[derive(Debug, Clone)]
pub struct MemberTables {
    pub number: u32,
    /// Whose avalanches count; everyone's if none.
    pub own: Option<u32>,
    pub is_paralyzable: bool,
    pub dead_times: PerMember,
    pub traps: Option<Traps>,
    pub crosstalk: Vec<CrosstalkTargets>,
}

/// What is pending, one of each lane.
#[derive(Debug, Clone)]
struct Pending {
    /// Ticks until it is due, or [`FREE`].
    left: LaneWords,
    what: LaneWords,
    /// Expected number of afterpulses after it.
    masses: Floats,
}

impl Pending {
    fn none() -> Pending {
        Pending { left: LaneWords::all(FREE), what: LaneWords::all(0), masses: Floats::all(0.0) }
    }
}

/// The members of all lanes.
#[derive(Debug)]
pub struct Members<'t> {
    tables: &'t MemberTables,
    /// Of each, ticks for which it is still blind, and one more: what comes the moment it gets ready is lost.
    blind: Vec<LaneWords>,
    pending: Vec<Pending>,
    /// On whom light falls.
    choice: LaneStreams,
    trapped: LaneStreams,
    talk: Vec<LaneStreams>,
    /// Who decides, 31 bits.
    chances: LaneWords,
    /// Whom the earliest arrival falls on.
    pub hit: LaneWords,
}

impl<'t> Members<'t> {
    pub fn new(tables: &'t MemberTables) -> Members<'t> {
        Members {
            tables,
            blind: vec![LaneWords::all(0); tables.number as usize],
            pending: vec![Pending::none()],
            choice: LaneStreams::new(),
            trapped: LaneStreams::new(),
            talk: tables.crosstalk.iter().map(|_| LaneStreams::new()).collect(),
            chances: LaneWords::all(0),
            hit: LaneWords::all(0),
        }
    }

    /// Starts a lane with members that are blind for so many ticks.
    pub fn start(&mut self, lane: usize, key: &StreamKey, blind: impl Iterator<Item = u32>) {
        for (member, ticks) in self.blind.iter_mut().zip(blind) {
            member[lane] = ticks;
        }
        for pending in &mut self.pending {
            pending.left[lane] = FREE;
        }
        self.choice.restart(lane, key.hash(RandomStream::Member));
        self.trapped.restart(lane, key.hash(RandomStream::Afterpulsing));
        for (talk, number) in self.talk.iter_mut().zip(0..) {
            talk.restart(lane, scatter(key.hash(RandomStream::Crosstalk), number));
        }
        self.hit[lane] = 0;
    }

    /// Before light is drawn: all members are hit alike.
    #[inline(always)]
    pub fn choose(&mut self) {
        let number = self.tables.number;
        if number == 1 {
            return;
        }
        let random = self.choice.next();
        let share = number as f32 / (1_u32 << 24) as f32;
        for lane in 0..LANES {
            self.chances[lane] = random[lane] >> 1;
            let place = (random[lane] >> 8) as i32 as f32 * share;
            self.hit[lane] = to_whole(place).min(number.wrapping_sub(1));
        }
    }

    /// Light of a target has shortened the waits.
    #[inline(always)]
    pub fn aim(&mut self, target: &LitMembers, before: &LaneWords, waits: &LaneWords) {
        let members = match target {
            LitMembers::All => return,
            LitMembers::One(member) => LaneWords::all(*member),
            LitMembers::Shares(thresholds) => {
                let mut members = LaneWords::all(0);
                for &threshold in thresholds {
                    for lane in 0..LANES {
                        let is_later = u32::from(self.chances[lane] as i32 > threshold);
                        members[lane] = members[lane].wrapping_add(is_later);
                    }
                }
                members
            }
        };
        for lane in 0..LANES {
            self.hit[lane] = choose(waits[lane] < before[lane], members[lane], self.hit[lane]);
        }
    }

    /// What comes first of light, of what is pending and of where waits are cut: gives how far
    /// time goes on, and 1 where an avalanche counts, otherwise 0.
    #[inline(always)]
    pub fn arrive(&mut self, waits: &LaneWords, cuts: &LaneWords) -> (LaneWords, LaneWords) {
        let (mut elapsed, mut what) = (LaneWords::all(FREE), LaneWords::all(0));
        let (mut places, mut masses) = (LaneWords::all(FREE), Floats::all(0.0));
        for (pending, place) in self.pending.iter().zip(0..) {
            for lane in 0..LANES {
                let is_first = pending.left[lane] < elapsed[lane];
                elapsed[lane] = if is_first { pending.left[lane] } else { elapsed[lane] };
                what[lane] = if is_first { pending.what[lane] } else { what[lane] };
                masses[lane] = if is_first { pending.masses[lane] } else { masses[lane] };
                places[lane] = if is_first { place } else { places[lane] };
            }
        }
        let mut arrived = LaneWords::all(0);
        for lane in 0..LANES {
            let wait = waits[lane].min(cuts[lane]);
            let is_due = elapsed[lane] <= wait;
            let is_light = waits[lane] < cuts[lane];
            elapsed[lane] = elapsed[lane].min(wait);
            what[lane] = if is_due { what[lane] } else { 0 };
            let arrives = if is_due { what[lane] & PAST == 0 } else { is_light };
            arrived[lane] = if arrives { u32::MAX } else { 0 };
            self.hit[lane] = if is_due { what[lane] & MEMBER } else { self.hit[lane] };
            places[lane] = if is_due { places[lane] } else { FREE };
            masses[lane] = if is_due { masses[lane] } else { 0.0 };
        }

        let tables = self.tables;
        let dead_times = tables.dead_times.at(&self.hit);
        // How long it may still be blind to begin its dead time.
        let begins = if tables.is_paralyzable { u32::MAX } else { 0 };
        let mut target = LaneWords::all(0);
        for lane in 0..LANES {
            target[lane] = if arrived[lane] != 0 { self.hit[lane] } else { FREE };
        }
        let mut left = LaneWords::all(0);
        for (blind, member) in self.blind.iter_mut().zip(0..) {
            for lane in 0..LANES {
                let still = blind[lane].saturating_sub(elapsed[lane]);
                let anew = dead_times[lane].wrapping_add(1);
                let if_hit = if still <= begins { anew } else { still };
                let is_hit = target[lane] == member;
                left[lane] = if is_hit { still } else { left[lane] };
                blind[lane] = if is_hit { if_hit } else { still };
            }
        }
        let (mut fired, mut counted) = (LaneWords::all(0), LaneWords::all(0));
        for lane in 0..LANES {
            fired[lane] = if left[lane] == 0 { arrived[lane] } else { 0 };
            counted[lane] = fired[lane] & 1;
        }
        if let Some(own) = tables.own {
            for lane in 0..LANES {
                counted[lane] = if self.hit[lane] == own { counted[lane] } else { 0 };
            }
        }
        for (pending, place) in self.pending.iter_mut().zip(0..) {
            for lane in 0..LANES {
                let left = pending.left[lane];
                let later = left.wrapping_sub(elapsed[lane]);
                let is_gone = (left == FREE) | (places[lane] == place);
                pending.left[lane] = if is_gone { FREE } else { later };
            }
        }
        if tables.is_paralyzable {
            self.prolong(&places, &arrived, &fired, &left, &dead_times);
        }
        self.trap(&fired, &dead_times, &masses);
        self.cause(&fired);
        (elapsed, counted)
    }

    /// What the afterpulses of passive recharge have beside those of active.
    #[inline(always)]
    fn prolong(
        &mut self,
        places: &LaneWords,
        arrived: &LaneWords,
        fired: &LaneWords,
        left: &LaneWords,
        dead_times: &LaneWords,
    ) {
        let (mut past, mut its) = (LaneWords::all(0), LaneWords::all(0));
        let (mut longer, mut begun) = (LaneWords::all(0), LaneWords::all(0));
        for lane in 0..LANES {
            past[lane] = if fired[lane] != 0 { places[lane] } else { FREE };
            its[lane] = if arrived[lane] != 0 { self.hit[lane] | LATEST } else { FREE };
            let anew = dead_times[lane].wrapping_add(1).wrapping_sub(left[lane]);
            longer[lane] = if fired[lane] != 0 { 0 } else { anew };
            begun[lane] = if fired[lane] != 0 { !LATEST } else { FREE };
        }
        for (pending, place) in self.pending.iter_mut().zip(0..) {
            for lane in 0..LANES {
                let (what, left) = (pending.what[lane], pending.left[lane]);
                // Those of the last avalanche wait for the end of its dead time, which begins
                // anew; earlier ones come when they come.
                let is_its = what & (MEMBER | LATEST) == its[lane];
                let later = if left == FREE { FREE } else { left.wrapping_add(longer[lane]) };
                let later = if is_its { later } else { left };
                let begun = if is_its { what & begun[lane] } else { what };
                // Those that follow one that has fired prolong the dead time, too.
                let is_past = past[lane] == place;
                pending.left[lane] = if is_past { 0 } else { later };
                pending.what[lane] = if is_past { begun | PAST } else { begun };
            }
        }
    }

    /// Afterpulses of those that have fired, and those that follow one that was due.
    #[inline(always)]
    fn trap(&mut self, fired: &LaneWords, dead_times: &LaneWords, masses: &Floats) {
        let tables = self.tables;
        let Some(traps) = &tables.traps else { return };
        let means = traps.means.at(&self.hit);
        let half_lives = traps.half_lives.at(&self.hit);
        let kept = traps.left.at(&self.hit);
        let latest = if tables.is_paralyzable { LATEST } else { 0 };
        let random = self.trapped.next();
        let (mut comes, mut left) = (LaneWords::all(0), LaneWords::all(0));
        let (mut what, mut later) = (LaneWords::all(0), Floats::all(0.0));
        for lane in 0..LANES {
            let new = masses[lane] * f32::from_bits(kept[lane]) + f32::from_bits(means[lane]);
            let mass = if fired[lane] != 0 { new } else { masses[lane] };
            let passed = exponential(random[lane]);
            let wait = minus_log2(1.0 - passed / mass, 0) * f32::from_bits(half_lives[lane]);
            comes[lane] = if passed < mass { u32::MAX } else { 0 };
            left[lane] = (dead_times[lane] & fired[lane]).wrapping_add(to_ticks(wait));
            what[lane] = self.hit[lane] | (latest & fired[lane]);
            later[lane] = mass - passed;
        }
        self.insert(&mut comes, &left, &what, &later);
    }

    /// What the avalanches cause at other members.
    #[inline(always)]
    fn cause(&mut self, fired: &LaneWords) {
        let tables = self.tables;
        for (place, crosstalk) in tables.crosstalk.iter().enumerate() {
            let random = self.talk[place].next();
            let (mut talks, mut whats) = (LaneWords::all(0), LaneWords::all(0));
            let delays = match crosstalk {
                CrosstalkTargets::Cells { threshold, delay } => {
                    let others = tables.number.wrapping_sub(1);
                    let share = others as f32 / (*threshold as f32 + 1.0);
                    for lane in 0..LANES {
                        let chance = (random[lane] >> 1) as i32;
                        let is_heard = chance <= *threshold;
                        talks[lane] = if is_heard { fired[lane] } else { 0 };
                        let within = chance.min(*threshold) as f32 * share;
                        let other = to_whole(within).min(others.wrapping_sub(1));
                        let to = self.hit[lane].wrapping_add(1).wrapping_add(other);
                        whats[lane] = wrap(to, tables.number);
                    }
                    LaneWords::all(*delay)
                }
                CrosstalkTargets::Link { thresholds, targets, delays } => {
                    let thresholds = thresholds.at(&self.hit);
                    let targets = targets.at(&self.hit);
                    for lane in 0..LANES {
                        let is_heard = (random[lane] >> 1) as i32 <= thresholds[lane] as i32;
                        talks[lane] = if is_heard { fired[lane] } else { 0 };
                        whats[lane] = targets[lane];
                    }
                    delays.at(&self.hit)
                }
            };
            self.insert(&mut talks, &delays, &whats, &Floats::all(0.0));
        }
    }

    /// Puts what is wanted (all bits) where nothing is pending.
    #[inline(always)]
    fn insert(
        &mut self,
        wanted: &mut LaneWords,
        left: &LaneWords,
        what: &LaneWords,
        masses: &Floats,
    ) {
        for pending in &mut self.pending {
            place(pending, wanted, left, what, masses);
        }
        if wanted.iter().fold(0, |any, wanted| any | wanted) != 0 {
            self.grow(wanted, left, what, masses);
        }
    }

    #[cold]
    #[inline(never)]
    fn grow(
        &mut self,
        wanted: &mut LaneWords,
        left: &LaneWords,
        what: &LaneWords,
        masses: &Floats,
    ) {
        let mut pending = Pending::none();
        place(&mut pending, wanted, left, what, masses);
        self.pending.push(pending);
    }

    /// Gives back the last place if nothing is pending there: to be called now and then.
    #[inline(always)]
    pub fn shrink(&mut self) {
        let is_free = |pending: &Pending| pending.left.iter().all(|&left| left == FREE);
        self.pending.pop_if(|pending| is_free(pending));
    }
}

#[inline(always)]
fn place(
    pending: &mut Pending,
    wanted: &mut LaneWords,
    left: &LaneWords,
    what: &LaneWords,
    masses: &Floats,
) {
    for lane in 0..LANES {
        let takes = (pending.left[lane] == FREE) & (wanted[lane] != 0);
        pending.left[lane] = if takes { left[lane] } else { pending.left[lane] };
        pending.what[lane] = if takes { what[lane] } else { pending.what[lane] };
        pending.masses[lane] = if takes { masses[lane] } else { pending.masses[lane] };
        wanted[lane] = if takes { 0 } else { wanted[lane] };
    }
}

/// A number from 0 to 2^30, cut.
#[inline(always)]
fn to_whole(number: f32) -> u32 {
    // SAFETY: finite and within 31 bits, as the callers' products are.
    unsafe { number.to_int_unchecked::<i32>() as u32 }
}
