//! Light of one path: rates, and arrivals by a change of time.

use std::sync::Arc;

use rand_distr::{Distribution, Exp1};

use super::movement::{PathMovement, Trajectory};
use super::paths::NumberedPath;
use super::random::{StreamRng, scatter};
use super::shape::{LightGate, PulseShape, Strand};
use super::time::ChipTime;
use crate::code::Code;
use crate::light::photon_rate_hz;
use crate::scan::Clock;
use crate::scene::{Detector, Path, PathIndex, Source};

/// Primary detection rates that one path causes in a ready detector.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LightRates {
    /// While the source's chip is 1.
    pub on_hz: f64,
    /// While it is 0.
    pub off_hz: f64,
}

impl LightRates {
    /// Rates of a path: their mean over the code is photon rate x transmission
    /// x detection probability, their ratio the extinction ratio (eq. 5 with an
    /// off-rate; the transmission is the chance alpha of eq. 8, which thins a Poisson
    /// process to another one). A code without a single 1 is background.
    pub fn of(source: &Source, path: &Path, detector: &Detector, clock: Clock) -> LightRates {
        let mean_hz = photon_rate_hz(source.mean_power_w, source.wavelength_nm)
            * path.transmission
            * detector.photon_detection_probability;
        let (length, weight) = (source.code.len() as f64, source.lit_chips(clock));
        if weight == 0.0 {
            return LightRates { on_hz: mean_hz, off_hz: mean_hz };
        }
        let off_share = 1.0 / source.extinction_ratio;
        let on_hz = mean_hz * length / (weight + (length - weight) * off_share);
        LightRates { on_hz, off_hz: on_hz * off_share }
    }

    /// What the light adds while it is on.
    pub fn excess_hz(&self) -> f64 {
        self.on_hz - self.off_hz
    }
}

/// Where the on-chips of a code are.
#[derive(Debug, Clone)]
struct OnChips {
    /// Position of every on-chip in the code period.
    positions: Vec<u32>,
    /// For each chip of the period: twice the number of on-chips before it, plus
    /// one if it is itself on.
    before: Vec<u32>,
}

impl OnChips {
    fn of(code: &Code) -> OnChips {
        let mut positions = Vec::new();
        let mut before = Vec::with_capacity(code.chips.len());
        for (position, &chip) in code.chips.iter().enumerate() {
            before.push(2 * positions.len() as u32 + u32::from(chip));
            if chip == 1 {
                positions.push(position as u32);
            }
        }
        OnChips { positions, before }
    }
}

/// The excess on-light of one path at the detector: a Poisson process whose
/// rate is constant during on-chips and zero between.
#[derive(Debug, Clone)]
pub struct ExcessLight {
    on_chips: Arc<OnChips>,
    /// Mean wait, in chips of on-light.
    mean_wait_chips: f64,
    delay_chips: i64,
    delay_fraction: f64,
    /// Index of the path in the scene.
    pub path: PathIndex,
    /// What its random streams are told apart by.
    pub number: u64,
    /// Rate during on-chips, per chip.
    pub rate_per_chip: f64,
    /// The code that modulates it.
    pub code: Arc<Code>,
    /// How the delay changes from the scan's start on; `None` if it does not.
    pub movement: Option<PathMovement>,
    /// How the light follows the code.
    pub shape: Arc<PulseShape>,
}

impl ExcessLight {
    /// Its mean rate over the code, per chip.
    pub fn mean_per_chip(&self) -> f64 {
        self.rate_per_chip * self.shape.lit_chips(&self.code) / self.code.len() as f64
    }

    /// `None` if the path adds nothing to the background. With one of `others`
    /// that has the same code it shares what follows from the code.
    pub fn new(
        path: NumberedPath,
        rates: LightRates,
        code: &Arc<Code>,
        delay_ps: f64,
        clock: Clock,
        others: &[ExcessLight],
    ) -> Option<ExcessLight> {
        let rate_per_chip = clock.per_chip(rates.excess_hz());
        if rate_per_chip <= 0.0 || code.weight() == 0 {
            return None;
        }
        let delay = clock.chips(delay_ps);
        Some(ExcessLight {
            on_chips: others
                .iter()
                .find(|other| Arc::ptr_eq(&other.code, code))
                .map_or_else(|| Arc::new(OnChips::of(code)), |other| Arc::clone(&other.on_chips)),
            mean_wait_chips: 1.0 / rate_per_chip,
            delay_chips: delay.floor() as i64,
            delay_fraction: delay - delay.floor(),
            path: path.index,
            number: path.number,
            rate_per_chip,
            code: Arc::clone(code),
            movement: None,
            shape: Arc::new(PulseShape::ideal()),
        })
    }

