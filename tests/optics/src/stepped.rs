//! Expected counts of the article's detector, by stepping its probabilities
//! through time: none of the product's cells, cumulative sums or transforms.

use std::f64::consts::PI;

use goldtof_physics::response::MeanCount;
use goldtof_sensor::scan::Step;
use goldtof_sensor::scene::{Detector, JitterTail, LaserResponse, Recharge, Scene, Source};

/// States: this many afterpulses pending at most.
const STATES: usize = 5;

type State = [f64; STATES];

/// A detector's mean detections over one code period, in steps of equal length.
pub struct Stepped<'s> {
    scene: &'s Scene,
    step_ps: f64,
    /// Rates at both ends of every step, per step.
    rates: Vec<[f64; 2]>,
    /// Detections before each step, and in all.
    cumulative: Vec<f64>,
}

impl<'s> Stepped<'s> {
    /// Delays, dead time and chip period must be whole numbers of steps, and all
    /// codes equally long.
    pub fn new(scene: &'s Scene, step_ps: f64) -> Stepped<'s> {
        let spad = &scene.detectors[0];
        let whole = |ps: f64| {
            let steps = (ps / step_ps).round();
            assert!((steps * step_ps - ps).abs() < 1e-6, "{ps} ps");
            steps as usize
        };
        let per_chip = whole(scene.chip_period_ps);
        let dead = whole(spad.dead_time_ps);
        let period = per_chip * scene.sources[0].code.chips.len();
        let light = primary_rates(scene, period, per_chip, whole);
        if spad.recharge == Recharge::Passive {
            assert_eq!(spad.afterpulsing_probability, 0.0);
            return Stepped::of_rates(scene, step_ps, prolonged(&light, dead));
        }
        let chain = Chain::new(spad, step_ps);

        let warm_up = (100 * dead).div_ceil(period) * period;
        let mut ready: State = [0.0; STATES];
        ready[0] = 1.0;
        // What comes back one dead time later: rates at both ends of each step,
        // since the light may jump between steps.
        let mut line = vec![[[0.0; STATES]; 2]; dead];
        let mut rates = Vec::with_capacity(period);
        for step in 0..warm_up + period {
            let lambda = light[step % period];
            let back = line[step % dead];
            // The implicit trapezoidal rule, whose matrix is diagonal.
            let next: State = std::array::from_fn(|m| {
                let exit = 0.5 * (lambda + m as f64 * chain.release);
                let returned = 0.5 * (back[0][m] + back[1][m]);
                ((1.0 - exit) * ready[m] + returned) / (1.0 + exit)
            });
            let ends = [ready, next].map(|state| chain.avalanches(&state, lambda));
            if step >= warm_up {
                rates.push(ends.map(|avalanches| avalanches.iter().sum()));
            }
            line[step % dead] = ends.map(|avalanches| chain.after_dead_time(&avalanches));
            ready = next;
        }
        Stepped::of_rates(scene, step_ps, rates)
    }

    fn of_rates(scene: &'s Scene, step_ps: f64, rates: Vec<[f64; 2]>) -> Stepped<'s> {
        let mut cumulative = vec![0.0];
        for ends in &rates {
            cumulative.push(cumulative[cumulative.len() - 1] + 0.5 * (ends[0] + ends[1]));
        }
        Stepped { scene, step_ps, rates, cumulative }
    }

    /// Detections per code period.
    pub fn hits_per_period(&self) -> f64 {
        self.cumulative[self.rates.len()]
    }

    pub fn detection_rate_hz(&self) -> f64 {
        self.hits_per_period() / (self.rates.len() as f64 * self.step_ps * 1e-12)
    }

    /// Detections registered between each sample of a code period and the one before.
    pub fn hits_per_sample(&self) -> Vec<f64> {
        let sample_ps = self.scene.chip_period_ps / f64::from(self.scene.samples_per_chip);
        let samples = self.scene.scan.steps_per_period;
        self.hits_between(&(-1..samples as i64).map(|s| s as f64 * sample_ps).collect::<Vec<_>>())
    }

    /// Detections registered between each of some times and the one before.
    pub fn hits_between(&self, times_ps: &[f64]) -> Vec<f64> {
        let before: Vec<f64> = times_ps.iter().map(|&time| self.registered_before(time)).collect();
        before.windows(2).map(|pair| pair[1] - pair[0]).collect()
    }

    /// Expected counts of every step of the scan by the continuous-time counter;
    /// the integration time must be a whole number of code periods.
    pub fn counts(&self) -> Vec<MeanCount> {
        let code = &self.scene.sources[0].code.chips;
        let scan = &self.scene.scan;
        assert_eq!(scan.integration_chips % code.len() as u64, 0);
        let periods = (scan.integration_chips / code.len() as u64) as f64;
        let counter = &self.scene.detectors[0].counter;
        let samples = self.scene.samples_per_chip as usize;
        // Where the reference of each phase rises and falls, chip by chip.
        let edges: Vec<[Vec<f64>; 2]> = (0..samples)
            .map(|phase| {
                [counter.rising_delay_ps, counter.falling_delay_ps].map(|delay_ps| {
                    (0..code.len())
                        .map(|chip| {
                            let chips = chip as f64 + phase as f64 / samples as f64;
                            let edge_ps = chips * self.scene.chip_period_ps + delay_ps;
                            let sides = [-counter.transition_ps, counter.transition_ps];
                            sides.map(|side| self.registered_before(edge_ps + side))[..]
                                .iter()
                                .sum::<f64>()
                                / 2.0
                        })
                        .collect()
                })
            })
            .collect();
        let length = code.len();
        (0..scan.steps)
            .map(|step| {
                let phase_step = scan.phase_step(Step(step)) as usize;
                let [rising, falling] = &edges[phase_step % samples];
                let mut up = 0.0;
                for chip in 0..length {
                    let place = (chip + phase_step / samples) % length;
                    match (code[(chip + length - 1) % length], code[chip]) {
                        (0, 1) => up -= rising[place],
                        (1, 0) => up += falling[place],
                        _ => {}
                    }
                }
                let hits = self.hits_per_period();
                // Edges that stand in another period than their partner.
                up -= (up / hits).floor() * hits;
                MeanCount { signed: periods * (2.0 * up - hits), total: periods * hits }
            })
            .collect()
    }

    /// Detections registered before a time, seen through the detector's delay and
    /// jitter.
    fn registered_before(&self, time_ps: f64) -> f64 {
        let JitterTail::Exponential { share, time_constant_ps } =
            self.scene.detectors[0].jitter_tail
        else {
            return self.registered_without_tail_before(time_ps);
        };
        // Means of equally likely stretches of the exponential delay.
        const STRETCHES: i32 = 200;
        let late = (0..STRETCHES).map(|stretch| {
            let likelier = 1.0 - (f64::from(stretch) + 0.5) / f64::from(STRETCHES);
            self.registered_without_tail_before(time_ps + time_constant_ps * likelier.ln())
        });
        let late = late.sum::<f64>() / f64::from(STRETCHES);
        (1.0 - share) * self.registered_without_tail_before(time_ps) + share * late
    }

    fn registered_without_tail_before(&self, time_ps: f64) -> f64 {
        let spad = &self.scene.detectors[0];
        let sigma_ps = spad.jitter_ps.iter().map(|s| s * s).sum::<f64>().sqrt();
        let avalanche_ps = time_ps - spad.delay_ps;
        if sigma_ps == 0.0 {
            return self.before(avalanche_ps);
        }
        const NODES: i32 = 24;
        let spacing = 0.25;
        let (mut sum, mut weight) = (0.0, 0.0);
        for node in -NODES..=NODES {
            let x = f64::from(node) * spacing;
            let density = (-0.5 * x * x).exp() / (2.0 * PI).sqrt();
            sum += density * self.before(avalanche_ps + x * sigma_ps);
            weight += density;
        }
        sum / weight
    }

    fn before(&self, time_ps: f64) -> f64 {
        let steps = self.rates.len() as f64;
        let turns = (time_ps / (self.step_ps * steps)).floor();
        let place = time_ps / self.step_ps - turns * steps;
        let step = (place as usize).min(self.rates.len() - 1);
        let x = place - step as f64;
        let [start, end] = self.rates[step];
        self.cumulative[step]
            + x * (start + 0.5 * x * (end - start))
            + turns * self.hits_per_period()
    }
}

/// Rates at both ends of every step of a detector whose dead time each arrival begins anew: it
/// fires where none of the steps of one dead time before had an arrival.
fn prolonged(light: &[f64], dead: usize) -> Vec<[f64; 2]> {
    let period = light.len();
    let none_before = |step: usize| -> f64 {
        (1..=dead).map(|back| (-light[(step + dead * period - back) % period]).exp()).product()
    };
    let steps = light.iter().enumerate();
    steps.map(|(step, lambda)| [step, step + 1].map(|end| lambda * none_before(end))).collect()
}

/// Primary rate in every step of a code period, per step.
fn primary_rates(
    scene: &Scene,
    period: usize,
    per_chip: usize,
    whole: impl Fn(f64) -> usize,
) -> Vec<f64> {
    let spad = &scene.detectors[0];
    let step_s = scene.chip_period_ps * 1e-12 / per_chip as f64;
    let detected = spad.photon_detection_probability;
    let constant = spad.dark_count_rate_cps + detected * spad.background_rate_cps;
    let mut rates = vec![constant * step_s; period];
    for path in &scene.paths {
        let source = &scene.sources[path.source];
        let chips = &source.code.chips;
        assert_eq!(chips.len() * per_chip, period);
        let photons_per_s = source.mean_power_w * source.wavelength_nm * 1e-9
            / (6.626_070_15e-34 * 299_792_458.0)
            * path.transmission
            * detected
            * step_s;
        let levels: Vec<f64> =
            (0..period).map(|place| level(source, place, per_chip, step_s * 1e12)).collect();
        let ones = levels.iter().sum::<f64>() / period as f64;
        let off_share = 1.0 / source.extinction_ratio;
        let on = photons_per_s / (ones + (1.0 - ones) * off_share);
        let delay = whole(path.delay_ps);
        for (step, rate) in rates.iter_mut().enumerate() {
            let place = (step + period - delay % period) % period;
            *rate += on * (off_share + levels[place] * (1.0 - off_share));
        }
    }
    rates
}

/// The share of the light that is on in step `place` of a code period: edges are straight
/// lines, and the step's light is that of its middle.
fn level(source: &Source, place: usize, per_chip: usize, step_ps: f64) -> f64 {
    let chips = &source.code.chips;
    let length = chips.len();
    let ([fall_time_ps, rise_time_ps], longer_ps) = match source.response {
        LaserResponse::Ideal => ([0.0; 2], 0.0),
        LaserResponse::Edges { rise_time_ps, fall_time_ps } => ([fall_time_ps, rise_time_ps], 0.0),
        LaserResponse::Stretched { rise_time_ps, fall_time_ps, longer_ps } => {
            ([fall_time_ps, rise_time_ps], longer_ps)
        }
        LaserResponse::Measured(_) => panic!("a measured response is not stepped"),
    };
    let full_ps = |rises: bool| [fall_time_ps, rise_time_ps][usize::from(rises)] / 0.8;
    // Rising edges come earlier by half of what light lasts longer, falling ones later.
    let earlier_ps = |rises: bool| [-0.5, 0.5][usize::from(rises)] * longer_ps;
    let chip = place / per_chip;
    let into_ps = (place as f64 + 0.5) * step_ps - chip as f64 * per_chip as f64 * step_ps;
    let to_next_ps = per_chip as f64 * step_ps - into_ps;
    let [before, now, after] =
        [length - 1, 0, 1].map(|later| f64::from(chips[(chip + later) % length]));
    // How far an edge has come, 0 to 1, so long after its middle.
    let progress = |rises: bool, since_ps: f64| {
        let since_ps = since_ps + earlier_ps(rises);
        match full_ps(rises) {
            0.0 => f64::from(u8::from(since_ps >= 0.0)),
            full_ps => (0.5 + since_ps / full_ps).clamp(0.0, 1.0),
        }
    };
    let from_before = before + (now - before) * progress(now > before, into_ps);
    from_before + (after - now) * progress(after > now, -to_next_ps)
}

/// Afterpulses pending, j of them after an avalanche, m when its dead time ends.
struct Chain {
    /// Chance per step that one of them fires.
    release: f64,
    kernel: [State; STATES],
}

impl Chain {
    fn new(spad: &Detector, step_ps: f64) -> Chain {
        let mean = -(1.0 - spad.afterpulsing_probability).ln();
        let survival = (-spad.dead_time_ps / spad.afterpulsing_time_constant_ps).exp();
        let factorial = |n: usize| (1..=n).map(|n| n as f64).product::<f64>();
        let kernel = |j: usize, m: usize| -> f64 {
            (0..=j.min(m))
                .map(|kept| {
                    let new = m - kept;
                    let poisson = (-mean).exp() * mean.powi(new as i32) / factorial(new);
                    let ways = factorial(j) / factorial(kept) / factorial(j - kept);
                    let lost = (1.0 - survival).powi((j - kept) as i32);
                    poisson * ways * survival.powi(kept as i32) * lost
                })
                .sum()
        };
        let mut kernel: [State; STATES] =
            std::array::from_fn(|j| std::array::from_fn(|m| kernel(j, m)));
        for row in &mut kernel {
            // More than the last state holds.
            row[STATES - 1] += 1.0 - row.iter().sum::<f64>();
        }
        Chain { release: step_ps / spad.afterpulsing_time_constant_ps, kernel }
    }

    /// Rates of avalanches that leave j pending.
    fn avalanches(&self, ready: &State, lambda: f64) -> State {
        std::array::from_fn(|j| {
            let fired = ready.get(j + 1).map_or(0.0, |p| (j + 1) as f64 * p);
            lambda * ready[j] + self.release * fired
        })
    }

    fn after_dead_time(&self, avalanches: &State) -> State {
        std::array::from_fn(|m| (0..STATES).map(|j| self.kernel[j][m] * avalanches[j]).sum())
    }
}

/// The detector's probabilities, stepped through time: exit and return of each
/// state, by the trapezoidal rule, with a delay line for the dead time. Up to eight
/// afterpulses pending, `steps_per_chip` steps a chip, light that is on with
/// chips of `lit`.
fn hits(lit: &[f64], steps_per_chip: usize, dead_steps: usize, chips: usize) -> Vec<f64> {
    const M: usize = 9;
    let dt = 1.0 / steps_per_chip as f64;
    let release = 8.0 / 5.0;
    let mean = -(0.863_f64.ln());
    let survival = (-14.0_f64 / 5.0).exp();
    let choose = |n: usize, k: usize| (0..k).fold(1.0, |c, i| c * (n - i) as f64 / (i + 1) as f64);
    let kernel = |j: usize, m: usize| -> f64 {
        (0..=j.min(m))
            .map(|kept| {
                let new = m - kept;
                let factorial: f64 = (1..=new).map(|n| n as f64).product();
                let poisson = (-mean).exp() * mean.powi(new as i32) / factorial;
                let binomial = choose(j, kept)
                    * survival.powi(kept as i32)
                    * (1.0 - survival).powi((j - kept) as i32);
                poisson * binomial
            })
            .sum()
    };
    let kernel: Vec<Vec<f64>> = (0..M).map(|j| (0..M).map(|m| kernel(j, m)).collect()).collect();
    let avalanches = |p: &[f64; M], light: f64| -> [f64; M] {
        std::array::from_fn(|j| {
            light * p[j] + p.get(j + 1).map_or(0.0, |next| release * (j + 1) as f64 * next)
        })
    };
    let slope = |p: &[f64; M], light: f64, back: &[f64; M]| -> [f64; M] {
        std::array::from_fn(|m| {
            let returned: f64 = (0..M).map(|j| kernel[j][m] * back[j]).sum();
            returned - (light + m as f64 * release) * p[m]
        })
    };
    let mut p = [0.0; M];
    p[0] = 1.0;
    // Avalanche rates at both ends of each step of one dead time, since the light
    // may jump between steps.
    let mut line = vec![[[0.0; M]; 2]; dead_steps];
    let mut hits = vec![0.0; lit.len() * 8];
    let warm_up = chips - lit.len();
    for step in 0..chips * steps_per_chip {
        let light = lit[(step / steps_per_chip + 31 * 8 - warm_up) % lit.len()];
        let [back_start, back_end] = line[step % dead_steps];
        // The implicit trapezoidal rule, which loses no probability, by iteration.
        let first = slope(&p, light, &back_start);
        let mut next = p;
        for _ in 0..7 {
            let second = slope(&next, light, &back_end);
            next = std::array::from_fn(|m| p[m] + 0.5 * dt * (first[m] + second[m]));
        }
        let ends = [avalanches(&p, light), avalanches(&next, light)];
        line[step % dead_steps] = ends;
        if let Some(counted) = step.checked_sub(warm_up * steps_per_chip) {
            let rate: f64 = ends.iter().flatten().sum();
            hits[counted * 8 / steps_per_chip] += 0.5 * dt * rate;
        }
        p = next;
    }
    hits
}

/// The same without the error of the steps: the rule's error goes with the square
/// of the step, and two step sizes take it out (Richardson). At 90 Mcps and steps
/// of 40 ps it is 10^-5 of the largest value.
pub fn hits_without_steps(lit: &[f64], chips: usize) -> Vec<f64> {
    // The dead time of 14 ns is 1.75 chips.
    let [coarse, fine] = [200, 400].map(|steps| hits(lit, steps, steps * 7 / 4, chips));
    let pairs = coarse.iter().zip(&fine);
    pairs.map(|(c, f)| (4.0 * f - c) / 3.0).collect()
}
