//! Paths that move: how the light's own time goes on in each lane.
//!
//! Light is emitted at t - tau(t). Along a straight piece of tau, the code goes on by (1 - tau') of what the clock
//! does, and a wait in the code's time is 1 / (1 - tau') as long: linear, so that nothing else changes. Waits are cut
//! where a piece ends, which is exact, and there the place in the code is set anew: no error grows.

use super::arithmetic::{Floats, LANES, LaneWords, to_signed_ticks};
use super::places::{CHIP_BITS, CHIP_TICKS, IN_CHIP, LONGEST_CHIPS, ticks};
use crate::photons::DetectorModel;
use crate::photons::movement::{PathMovement, Trajectory};
use crate::photons::random::StreamKey;
use crate::photons::time::ChipTime;

/// A delay changes by no more than this share of the time.
pub const MOST_RATE: f64 = 1.0 / 256.0;
/// So many chips the code may go on more than the clock, or less, within a wait and a dead time: four times what
/// that makes, for clocks that drift for longer than [`PathMovement::steepest`] looks ahead.
pub const SLACK_CHIPS: u32 = LONGEST_CHIPS / 64 + 2;
/// A straight piece is a curve's chord, which is off by no more: a quarter of a tick.
const BEND_CHIPS: f64 = 0.25 / CHIP_TICKS as f64;
/// What the rate's 24 bits leave out, as a share of it.
const ROUNDING: f64 = f32::EPSILON as f64 / 2.0;

/// The time of one path's light.
#[derive(Debug, Clone)]
pub struct LaneMovement<'t> {
    movement: &'t PathMovement,
    trajectories: [Option<Trajectory<'t>>; LANES],
    /// Where the code would be at time 0 if the path did not move, in ticks.
    origins: [i64; LANES],
    /// Change of the delay per time.
    rates: Floats,
    /// What of it is less than a tick, and still to come.
    rests: Floats,
}