    /// The same light over a path that moves.
    pub fn moving(self, movement: Option<PathMovement>) -> ExcessLight {
        ExcessLight { movement, ..self }
    }

    /// The same light as it follows its code with some edges.
    pub fn shaped(self, shape: Arc<PulseShape>) -> ExcessLight {
        ExcessLight { shape, ..self }
    }

    /// The light without edges that it is made of.
    pub fn strands(&self) -> impl Iterator<Item = LightStrand<'_>> {
        // A code without off-chips has no edges.
        let is_keyed = self.on_chips.positions.len() < self.on_chips.before.len();
        let strands: &[Strand] = match is_keyed {
            true => &self.shape.strands,
            false => &ALWAYS_ON,
        };
        strands.iter().zip(0..).map(|(strand, place)| {
            let delay = self.delay() + strand.delay_chips;
            LightStrand {
                light: self,
                mean_wait_chips: self.mean_wait_chips / strand.share,
                delay_chips: delay.floor() as i64,
                delay_fraction: delay - delay.floor(),
                gate: strand
                    .gate
                    .map(|gate| LightGate { delay_chips: self.delay() + gate.delay_chips, ..gate }),
                number: match place {
                    0 => self.number,
                    _ => scatter(self.number, place),
                },
            }
        })
    }

    /// Delay of the path in chips, at the start of a scan.
    pub fn delay(&self) -> f64 {
        self.delay_chips as f64 + self.delay_fraction
    }
}

/// What is left of a shape where the light never goes off.
const ALWAYS_ON: [Strand; 1] = [Strand { share: 1.0, delay_chips: 0.0, gate: None }];

/// A share of a path's light, which goes on and off at once.
#[derive(Debug, Clone)]
pub struct LightStrand<'m> {
    light: &'m ExcessLight,
    /// Mean wait, in chips of on-light.
    pub mean_wait_chips: f64,
    delay_chips: i64,
    delay_fraction: f64,
    /// When it is let through, its delay that of the path included.
    gate: Option<LightGate>,
    /// What its random streams are told apart by.
    pub number: u64,
}

impl LightStrand<'_> {
    /// Its delay in chips, that of the path included.
    pub fn delay(&self) -> f64 {
        self.delay_chips as f64 + self.delay_fraction
    }
}

/// Arrivals of one path's excess light, one after another.
#[derive(Debug, Clone)]
pub struct ExcessArrivals<'m> {
    strand: LightStrand<'m>,
    rng: StreamRng,
    trajectory: Option<Trajectory<'m>>,
    /// Emission time at which some code period begins, in chips.
    period_start: i64,
    /// Emission time at which the first of them began.
    first_period: i64,
    /// The next arrival at the detector.
    pub next: ChipTime,
}

