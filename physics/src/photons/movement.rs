//! Paths whose delay changes in time (eq. 7).
//!
//! A photon that arrives at t was emitted at t - tau(t), with tau(t) the delay at
//! the time of arrival. Emission times are as they were, so the Doppler shift of
//! the code needs no formula of its own, and no photon is lost or made. The delay
//! is a function of seed, scan, path and time since the scan's start: it depends
//! on neither detector nor phase step, nor on what was asked before.
//!
//! A fluctuation has values every 256th of its correlation time (whole chips, at
//! least one), with straight lines between. At the multiples of 2^14 such cells
//! values are independent (their true correlation is below 10^-13); between them
//! each value is drawn given its two neighbours of the coarser level, which for a
//! Markov process is exact. A value's random number has the number of its place,
//! so any time is reached in 14 draws, and the next cell in two or three.

use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

use super::random::{StreamKey, StreamRng, scatter};
use super::time::ChipTime;
use crate::scan::{Chip, Clock};
use crate::scene;

/// Cells in a correlation time.
const CELLS_PER_CORRELATION: f64 = 256.0;
/// A block of 2^LEVELS cells lies between independent values.
const LEVELS: usize = 14;
/// Over so many chips [`PathMovement::steepest`] takes a clock's drift into account: two hours of 8 ns.
const MOST_CHIPS: f64 = (1_u64 << 40) as f64;
/// Each turn makes the error of an arrival at least 200 times smaller.
const MOST_TURNS: usize = 12;

/// The displacement of one path against its delay at the scan's start, in chips.
#[derive(Debug, Clone)]
pub struct PathMovement {
    /// Change of the delay per time.
    delay_rate: f64,
    fluctuation: Option<Fluctuation>,
    /// How the source's clock runs away, which goes on from scan to scan.
    pub slip: Option<Slip>,
}

/// Code that comes earlier and earlier, because its clock is faster: after t chips of
/// the detectors' by offset t + drift t^2 / 2.
#[derive(Debug, Clone, Copy)]
pub struct Slip {
    offset: f64,
    drift_per_chip: f64,
}

impl Slip {
    fn new(source: &scene::SourceClock, clock: Clock) -> Option<Slip> {
        (!source.is_shared()).then_some(Slip {
            offset: source.offset,
            drift_per_chip: clock.per_chip(source.drift_per_s),
        })
    }

    /// How much later the code is at a time after the first scan's start.
    fn delay(&self, chips: f64) -> f64 {
        -chips * (self.offset + 0.5 * self.drift_per_chip * chips)
    }

    /// How quickly that grows.
    fn rate(&self, chips: f64) -> f64 {
        -(self.offset + self.drift_per_chip * chips)
    }

    /// How much of a chip it comes earlier per chip, on average over the first so many.
    pub fn mean_rate(&self, duration_chips: f64) -> f64 {
        self.offset + 0.5 * self.drift_per_chip * duration_chips
    }

    /// How far the code moves within a time, at most, as the first scan begins.
    pub fn range_chips(&self, duration_chips: f64) -> f64 {
        (self.offset.abs() + 0.5 * self.drift_per_chip.abs() * duration_chips) * duration_chips
    }
}

/// An Ornstein-Uhlenbeck process on a grid.
#[derive(Debug, Clone)]
struct Fluctuation {
    std_chips: f64,
    cell_chips: i64,
    levels: [Bridge; LEVELS],
}

/// The value midway between two others: weight x their sum + deviation x normal.
#[derive(Debug, Clone, Copy)]
struct Bridge {
    weight: f64,
    deviation: f64,
}

