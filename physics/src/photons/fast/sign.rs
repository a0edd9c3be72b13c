//! The counter's sign, without drawing a normal where jitter is less than a chip.
//!
//! Time is cut into cells of a chip, each with one possible edge of the
//! reference: it goes from the chip before to the chip of the cell, and does
//! nothing if these are alike. A detection in the cell is counted by the level
//! before the edge if jitter carries it there, which has the probability
//! Phi(-x / sigma), x being how far behind the edge it is before jitter. That
//! probability is a table over x, and one uniform number decides. Jitter j is
//! thereby sigma times the quantile of that number, so other questions to the
//! same jitter (is it still before the end of the step?) are answered by the same
//! number, with their true joint probability.
//!
//! Within the transition time w of an edge either sign is equally likely, so the
//! table holds the mean of Phi at x - w and x + w. Rising and falling edges have
//! different delays but the same table.
//!
//! Jitter that reaches beyond a cell is drawn, and the cell is that of the registered time; within w
//! of its edge a coin decides.

use super::arithmetic::{FixedTable, Integers, LANES, LaneWords, LookUp, jitter, quantile};
use super::normal::{self, NORMAL_REACH};
use super::places::{CHIP_TICKS, CodePlaces, repeated, round_ticks, ticks};
use super::streams::LaneStreams;
use crate::math::normal_cdf;

/// Entries of the table of probabilities.
const ENTRIES: usize = 1024;
const LAST: u32 = ENTRIES as u32 - 1;

/// When the sign changes, in chips.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SignEdges {
    pub rising_delay_chips: f64,
    pub falling_delay_chips: f64,
    pub transition_chips: f64,
    /// Standard deviation of the detections' jitter.
    pub jitter_chips: f64,
}

/// Levels of the reference, and what decides near its edges.
#[derive(Debug, Clone)]
pub struct SignTable {
    pub period_chips: u32,
    /// By cell: where what is near its edge begins, in ticks into the cell
    /// (times 4); whether there is an edge (times 2); the level after it.
    cells: LookUp,
    near_edges: NearEdges,
    /// Where the reference's first cell begins, in ticks (not positive where cells begin
    /// before their chip).
    pub first_cell: i64,
    /// Whether chance plays a part at all.
    pub is_random: bool,
}

/// What decides near an edge.
#[derive(Debug, Clone)]
enum NearEdges {
    Table(EdgeTable),
    Drawn(DrawnJitter),
}

/// Probabilities that a detection is registered before an edge.
#[derive(Debug, Clone)]
struct EdgeTable {
    /// Thresholds to 31 random bits, of which `threshold + 1` in 2^31 leave the
    /// detection before the edge.
    thresholds: FixedTable<ENTRIES>,
    /// An entry is for 2^entry_bits ticks.
    entry_bits: u32,
}

/// Each detection's own jitter.
#[derive(Debug, Clone, Copy)]
struct DrawnJitter {
    sigma_ticks: f32,
    /// Ticks round an edge within which either level is as likely.
    transition_ticks: u32,
}

impl SignTable {
    /// With probabilities; `None` if one cell cannot hold both kinds of edges with all that jitter
    /// and transition can reach.
    pub fn new(reference: &[u8], timing: &SignEdges) -> Option<SignTable> {
        let reach = ticks(NORMAL_REACH * timing.jitter_chips + timing.transition_chips) + 1.0;
        if reach >= f64::from(CHIP_TICKS) {
            return None;
        }
        // The first and the last entry must be certain.
        let mut entry_bits = 0;
        while f64::from((ENTRIES as u32 / 2 - 1) << entry_bits) < reach {
            entry_bits += 1;
        }
        let half = i64::from((ENTRIES as u32 / 2) << entry_bits);
        let sigma = ticks(timing.jitter_chips);
        let transition = ticks(timing.transition_chips);
        let threshold = |entry: usize| {
            let from = ((entry as i64) << entry_bits) - half;
            let to = ((entry as i64 + 1) << entry_bits) - half;
            let below = [-transition, transition].map(|shift| {
                normal::mean_below_zero(from as f64 + shift, to as f64 + shift, sigma)
            });
            threshold_of(0.5 * (below[0] + below[1]))
        };
        let thresholds: Vec<i32> = (0..ENTRIES).map(threshold).collect();
        let is_random =
            thresholds.iter().any(|&t| t != threshold_of(0.0) && t != threshold_of(1.0));
        let thresholds = FixedTable::new(thresholds.iter().map(|&threshold| threshold as u32));
        let near_edges = NearEdges::Table(EdgeTable { thresholds, entry_bits });
        SignTable::of_cells(reference, timing, half, near_edges, is_random)
    }

    /// With jitter that is drawn; `None` if one cell cannot hold both kinds of edges with their
    /// transition.
    pub fn drawn(reference: &[u8], timing: &SignEdges) -> Option<SignTable> {
        let half = round_ticks(timing.transition_chips);
        let near_edges = NearEdges::Drawn(DrawnJitter {
            sigma_ticks: ticks(timing.jitter_chips) as f32,
            transition_ticks: u32::try_from(half).ok()?,
        });
        SignTable::of_cells(reference, timing, half, near_edges, true)
    }