impl<'m> ExcessArrivals<'m> {
    /// The process from `start` on; `code_position` is the code chip that is
    /// sent at time 0, and `trajectory` is for light that moves.
    pub fn new(
        strand: LightStrand<'m>,
        rng: StreamRng,
        trajectory: Option<Trajectory<'m>>,
        code_position: i64,
        start: ChipTime,
    ) -> ExcessArrivals<'m> {
        let mut arrivals = ExcessArrivals {
            strand,
            rng,
            trajectory,
            period_start: -code_position,
            first_period: -code_position,
            next: start,
        };
        arrivals.redraw(start);
        arrivals
    }

    /// Draws the first arrival after `from`.
    ///
    /// Time is counted in on-chips only: there the process is homogeneous, so
    /// the wait is one exponential, and nothing is drawn in vain. A path that moves
    /// changes when photons arrive, and not when they are emitted.
    #[inline]
    pub fn redraw(&mut self, from: ChipTime) {
        let still_from = match &mut self.trajectory {
            None => from,
            Some(trajectory) => from.shifted(-trajectory.displacement(from)),
        };
        let mut still = self.next_if_still(still_from);
        while !self.is_let_through(still) {
            still = self.next_if_still(still);
        }
        self.next = match &mut self.trajectory {
            None => still,
            Some(trajectory) => trajectory.arrival(still, from),
        };
    }

    /// Whether the gate is open for light that arrives then over a path that keeps its
    /// delay.
    #[inline]
    fn is_let_through(&self, arrival: ChipTime) -> bool {
        let Some(gate) = self.strand.gate else {
            return true;
        };
        let chips = &self.strand.light.code.chips;
        let emitted = arrival.shifted(-gate.delay_chips);
        let position = emitted.chip.saturating_sub(self.first_period);
        let is_far = arrival.chip >= i64::MAX / 2;
        is_far || chips[position.rem_euclid(chips.len() as i64) as usize] == gate.open_at
    }

    /// Draws the first arrival after `from` over a path that keeps the delay that
    /// it has at the scan's start.
    #[inline]
    fn next_if_still(&mut self, from: ChipTime) -> ChipTime {
        let (strand, light) = (&self.strand, self.strand.light);
        let length = light.on_chips.before.len() as i64;
        let weight = light.on_chips.positions.len() as i64;

        let mut emitted_chip = from.chip - strand.delay_chips;
        let mut emitted_fraction = from.fraction - strand.delay_fraction;
        if emitted_fraction < 0.0 {
            emitted_fraction += 1.0;
            emitted_chip -= 1;
        }
        let mut position = emitted_chip - self.period_start;
        if !(0..length).contains(&position) {
            let periods = position.div_euclid(length);
            self.period_start += periods * length;
            position -= periods * length;
        }

        let entry = light.on_chips.before[position as usize];
        let on_fraction = if entry & 1 == 1 { emitted_fraction } else { 0.0 };
        let exponential: f64 = Exp1.sample(&mut self.rng);
        let passed = ChipTime { chip: i64::from(entry >> 1), fraction: on_fraction }
            .after(exponential * strand.mean_wait_chips);

        let mut on_chip = passed.chip;
        let mut period_start = self.period_start;
        if on_chip >= weight {
            let periods = on_chip / weight;
            on_chip -= periods * weight;
            period_start = period_start.saturating_add(periods.saturating_mul(length));
        }
        let emitted = ChipTime {
            chip: period_start
                .saturating_add(i64::from(light.on_chips.positions[on_chip as usize])),
            fraction: passed.fraction,
        };
        let arrived = emitted.after(strand.delay_fraction);
        ChipTime { chip: arrived.chip.saturating_add(strand.delay_chips), ..arrived }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::photons::random::{RandomStream, StreamKey};
    use crate::scan::Group;

    /// A photon of 1 eV has 1239.841984 nm (CODATA), and the charge is exact.
    #[test]
    fn photon_energy_agrees_with_the_electron_volt_formula() {
        let joules = 1.0 / photon_rate_hz(1.0, 783.0);
        let electron_volts = joules / 1.602_176_634e-19;
        assert!((electron_volts - 1_239.841_984 / 783.0).abs() < 1e-8);
    }

    /// Arrivals seen in emission time fall on on-chips only, and evenly.
    #[test]
    fn arrivals_fall_on_on_chips_evenly() {
        use crate::code::Generator;
        let chips = vec![1, 1, 0, 1, 0, 0, 0];
        let code =
            Arc::new(Code { generator: Generator::Chips(chips.clone()), interleave: 0, chips });
        let rates = LightRates { on_hz: 0.6e12, off_hz: 0.1e12 };
        let delay_ps = 17.25;
        let path = NumberedPath { index: PathIndex(0), number: 0 };
        let clock = Clock { chip_period_ps: 1.0, samples_per_chip: 8 };
        let light =
            ExcessLight::new(path, rates, &code, delay_ps, clock, &[]).expect("there is light");
        let key = StreamKey { seed: 1, detector: 0, group: Group(0), repetition: 0 };
        let mut arrivals = ExcessArrivals::new(
            light.strands().next().expect("a strand"),
            key.stream(RandomStream::Path(0)),
            None,
            5,
            ChipTime::at_chip(-9),
        );
        let mut per_chip = [0_u32; 7];
        let draws = 60_000;
        for _ in 0..draws {
            let emitted = arrivals.next.shifted(-delay_ps);
            per_chip[(emitted.chip + 5).rem_euclid(7) as usize] += 1;
            arrivals.redraw(arrivals.next);
        }
        let span = arrivals.next.chip as f64 + 9.0;
        for (position, &count) in per_chip.iter().enumerate() {
            if code.chips[position] == 0 {
                assert_eq!(count, 0, "position {position}");
            } else {
                let expected = f64::from(draws) / 3.0;
                assert!((f64::from(count) - expected).abs() < 5.0 * (expected * 2.0 / 3.0).sqrt());
            }
        }
        // Half an arrival per on-chip, three on-chips in seven.
        let expected_span = f64::from(draws) / (0.5 * 3.0 / 7.0);
        assert!((span / expected_span - 1.0).abs() < 5.0 / f64::from(draws).sqrt());
    }
}