impl<'t> LaneMovement<'t> {
    pub fn new(movement: &'t PathMovement) -> LaneMovement<'t> {
        LaneMovement {
            movement,
            trajectories: std::array::from_fn(|_| None),
            origins: [0; LANES],
            rates: Floats::all(0.0),
            rests: Floats::all(0.0),
        }
    }

    /// Takes a lane to the scan and the group of a key: of the path with number `number`, where its code would be
    /// `origin` ticks after its start at time 0 if it did not move.
    pub fn start(
        &mut self,
        lane: usize,
        model: &DetectorModel,
        key: &StreamKey,
        number: u64,
        origin: i64,
    ) {
        self.trajectories[lane] = Some(model.trajectory(self.movement, key, number));
        self.origins[lane] = origin;
    }

    /// Begins a lane's next straight piece at a time, in ticks. Gives the place in the code there, in ticks, and how
    /// long the piece is, in chips; none of an idle lane.
    pub fn begin(&mut self, lane: usize, now: i64) -> Option<(i64, f64)> {
        let time = ChipTime {
            chip: now >> CHIP_BITS,
            fraction: f64::from(now as u32 & IN_CHIP) / f64::from(CHIP_TICKS),
        };
        let piece = self.trajectories[lane].as_mut()?.piece(time, BEND_CHIPS);
        let late = ticks(piece.displacement_chips);
        self.rates[lane] = piece.rate as f32;
        self.rests[lane] = (late - late.round()) as f32;
        let exact_chips = BEND_CHIPS / (ROUNDING * piece.rate.abs());
        let place = self.origins[lane] + now - late.round() as i64;
        Some((place, piece.length_chips.min(exact_chips)))
    }

    /// Waits in the clock's time, of waits in the code's.
    #[inline(always)]
    pub fn arrivals(&self, waits: &mut LaneWords) {
        for lane in 0..LANES {
            let rate = self.rates[lane];
            let later = to_signed_ticks(waits[lane] as i32 as f32 * (rate / (1.0 - rate)));
            waits[lane] = waits[lane].wrapping_add(later as u32);
        }
    }

    /// How far the code goes on.
    #[inline(always)]
    pub fn code_time(&mut self, elapsed: &LaneWords) -> LaneWords {
        let mut own = LaneWords::all(0);
        for lane in 0..LANES {
            let later = elapsed[lane] as i32 as f32 * self.rates[lane] + self.rests[lane];
            let whole = to_signed_ticks(later);
            self.rests[lane] = later - whole as f32;
            own[lane] = elapsed[lane].wrapping_sub(whole as u32);
        }
        own
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::photons::fast::Recorder;
    use crate::scan::Group;
    use crate::scene::{
        self, Detector, DetectorIndex, Fluctuation, LaserResponse, Movement, SourceClock,
    };
    use crate::sensor::Sensor;

    /// Light that is on or off, and a detector that adds nothing of its own.
    fn model(movement: Movement, clock: SourceClock) -> DetectorModel {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/quick.toml");
        let mut scene = scene::load(&file).expect("the scene is sound");
        scene.scan.integration_chips = 40_003;
        scene.scan.steps = 64;
        scene.sources[0].extinction_ratio = f64::INFINITY;
        scene.sources[0].response = LaserResponse::Ideal;
        scene.sources[0].clock = clock;
        scene.sources[0].mean_power_w *= 4.0;
        scene.paths[0].movement = Some(movement);
        let reference = scene.detectors[0].reference;
        scene.detectors[0] = Detector::ideal("spad", reference, 4000.0);
        DetectorModel::new(&Sensor::new(&scene), DetectorIndex(0))
    }

    /// Each photon was emitted in a chip that is on, by the time of the plain loop; anywhere in it, and as many as
    /// the code is sent in the time: speeds and clocks that come and go, fluctuations, all of them.
    #[test]
    fn photons_are_emitted_while_the_light_is_on() {
        let straight = |velocity_m_per_s| Movement { velocity_m_per_s, fluctuation: None };
        let fluctuation = Some(Fluctuation { std_m: 0.6, correlation_time_ps: 2e9 });
        let shaky = |velocity_m_per_s| Movement { velocity_m_per_s, fluctuation };
        let clock = |offset, drift_per_s| SourceClock { offset, drift_per_s };
        for (movement, clock) in [
            (straight(2.9e5), clock(0.0, 0.0)),
            (straight(-2.9e5), clock(0.0, 0.0)),
            (shaky(0.0), clock(0.0, 0.0)),
            (straight(0.0), clock(-9e-4, 0.0)),
            (straight(0.0), clock(1e-4, 4e-7)),
            (shaky(-3e4), clock(1e-4, -4e-9)),
        ] {
            let told = format!("{movement:?}, {clock:?}");
            let model = model(movement, clock);
            let light = &model.excess[0];
            let recorder = Recorder::new(&model);
            let groups: Vec<_> = (0..64).map(|group| (group / 32, Group(group % 32))).collect();
            let recorded = recorder.record(7, &groups);
            let (mut detections, mut expected) = (0_u64, 0.0);
            let mut in_chip = [0_u64; 8];
            for ((repetition, group), times) in groups.iter().zip(&recorded) {
                let key = model.key(7, *repetition, *group);
                let movement = light.movement.as_ref().expect("it moves");
                let mut trajectory = model.trajectory(movement, &key, light.number);
                let code = &light.code.chips;
                let position = model.code_position(*repetition, *group, light.code.len());
                let mut emitted = |time: ChipTime| {
                    let late = light.delay() + trajectory.displacement(time);
                    time.shifted(-late)
                };
                for time in times {
                    let time = time.detection();
                    let arrived = ChipTime { chip: time.chip as i64, fraction: time.fraction };
                    let emitted = emitted(arrived);
                    let chip = |by: f64| {
                        let chip = position + emitted.shifted(by).chip;
                        code[chip.rem_euclid(code.len() as i64) as usize]
                    };
                    // Some ticks of 2^-19 chip to either side.
                    let near = 1e-5;
                    assert!(chip(near) == 1 || chip(-near) == 1, "{told}: {arrived:?} {emitted:?}");
                    in_chip[(emitted.fraction * 8.0) as usize] += 1;
                }
                detections += times.len() as u64;
                let [from, to] = [0, 40_003].map(|chip| emitted(ChipTime::at_chip(chip)));
                let chips = (to.chip - from.chip) as f64 + to.fraction - from.fraction;
                expected += chips * light.mean_per_chip();
            }
            let z = (detections as f64 - expected) / expected.sqrt();
            assert!(z.abs() < 4.5, "{told}: {detections} of {expected}");
            let part = detections as f64 / 8.0;
            let chi_square: f64 = in_chip.iter().map(|&n| (n as f64 - part).powi(2) / part).sum();
            assert!(chi_square < 35.0, "{told}: {in_chip:?}");
        }
    }
}