    /// Of cells in which chance decides within `half` ticks of an edge.
    fn of_cells(
        reference: &[u8],
        timing: &SignEdges,
        half: i64,
        near_edges: NearEdges,
        is_random: bool,
    ) -> Option<SignTable> {
        let rising = round_ticks(timing.rising_delay_chips);
        let falling = round_ticks(timing.falling_delay_chips);
        let lag = (rising - falling).abs();
        if lag + 2 * half > i64::from(CHIP_TICKS) {
            return None;
        }
        let first_cell = rising.min(falling) - half;
        let chips = repeated(reference);
        let cells = (0..chips.len()).map(|cell| {
            let after = chips[cell];
            let before = chips[(cell + chips.len() - 1) % chips.len()];
            let edge = if after == 1 { rising } else { falling };
            let near = (edge - half - first_cell) as u32;
            (near << 2) | (u32::from(before != after) << 1) | u32::from(after)
        });
        Some(SignTable {
            period_chips: chips.len() as u32,
            cells: LookUp::new(cells),
            near_edges,
            first_cell,
            is_random,
        })
    }

    /// Whether each step needs random numbers of its own, beside those that its group shares.
    pub fn has_coins(&self) -> bool {
        matches!(&self.near_edges, NearEdges::Drawn(drawn) if drawn.transition_ticks > 0)
    }
}

impl EdgeTable {
    /// The levels (0 or 1) that count at places of the cells.
    #[inline(always)]
    fn levels(&self, cells: &LookUp, places: &CodePlaces, uniforms: &Integers) -> LaneWords {
        let cells = cells.at(&places.chips);
        let mut entries = LaneWords::all(0);
        for lane in 0..LANES {
            let into_table =
                (places.fractions[lane] as i32).wrapping_sub((cells[lane] >> 2) as i32);
            entries[lane] = (into_table.max(0) as u32).wrapping_shr(self.entry_bits).min(LAST);
        }
        let thresholds = self.thresholds.at(&entries);
        let mut levels = LaneWords::all(0);
        for lane in 0..LANES {
            let before_edge = u32::from(uniforms[lane] <= thresholds[lane] as i32);
            levels[lane] = (cells[lane] ^ ((cells[lane] >> 1) & before_edge)) & 1;
        }
        levels
    }
}

impl DrawnJitter {
    /// The levels that count `shifts` ticks after places of the cells, by a coin of 31 bits near edges.
    #[inline(always)]
    fn levels(
        &self,
        cells: &LookUp,
        places: &CodePlaces,
        shifts: &Integers,
        coins: &LaneWords,
    ) -> LaneWords {
        let registered = places.shifted(shifts);
        let cells = cells.at(&registered.chips);
        let mut levels = LaneWords::all(0);
        for lane in 0..LANES {
            let near = registered.fractions[lane].wrapping_sub(cells[lane] >> 2) as i32;
            let coin = coins[lane] >> 31;
            let if_late = if near >= (self.transition_ticks << 1) as i32 { 0 } else { coin };
            let before_edge = if near < 0 { 1 } else { if_late };
            levels[lane] = (cells[lane] ^ ((cells[lane] >> 1) & before_edge)) & 1;
        }
        levels
    }
}

/// The threshold that 31 random bits do not exceed with a probability.
pub fn threshold_of(probability: f64) -> i32 {
    ((probability.clamp(0.0, 1.0) * 2_f64.powi(31)).round() - 1.0) as i32
}

/// The counter's sign in all lanes.
#[derive(Debug, Clone)]
pub struct Sign<'t> {
    pub table: &'t SignTable,
    pub streams: LaneStreams,
    /// What decides within the transition of an edge, if it is not decided with the jitter.
    pub coins: Option<LaneStreams>,
    /// Where the last avalanche is in the reference's cells, or where a wait was cut.
    pub places: CodePlaces,
    /// Whether a detection's own jitter is asked for, too: then the number that decides is the quantile of
    /// the normal number of the same word.
    has_jitter: bool,
    /// The words of which that is made.
    pub randoms: LaneWords,
    /// The number that decided, 31 bits, or the ticks of jitter, by lane.
    chances: Integers,
    /// The level that counts, by lane.
    pub levels: LaneWords,
}

impl<'t> Sign<'t> {
    pub fn new(table: &'t SignTable, has_jitter: bool) -> Sign<'t> {
        Sign {
            table,
            streams: LaneStreams::new(),
            coins: table.has_coins().then(LaneStreams::new),
            places: CodePlaces::new(table.period_chips),
            has_jitter,
            randoms: LaneWords::all(0),
            chances: Integers::all(0),
            levels: LaneWords::all(0),
        }
    }

    /// Goes on, and finds the levels there.
    #[inline(always)]
    pub fn decide(&mut self, elapsed: &LaneWords) {
        if self.table.is_random {
            self.randoms = self.streams.next();
        }
        self.places.advance(elapsed);
        let cells = &self.table.cells;
        match &self.table.near_edges {
            NearEdges::Table(table) => {
                if self.table.is_random {
                    for lane in 0..LANES {
                        let random = self.randoms[lane];
                        let uniform = if self.has_jitter { quantile(random) } else { random >> 1 };
                        self.chances[lane] = uniform as i32;
                    }
                }
                self.levels = table.levels(cells, &self.places, &self.chances);
            }
            NearEdges::Drawn(drawn) => {
                for lane in 0..LANES {
                    self.chances[lane] = jitter(self.randoms[lane], drawn.sigma_ticks);
                }
                let coins = self.coins.as_mut().map_or(LaneWords::all(0), LaneStreams::next);
                self.levels = drawn.levels(cells, &self.places, &self.chances, &coins);
            }
        }
    }

    /// Whether jitter takes a lane's detection, `behind` ticks behind a border, back over it.
    pub fn is_before(&self, lane: usize, behind: i64, sigma_ticks: f64) -> bool {
        match &self.table.near_edges {
            NearEdges::Table(_) if sigma_ticks == 0.0 => behind < 0,
            NearEdges::Table(_) => {
                self.chances[lane] <= threshold_of(normal_cdf(-(behind as f64) / sigma_ticks))
            }
            NearEdges::Drawn(_) => behind + i64::from(self.chances[lane]) < 0,
        }
    }
}