impl PathMovement {
    /// `None` for a path that stands still.
    pub fn new(path: &scene::Path, source: &scene::Source, clock: Clock) -> Option<PathMovement> {
        let slip = Slip::new(&source.clock, clock);
        let movement = path.movement.filter(|movement| !movement.is_neutral());
        if movement.is_none() && slip.is_none() {
            return None;
        }
        let fluctuation = movement.and_then(|movement| movement.fluctuation);
        let fluctuation = fluctuation.filter(|f| f.std_m > 0.0).map(|f| {
            Fluctuation::new(clock.chips(path.delay_std_ps()), clock.chips(f.correlation_time_ps))
        });
        Some(PathMovement { delay_rate: path.delay_rate(), fluctuation, slip })
    }

    /// No movement, followed all the same.
    pub fn none() -> PathMovement {
        PathMovement { delay_rate: 0.0, fluctuation: None, slip: None }
    }

    /// Whether it is [none](PathMovement::none).
    pub fn is_none(&self) -> bool {
        self.delay_rate == 0.0 && self.fluctuation.is_none() && self.slip.is_none()
    }

    /// How quickly the delay changes, at most: 14 standard deviations of the fluctuation, and a clock that
    /// drifts for hours.
    pub fn steepest(&self) -> f64 {
        let slip = self
            .slip
            .map_or(0.0, |slip| slip.offset.abs() + slip.drift_per_chip.abs() * MOST_CHIPS);
        let fluctuation = self.fluctuation.as_ref().map_or(0.0, |f| {
            // Neighbours differ by the square root of 2 of what the one between two others is drawn with.
            20.0 * f.levels[LEVELS - 1].deviation / f.cell_chips as f64
        });
        self.delay_rate.abs() + slip + fluctuation
    }

    /// How long it goes straight on, if it fluctuates.
    pub fn piece_chips(&self) -> Option<f64> {
        self.fluctuation.as_ref().map(|f| f.cell_chips as f64)
    }

    /// How far the path's delay moves in `duration_chips`: its mean, and two standard
    /// deviations.
    pub fn range_chips(&self, duration_chips: f64) -> f64 {
        let std_chips = self.fluctuation.as_ref().map_or(0.0, |f| f.std_chips);
        (self.delay_rate * duration_chips).abs() + 2.0 * std_chips
    }
}

impl Fluctuation {
    fn new(std_chips: f64, correlation_chips: f64) -> Fluctuation {
        let cell_chips = (correlation_chips / CELLS_PER_CORRELATION).round().max(1.0);
        let levels = std::array::from_fn(|level| {
            // Both neighbours are this far away.
            let away = cell_chips * f64::from(1_u32 << (LEVELS - 1 - level)) / correlation_chips;
            let correlation = (-away).exp();
            let both = 1.0 + correlation * correlation;
            Bridge {
                weight: correlation / both,
                deviation: std_chips * (-(-2.0 * away).exp_m1() / both).sqrt(),
            }
        });
        Fluctuation { std_chips, cell_chips: cell_chips as i64, levels }
    }

    /// Values at the start and at the end of a cell, and of the longer ones round it. Of those round the cell
    /// `before`, if there was one, only what differs is drawn: two levels of a cell behind it, on average.
    fn enter(
        &self,
        stream: u64,
        cell: i64,
        before: Option<i64>,
        ends: &mut [[f64; 2]; LEVELS + 1],
    ) {
        let alike = before.map_or(0, |before| {
            let unlike = 64 - (cell ^ before).leading_zeros() as usize;
            (LEVELS + 1).saturating_sub(unlike)
        });
        let width = 1_i64 << LEVELS;
        if alike == 0 {
            let start = cell & -width;
            let independent = |place: i64| self.std_chips * normal(stream, place);
            ends[0] = [independent(start), independent(start.wrapping_add(width))];
        }
        for level in alike.saturating_sub(1)..LEVELS {
            let bridge = &self.levels[level];
            let middle = (cell & -(width >> level)) + (width >> (level + 1));
            let [start, end] = ends[level];
            let value = bridge.weight * (start + end) + bridge.deviation * normal(stream, middle);
            ends[level + 1] = if cell < middle { [start, value] } else { [value, end] };
        }
    }
}

