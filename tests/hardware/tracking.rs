//! A target that the hardware follows: the Verilog beside the reference model, with a target that moves before it.

use std::collections::VecDeque;

use goldtof::cosim::build::build;
use goldtof::cosim::lockstep::Lockstep;
use goldtof::cosim::source::{Verilog, sources_of};
use goldtof::cosim::verilated::Verilated;
use goldtof::cosim::window::Window;
use goldtof::cosim::{CosimOptions, StimulusKind, TOP, Verdict, cosimulate};
use goldtof::deliver;
use goldtof::photons::Pulse;
use goldtof::reference::host_ports::HostInputs;
use goldtof::reference::predictor::{ReferenceModel, Surroundings};
use goldtof::reference::stimulus::{Drive, RESET_CLOCKS, Stimulus};
use goldtof::scan::Sample;
use goldtof::sensor::Sensor;
use goldtof::sensor::layout::Layout;
use goldtof::sensor::port::PortRole;
use goldtof::sensor::track::TrackSetting;

use crate::hdl_support::models;
use crate::hdl_support::stimulus::Noise;

/// A target before the sensor: what its lasers show comes back as photons, later and later.
struct Before<'s> {
    sensor: &'s Sensor,
    reference: ReferenceModel,
    layout: Layout,
    noise: Noise,
    /// Delay at the first clock in samples, and how much of one it grows by in a clock.
    delay: f64,
    rate: f64,
    /// Clocks from which on there is no light.
    dark_from: u64,
    /// First samples of photons on their way, in order.
    coming: VecDeque<u64>,
    last: u64,
    /// After each change of it: clock, position in samples, whether the target is there.
    seen: Vec<(u64, Option<f64>, bool)>,
}

impl<'s> Before<'s> {
    fn new(sensor: &'s Sensor, delay: f64, rate: f64, dark_from: u64) -> Before<'s> {
        let interface = sensor.interface();
        Before {
            sensor,
            reference: ReferenceModel::new(interface.clone()).expect("it can be predicted"),
            layout: Layout::of(interface),
            noise: Noise::new(11),
            delay,
            rate,
            dark_from,
            coming: VecDeque::new(),
            last: 0,
            seen: Vec::new(),
        }
    }

    fn delay_at(&self, clock: u64) -> f64 {
        self.delay + self.rate * clock as f64
    }

    fn share(&mut self) -> f64 {
        self.noise.below(1 << 20) as f64 / f64::from(1 << 20)
    }

    /// What a host drives: it turns tracking on.
    fn host(&self, clock: u64) -> Option<HostInputs> {
        let at = RESET_CLOCKS + 8;
        let plan = self.sensor.interface().registers.as_ref()?;
        let (own, track) = (plan.track_setting()?, plan.track.as_ref()?);
        let setting = TrackSetting { is_on: true, ..track.setting };
        // It is taken in the second clock, and answered in the third.
        (at..at + 3).contains(&clock).then(|| HostInputs {
            write_address_valid: clock < at + 2,
            write_address: 4 * (6 + own) as u16,
            write_valid: clock < at + 2,
            write_data: setting.word(),
            write_strobe: 0xf,
            write_response_ready: true,
            ..HostInputs::default()
        })
    }

    fn clock(&mut self, clock: u64, drive: &mut Drive) {
        let lanes = u64::from(self.sensor.interface().lanes());
        let samples = clock * lanes..(clock + 1) * lanes;
        let mut hits = vec![Vec::new()];
        while let Some(sample) = self.coming.pop_front_if(|sample| *sample < samples.end) {
            if sample >= samples.start.max(self.last + 2) {
                drive.pulses[0].push(Pulse::of_one(Sample(sample)));
                hits[0].push(Sample(sample));
                self.last = sample;
            }
        }
        let mut surroundings = Surroundings { clocks: clock..clock + 1, ..Surroundings::default() };
        surroundings.resets.extend((clock < RESET_CLOCKS).then_some(0..RESET_CLOCKS));
        let inputs = self.host(clock);
        surroundings.host.extend(inputs.map(|inputs| (clock..clock + 1, inputs)));
        drive.surroundings.host.extend(inputs.map(|inputs| (clock..clock + 1, inputs)));
        let mut record = vec![0; self.layout.outputs.words];
        self.reference.predict(&surroundings, &hits, &mut record);
        let position = self.reference.target().map(|(steps, _)| steps);
        let locked = self.reference.target().is_some_and(|(_, locked)| locked);
        if self.seen.last().is_none_or(|(_, seen, was)| (*seen, *was) != (position, locked)) {
            self.seen.push((clock, position, locked));
        }
        let is_lit = self.layout.outputs.field(PortRole::Laser).low_word(&record) == 1;
        // A photon for each fourth chip; its word comes a clock after the chip.
        if is_lit && clock < self.dark_from && self.noise.below(4) == 0 {
            let place = (clock + 1) as f64 * lanes as f64 + lanes as f64 * self.share();
            let sample = (place + self.delay_at(clock)).floor() as u64;
            let at = self.coming.partition_point(|other| *other <= sample);
            self.coming.insert(at, sample);
        }
        // Dark counts.
        if self.noise.below(50) == 0 {
            let sample = (clock + 2) * lanes + self.noise.below(lanes);
            let at = self.coming.partition_point(|other| *other <= sample);
            self.coming.insert(at, sample);
        }
    }
}

impl Stimulus for Before<'_> {
    fn drive(&mut self, drive: &mut Drive) {
        let clocks = drive.surroundings.clocks.clone();
        drive.surroundings.resets.extend((clocks.start < RESET_CLOCKS).then_some(0..RESET_CLOCKS));
        for clock in clocks {
            self.clock(clock, drive);
        }
    }
}