/// The normal number of a place.
fn normal(stream: u64, place: i64) -> f64 {
    StandardNormal.sample(&mut StreamRng::seed_from_u64(scatter(stream, place as u64)))
}

/// A displacement that changes evenly.
#[derive(Debug, Clone, Copy)]
pub struct StraightPiece {
    /// At its beginning.
    pub displacement_chips: f64,
    /// Change per time.
    pub rate: f64,
    pub length_chips: f64,
}

/// The displacement of one path in one scan.
#[derive(Debug, Clone)]
pub struct Trajectory<'m> {
    movement: &'m PathMovement,
    stream: u64,
    /// Chips from the scan's start to time 0.
    origin: i64,
    /// Chips from the first scan's start to time 0.
    first_origin: f64,
    /// The cell that was asked for last, and the values at its ends, behind those of the longer ones round it.
    cell: Option<i64>,
    ends: [[f64; 2]; LEVELS + 1],
}

impl<'m> Trajectory<'m> {
    /// The displacement of the path with number `path` in the scan of `key`; time 0 is `origin`
    /// chips after the scan's start.
    pub fn new(
        movement: &'m PathMovement,
        key: &StreamKey,
        path: u64,
        origin: i64,
    ) -> Trajectory<'m> {
        Trajectory {
            movement,
            stream: key.hash_of_movement(path),
            origin,
            first_origin: origin as f64,
            cell: None,
            ends: [[0.0; 2]; LEVELS + 1],
        }
    }

    /// The same, if its own origin is chip `first` of all.
    pub fn since_first_scan(self, first: Chip) -> Trajectory<'m> {
        Trajectory { first_origin: first.0 as f64, ..self }
    }

    /// The values at both ends of a cell.
    #[inline]
    fn ends_of(&mut self, fluctuation: &Fluctuation, cell: i64) -> [f64; 2] {
        if self.cell != Some(cell) {
            fluctuation.enter(self.stream, cell, self.cell, &mut self.ends);
            self.cell = Some(cell);
        }
        self.ends[LEVELS]
    }

    /// Displacement of the light that arrives at `time`.
    #[inline]
    pub fn displacement(&mut self, time: ChipTime) -> f64 {
        let chip = self.origin.saturating_add(time.chip);
        let rate = self.movement.delay_rate;
        let mut drift = rate * chip as f64 + rate * time.fraction;
        if let Some(slip) = &self.movement.slip {
            drift += slip.delay(self.first_origin + time.chip as f64 + time.fraction);
        }
        let movement = self.movement;
        let Some(fluctuation) = &movement.fluctuation else {
            return drift;
        };
        let cell_chips = fluctuation.cell_chips;
        let ends = self.ends_of(fluctuation, chip.div_euclid(cell_chips));
        let inside = (chip.rem_euclid(cell_chips) as f64 + time.fraction) / cell_chips as f64;
        drift + ends[0] + inside * (ends[1] - ends[0])
    }

    /// The straight piece that begins at a time: to the fluctuation's next value, or until the drift of the clock
    /// bends it by so much.
    pub fn piece(&mut self, time: ChipTime, bend_chips: f64) -> StraightPiece {
        let displacement_chips = self.displacement(time);
        let mut rate = self.movement.delay_rate;
        let mut length_chips = f64::INFINITY;
        if let Some(fluctuation) = &self.movement.fluctuation {
            let cell_chips = fluctuation.cell_chips;
            let chip = self.origin.saturating_add(time.chip);
            length_chips = (cell_chips - chip.rem_euclid(cell_chips)) as f64 - time.fraction;
            let [start, end] = self.ends[LEVELS];
            rate += (end - start) / cell_chips as f64;
        }
        if let Some(slip) = &self.movement.slip {
            // Of a parabola's chord.
            let length = (8.0 * bend_chips / slip.drift_per_chip.abs()).sqrt();
            length_chips = length_chips.min(length);
            let now = self.first_origin + time.chip as f64 + time.fraction;
            let middle = if slip.drift_per_chip == 0.0 { now } else { now + 0.5 * length_chips };
            rate += slip.rate(middle);
        }
        StraightPiece { displacement_chips, rate, length_chips }
    }

    /// When light arrives that would arrive at `still` if the path had kept the
    /// delay that it has at the scan's start (eq. 7), but not before `from`.
    #[inline]
    pub fn arrival(&mut self, still: ChipTime, from: ChipTime) -> ChipTime {
        let mut arrival = still;
        for _ in 0..MOST_TURNS {
            let next = still.shifted(self.displacement(arrival));
            if next == arrival {
                break;
            }
            arrival = next;
        }
        // Rounding must not turn the order round.
        if arrival < from { from } else { arrival }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scan::Group;
    use crate::scene::PathIndex;

    const KEY: StreamKey = StreamKey { seed: 5, detector: 0, group: Group(0), repetition: 0 };

    fn fluctuating(std_chips: f64, correlation_chips: f64) -> PathMovement {
        PathMovement {
            delay_rate: 0.0,
            slip: None,
            fluctuation: Some(Fluctuation::new(std_chips, correlation_chips)),
        }
    }

    /// Variance sigma^2, and correlation exp(-t / tau), from independent scans.
    #[test]
    fn the_fluctuation_has_the_moments_of_an_ornstein_uhlenbeck_process() {
        let (std_chips, correlation_chips) = (0.3, 1_024.0);
        let movement = fluctuating(std_chips, correlation_chips);
        // On the grid, far from and across the independent values at 65,536.
        for start in [0, 65_000, 3 << 40] {
            for lag in [0, 4, 64, 512, 1_024, 3_000] {
                let scans = 20_000;
                let mut sums = [0.0; 3];
                for repetition in 0..scans {
                    let key = StreamKey { repetition, ..KEY };
                    let mut trajectory = Trajectory::new(&movement, &key, 0, start);
                    let a = trajectory.displacement(ChipTime::at_chip(0)) / std_chips;
                    let b = trajectory.displacement(ChipTime::at_chip(lag)) / std_chips;
                    for (sum, value) in sums.iter_mut().zip([a, b * b, a * b]) {
                        *sum += value / scans as f64;
                    }
                }
                let correlation = (-(lag as f64) / correlation_chips).exp();
                let error = 5.0 / (scans as f64).sqrt();
                assert!(sums[0].abs() < error, "{start} {lag}: mean {}", sums[0]);
                let variance_error = error * 2_f64.sqrt();
                assert!((sums[1] - 1.0).abs() < variance_error, "{start} {lag}: {sums:?}");
                let product_error = error * (1.0 + correlation * correlation).sqrt();
                assert!((sums[2] - correlation).abs() < product_error, "{start} {lag}: {sums:?}");
            }
        }
    }

    /// The increments of a diffusion: 2 sigma^2 t / tau for short times.
    #[test]
    fn increments_from_cell_to_cell_are_those_of_a_diffusion() {
        let movement = fluctuating(1.0, 25_600.0);
        let mut trajectory = Trajectory::new(&movement, &KEY, 0, 0);
        let cells = 40_000;
        let mut squares = 0.0;
        let mut last = trajectory.displacement(ChipTime::at_chip(0));
        for cell in 1..=cells {
            let next = trajectory.displacement(ChipTime::at_chip(100 * cell));
            squares += (next - last).powi(2);
            last = next;
        }
        let expected = 2.0 * (1.0 - (-100.0_f64 / 25_600.0).exp());
        let found = squares / cells as f64;
        let error = 5.0 * (2.0 / cells as f64).sqrt();
        assert!((found / expected - 1.0).abs() < error, "{found} {expected}");
    }

    #[test]
    fn a_displacement_depends_on_its_time_alone() {
        let movement = PathMovement { delay_rate: 1e-5, ..fluctuating(0.2, 700.0) };
        let time = |chip: i64| ChipTime { chip, fraction: 0.375 };
        let mut forwards = Trajectory::new(&movement, &KEY, 3, 1_000_000);
        let walked: Vec<f64> =
            (-3_000..3_000).map(|chip| forwards.displacement(time(chip))).collect();
        // Another detector's step that starts 777 chips later, asked backwards.
        let key = StreamKey { detector: 4, group: Group(9), ..KEY };
        let mut backwards = Trajectory::new(&movement, &key, 3, 1_000_777);
        for chip in (-3_000..3_000).rev() {
            let found = backwards.displacement(time(chip - 777));
            assert_eq!(found, walked[(chip + 3_000) as usize]);
        }
        for chip in (-3_000..3_000).step_by(7) {
            let mut at_once = Trajectory::new(&movement, &KEY, 3, 1_000_000);
            assert_eq!(at_once.displacement(time(chip)), walked[(chip + 3_000) as usize]);
        }
        let others = [
            Trajectory::new(&movement, &KEY, 2, 1_000_000),
            Trajectory::new(&movement, &StreamKey { seed: 6, ..KEY }, 3, 1_000_000),
            Trajectory::new(&movement, &StreamKey { repetition: 1, ..KEY }, 3, 1_000_000),
        ];
        for mut other in others {
            assert_ne!(other.displacement(time(0)), walked[3_000]);
        }
    }

    /// t - x(t) = still, for the fastest movements that scenes allow.
    #[test]
    fn arrivals_solve_their_equation_to_the_last_femtosecond() {
        let movement = PathMovement { delay_rate: 2e-3, ..fluctuating(16.0 * 2e-5, 16.0) };
        let mut trajectory = Trajectory::new(&movement, &KEY, 0, 40_000_000_000);
        let from = ChipTime::at_chip(i64::MIN / 2);
        for chip in 0..2_000 {
            let still = ChipTime { chip: 37 * chip, fraction: 0.125 };
            let arrival = trajectory.arrival(still, from);
            let back = arrival.shifted(-trajectory.displacement(arrival));
            let error = (back.chip - still.chip) as f64 + back.fraction - still.fraction;
            assert!(error.abs() < 1e-7, "{chip}: {error}");
        }
    }

    /// The way of light that moves, at no speed, against the way of light that
    /// stands still: bit for bit.
    #[test]
    fn a_movement_at_no_speed_changes_no_arrival() {
        use std::sync::Arc;

        use crate::code::{Code, Generator};
        use crate::photons::light::{ExcessArrivals, ExcessLight, LightRates};
        use crate::photons::paths::NumberedPath;
        use crate::photons::random::RandomStream;

        let chips = vec![1, 1, 0, 1, 0, 0, 0];
        let code =
            Arc::new(Code { generator: Generator::Chips(chips.clone()), interleave: 0, chips });
        let rates = LightRates { on_hz: 60e6, off_hz: 6e6 };
        let path = NumberedPath { index: PathIndex(0), number: 0 };
        let clock = Clock { chip_period_ps: 8_000.0, samples_per_chip: 8 };
        let still =
            ExcessLight::new(path, rates, &code, 21_350.0, clock, &[]).expect("there is light");
        let at_no_speed = PathMovement { delay_rate: 0.0, slip: None, fluctuation: None };
        let start = ChipTime::at_chip(-40);
        let arrivals = |trajectory| {
            let strand = still.strands().next().expect("a strand");
            ExcessArrivals::new(strand, KEY.stream(RandomStream::Path(0)), trajectory, 5, start)
        };
        let mut plain = arrivals(None);
        let mut full = arrivals(Some(Trajectory::new(&at_no_speed, &KEY, 0, 1 << 40)));
        for _ in 0..10_000 {
            assert_eq!(plain.next, full.next);
            let ready = plain.next.after(1.75);
            plain.redraw(ready);
            full.redraw(ready);
        }
    }
}