/// Runs the Verilog for some clocks before such a target.
fn run(sensor: &Sensor, target: &mut Before, clocks: u64) {
    let interface = sensor.interface();
    let layout = Layout::of(interface);
    let emission = deliver::emit(sensor, "a test").expect("the scene is fine");
    let library = build(TOP, &sources_of(&emission.files), interface, &models())
        .unwrap_or_else(|error| panic!("{error}"));
    let mut model = Verilated::load(&library, &layout).unwrap_or_else(|error| panic!("{error}"));
    let outcome = Lockstep {
        model: &mut model,
        reference: &mut ReferenceModel::new(interface.clone()).expect("it can be predicted"),
        stimulus: target,
        layout: &layout,
        window: Window::Found,
    }
    .run(clocks, |_| (), |_| ())
    .unwrap_or_else(|error| panic!("{error}"));
    assert!(outcome.first.is_none(), "{:?}", outcome.first);
    assert_eq!(outcome.clocks, clocks);
}

/// Steps of 310 chips, ten code periods; windows of eight steps.
fn sensor(gain: &str) -> Sensor {
    let set = |text: String| text.parse().expect("a setting");
    let settings = [
        set(format!("hardware.track_gain=\"{gain}\"")),
        set("scan.integration=\"2.48 us\"".to_owned()),
        set("scan.steps={ first = 20, count = 40 }".to_owned()),
    ];
    Sensor::load_with("tests/scenes/tracking-short.toml", &settings)
        .unwrap_or_else(|errors| panic!("{errors}"))
}

/// The loop closed through the Verilog: a target that moves is found and followed, each window begins when theory says, and
/// lags as a loop of the first order does.
#[test]
fn a_target_that_moves_is_followed_by_the_verilog() {
    for (gain, share, steps_per_window) in [("1", 1.0, 0.4), ("1/4", 0.25, -0.05)] {
        let sensor = sensor(gain);
        let track = *sensor.interface().track().expect("the scene follows a target");
        let pitch = sensor.interface().window_pitch_chips(&track);
        let mut target = Before::new(&sensor, 40.3, steps_per_window / pitch as f64, u64::MAX);
        let windows = 160;
        run(&sensor, &mut target, 20_000 + windows * pitch);
        let locked: Vec<(u64, f64)> = target
            .seen
            .iter()
            .filter_map(|(clock, position, locked)| {
                Some((*clock, (*position).filter(|_| *locked)?))
            })
            .collect();
        let gaps = locked.windows(2).map(|pair| pair[1].0 - pair[0].0);
        assert!(locked.len() > 120, "{gain}: {} of {windows}", locked.len());
        // A position that does not change is not seen to come.
        assert!(gaps.clone().all(|gap| gap % pitch == 0), "{gain}: {:?}", gaps.collect::<Vec<_>>());
        // The model knows with the window's last word; its middle is so long ago.
        let turn = track.window_steps() * 310 / 2;
        let errors: Vec<f64> = locked[30..]
            .iter()
            .map(|(clock, position)| position - target.delay_at(clock - turn))
            .collect();
        let mean = errors.iter().sum::<f64>() / errors.len() as f64;
        let lag = -steps_per_window * (1.0 - share) / share;
        assert!((mean - lag).abs() < 0.1, "{gain}: {mean}, expected {lag}");
        assert!(errors.iter().all(|error| (error - lag).abs() < 1.2), "{gain}: {errors:?}");
    }
}

/// Light that goes off is told within two windows, and a scan looks for it again.
#[test]
fn a_target_that_is_taken_away_is_told_by_the_verilog() {
    let sensor = sensor("1");
    let track = *sensor.interface().track().expect("the scene follows a target");
    let pitch = sensor.interface().window_pitch_chips(&track);
    let dark_from = 20_000 + 20 * pitch + 777;
    let mut target = Before::new(&sensor, 40.3, 0.0, dark_from);
    run(&sensor, &mut target, dark_from + 30 * pitch);
    let before = target.seen.iter().rfind(|(clock, _, _)| *clock <= dark_from);
    assert!(before.is_some_and(|(_, _, locked)| *locked), "{:?}", target.seen);
    let told = target.seen.iter().find(|(clock, _, locked)| *clock > dark_from && !locked);
    let told = told.expect("it is told").0;
    assert!(told - dark_from <= 2 * pitch, "{told} {dark_from} {pitch}");
    let given_up = target.seen.iter().find(|(clock, place, _)| *clock > told && place.is_none());
    assert!(given_up.is_some(), "{:?}", target.seen);
}

/// Of a code without settings of its own the next scan is under way when the peak of the one before shows: that is no
/// target, even if the host has turned tracking on in between.
#[test]
fn a_peak_of_the_scan_before_is_no_target() {
    let code = "source.code={ family = \"m-sequence\", degree = 5 }".parse().expect("a setting");
    let sensor = Sensor::load_with("tests/scenes/tracking-short.toml", &[code])
        .unwrap_or_else(|errors| panic!("{errors}"));
    let files = deliver::emit(&sensor, "a test").expect("the scene is fine").files;
    let verilog = Verilog { cache: models(), ..Verilog::emitted(&sensor, &files).expect("it is") };
    let options = CosimOptions { stimulus: StimulusKind::Adversarial, ..Default::default() };
    let report = cosimulate(&sensor, &verilog, &options, |_, _| ()).expect("it runs").report;
    assert_eq!(report.verdict, Verdict::Match, "{report:#?}");
}
