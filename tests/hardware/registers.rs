//! Registers: what a host reads and writes, and scans as it sets them.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::process::Command;

use goldtof::code::Generator;
use goldtof::cosim::TOP;
use goldtof::cosim::build::build;
use goldtof::cosim::lockstep::Lockstep;
use goldtof::cosim::source::sources_of;
use goldtof::cosim::verilated::Verilated;
use goldtof::cosim::window::Window;
use goldtof::deliver::{self, Emission};
use goldtof::photons::Pulse;
use goldtof::reference::adversarial::Adversarial;
use goldtof::reference::blocks::{Block, BlockMaker};
use goldtof::reference::host_ports::HostInputs;
use goldtof::reference::predictor::{ReferenceModel, StepResult};
use goldtof::reference::stimulus::{Drive, Stimulus};
use goldtof::scan::Sample;
use goldtof::scene::{Registers, Scene};
use goldtof::sensor::Sensor;
use goldtof::sensor::layout::Layout;
use goldtof::sensor::port::PortRole;
use goldtof::sensor::registers::{
    Access, CONTROL, MappedRegister, RegisterField, RegisterPlan, STATUS, Settings, setting_address,
};
use goldtof::sensor::track::TrackSetting;

use crate::hdl_support::stimulus::Noise;
use crate::hdl_support::{Family, code, models, recurrence, run, scene};

const SCENE: &str = "tests/scenes/registers.toml";
/// A Gold code and an m-sequence, whose taps a host sets.
const TAPS: &str = "tests/scenes/taps.toml";
/// A window that follows a target.
const TRACKING: &str = "tests/scenes/tracking-short.toml";

fn sensor(scene: &str) -> Sensor {
    Sensor::load(scene).unwrap_or_else(|errors| panic!("{errors}"))
}

fn plan(sensor: &Sensor) -> &RegisterPlan {
    sensor.interface().registers.as_ref().expect("the scene has registers")
}

fn emission(sensor: &Sensor) -> Emission {
    deliver::emit(sensor, "goldtof emit registers.toml").expect("the scene is fine")
}

/// All ports of a run of the adversary, and the results of its steps.
struct Seen {
    layout: Layout,
    inputs: Vec<u64>,
    outputs: Vec<u64>,
    results: Vec<StepResult>,
}

impl Seen {
    fn of(sensor: &Sensor, seed: u64, clocks: u64) -> Seen {
        let interface = sensor.interface();
        let layout = Layout::of(interface);
        let mut reference = ReferenceModel::new(interface.clone()).expect("it can be predicted");
        let mut adversary = Adversarial::new(interface, seed);
        let mut maker = BlockMaker::new(&mut reference, &mut adversary, &layout, clocks);
        let mut seen = Seen {
            inputs: Vec::new(),
            outputs: Vec::new(),
            results: Vec::new(),
            layout: layout.clone(),
        };
        let mut block = Block::default();
        while maker.make(&mut block) {
            seen.inputs.extend(&block.records.inputs);
            seen.outputs.extend(&block.records.expected);
            seen.results.extend(maker.take_finished());
        }
        seen
    }

    fn clocks(&self) -> u64 {
        (self.outputs.len() / self.layout.outputs.words) as u64
    }

    /// A port just before a clock's rising edge, if it is an input, or just after it.
    fn port(&self, role: PortRole, clock: u64) -> u64 {
        let (record, values) = match self.layout.inputs.fields.iter().any(|f| f.port.role == role) {
            true => (&self.layout.inputs, &self.inputs),
            false => (&self.layout.outputs, &self.outputs),
        };
        let at = clock as usize * record.words;
        record.field(role).low_word(&values[at..at + record.words])
    }
}

/// The clocks at which the lasers show their codes' first chips anew, each with the settings that were written
/// before; without those that were written when they may have been read already.
fn starts(sensor: &Sensor, seen: &Seen) -> Vec<(u64, Settings)> {
    let (interface, plan) = (sensor.interface(), plan(sensor));
    let mut words = plan.initial_words(&interface.timing, &interface.source_codes);
    // The settings, and since when they are what they are.
    let (mut since, mut last_epoch, mut starts) = (0, None, Vec::new());
    for clock in 1..seen.clocks() {
        let written = seen.port(PortRole::WriteAddressReady, clock - 1) == 1
            && seen.port(PortRole::WriteStrobe, clock) == 0xf
            && seen.port(PortRole::Reset, clock) == 0;
        let word = seen.port(PortRole::WriteAddress, clock) as usize / 4;
        if written && (6..words.len()).contains(&word) {
            words[word] = seen.port(PortRole::WriteData, clock) as u32;
            since = clock;
        }
        if seen.port(PortRole::Epoch, clock) == 1 {
            // Codes that run on have their first chips a period apart.
            let is_anew = last_epoch.is_none_or(|last: u64| last + plan.period_chips != clock);
            if is_anew && since + 16 <= clock {
                starts.push((clock, plan.settings_in(&words[6..])));
            }
            last_epoch = Some(clock);
        }
    }
    starts
}

/// A host's numbers mean what the manual says, seen from the ports alone: of the first scan of codes that
/// begin anew, whatever was written before, every count is the sum of the signs that the lasers' own chips,
/// as late as the step's delay, have at the detector's rising edges.
#[test]
fn counts_are_those_of_the_lasers_chips_delayed_as_a_host_has_set_them() {
    for scene in [SCENE, TAPS] {
        let sensor = sensor(scene);
        check_counts(&sensor, &Seen::of(&sensor, 5, 300_000));
    }
}

fn check_counts(sensor: &Sensor, seen: &Seen) {
    let (interface, plan) = (sensor.interface(), plan(sensor));
    let (lanes, period) = (u64::from(interface.lanes()), plan.period_chips);
    let parallel = u64::from(interface.parallel());
    let (mut checked, mut settings_seen) = (0, Vec::new());
    for (clock, settings) in starts(sensor, seen) {
        let first_word = clock + 2 * period + 1;
        let latency = u64::from(interface.result_latency_clocks);
        for group in 0..settings.groups {
            let words =
                first_word + group * settings.chips..first_word + (group + 1) * settings.chips;
            let results: Vec<&StepResult> = seen
                .results
                .iter()
                .filter(|result| result.clock == words.end - 1 + latency)
                .collect();
            let is_reset = (clock..(words.end + latency).min(seen.clocks()))
                .any(|c| seen.port(PortRole::Reset, c) == 1);
            if is_reset || words.end + latency >= seen.clocks() {
                break;
            }
            assert_eq!(results.len() as u64, 2 * parallel, "clock {clock}, group {group}");
            for result in results {
                let step = result.step % parallel + group * parallel;
                let delay = settings.first_step + step;
                let level = |sample: u64| {
                    let lane = sample % lanes + lanes * result.detector.0 as u64;
                    seen.port(PortRole::Samples, sample / lanes) >> lane & 1
                };
                let samples = words.start * lanes..words.end * lanes;
                let hits = samples.filter(|&s| level(s) == 1 && level(s - 1) == 0);
                let sign = |sample: u64| {
                    // The word of a chip comes a clock after it.
                    let chip = seen.port(PortRole::Laser, (sample - lanes - delay) / lanes);
                    2 * (chip >> result.detector.0 & 1) as i64 - 1
                };
                assert_eq!(
                    result.exact,
                    hits.map(sign).sum::<i64>(),
                    "clock {clock}, {settings:?}, {result:?}"
                );
                checked += 1;
            }
        }
        if !settings_seen.contains(&settings) {
            settings_seen.push(settings);
        }
    }
    assert!(checked > 200 && settings_seen.len() > 5, "{checked} counts, {settings_seen:?}");
}

/// What the manual says of taps, seen from the ports alone: the lasers' chips, without interleaving and the Gold code's first
/// LFSR, begin with CHIPS, and go on by the chips that TAPS chooses, to the end of the code period, where they begin anew.
#[test]
fn lasers_show_the_sequences_of_the_taps_that_a_host_has_set() {
    let sensor = sensor(TAPS);
    let (interface, plan) = (sensor.interface(), plan(&sensor));
    let seen = Seen::of(&sensor, 7, 300_000);
    let (degree, chips) = (5, 31);
    let Generator::Gold { u, .. } = &interface.source_codes[0].generator else {
        panic!("the first code is a Gold code")
    };
    let u = recurrence(&u.exponents, &u.seed, chips);
    let mut of_taps = BTreeSet::new();
    for (clock, settings) in starts(&sensor, &seen) {
        // Two periods, if they are not cut off by a reset.
        let ends = clock + 2 * plan.period_chips;
        if ends >= seen.clocks()
            || (clock..ends).any(|clock| seen.port(PortRole::Reset, clock) == 1)
        {
            continue;
        }
        for (source, &setting) in settings.seeds.iter().enumerate() {
            let laser = |chip: usize| {
                let place = clock + chip as u64;
                (seen.port(PortRole::Laser, place) >> source & 1) as u8 ^ (chip & 1) as u8
            };
            let sent: Vec<u8> = (0..2 * chips)
                .map(|chip| {
                    assert_eq!(laser(2 * chip), laser(2 * chip + 1), "an inverse behind each chip");
                    laser(2 * chip) ^ if source == 0 { u[chip % chips] } else { 0 }
                })
                .collect();
            let taps = setting >> degree;
            let next = |first: usize| {
                (0..degree).filter(|i| taps >> i & 1 == 1).map(|i| sent[first + i]).sum::<u8>() & 1
            };
            for (chip, &shown) in sent.iter().enumerate().take(chips) {
                let expected = match chip.checked_sub(degree) {
                    None => (setting >> chip & 1) as u8,
                    Some(first) => next(first),
                };
                assert_eq!(shown, expected, "clock {clock}, source {source}, {setting:#x}");
            }
            assert_eq!(sent[..chips], sent[chips..]);
            of_taps.insert((source, taps));
        }
    }
    for source in 0..2 {
        assert!(of_taps.iter().filter(|(of, _)| *of == source).count() >= 3, "{of_taps:?}");
    }
}

/// Resets, and after each a write that comes a clock later than after the one before.
struct AtEachClock {
    /// Clocks from one reset to the next.
    pitch: u64,
    /// What is written, in turns.
    writes: Vec<(u32, u32)>,
    noise: Noise,
    lanes: u64,
}

impl Stimulus for AtEachClock {
    fn drive(&mut self, drive: &mut Drive) {
        let clocks = drive.surroundings.clocks.clone();
        for turn in clocks.start / self.pitch..=clocks.end / self.pitch {
            let start = turn * self.pitch;
            if start < clocks.end && start + 2 > clocks.start {
                drive.surroundings.resets.push(start..start + 2);
            }
            let (address, data) = self.writes[turn as usize % self.writes.len()];
            let at = start + 3 + turn / self.writes.len() as u64;
            // It is taken in the second clock, and answered in the third.
            for clock in (at..at + 3).filter(|clock| clocks.contains(clock)) {
                let is_there = clock < at + 2;
                let inputs = HostInputs {
                    write_address_valid: is_there,
                    write_address: address as u16,
                    write_valid: is_there,
                    write_data: data,
                    write_strobe: 0xf,
                    write_response_ready: true,
                    ..HostInputs::default()
                };
                drive.surroundings.host.push((clock..clock + 1, inputs));
            }
        }
        for pulses in &mut drive.pulses {
            let samples = clocks.start * self.lanes..clocks.end * self.lanes;
            for sample in samples.step_by(2) {
                if self.noise.below(3) == 0 {
                    pulses.push(Pulse::of_one(Sample(sample)));
                }
            }
        }
    }
}

/// Runs a scene's Verilog beside the reference model, with resets every `pitch` clocks, and each write of a host at every
/// clock up to `moments` after them.
fn is_predicted_whenever_a_host_writes(
    scene: &Scene,
    pitch: u64,
    moments: u64,
    writes: Vec<(u32, u32)>,
) {
    let sensor = Sensor::new(scene);
    let interface = sensor.interface();
    let clocks = moments * writes.len() as u64 * pitch;
    let layout = Layout::of(interface);
    let library = build(TOP, &sources_of(&emission(&sensor).files), interface, &models())
        .unwrap_or_else(|error| panic!("{error}"));
    let mut model = Verilated::load(&library, &layout).unwrap_or_else(|error| panic!("{error}"));
    let lanes = interface.lanes().into();
    let outcome = Lockstep {
        model: &mut model,
        reference: &mut ReferenceModel::new(interface.clone()).expect("it can be predicted"),
        stimulus: &mut AtEachClock { pitch, writes, noise: Noise::new(9), lanes },
        layout: &layout,
        window: Window::Found,
    }
    .run(clocks, |_| (), |_| ())
    .unwrap_or_else(|error| panic!("{error}"));
    assert!(outcome.first.is_none(), "{:?}", outcome.first);
    assert_eq!(outcome.clocks, clocks);
    assert!(outcome.exercise.phase_steps > clocks / pitch, "{:?}", outcome.exercise);
}

/// Short scans: two groups of 16 chips behind codes of seven.
fn short_scans() -> Scene {
    let mut scene = scene(&[code(Family::Gold(3), 0, 1)], 0, 2, 5, Some(2), 16, None);
    scene.hardware.registers = Registers::Axi4Lite;
    scene
}

#[test]
fn a_write_at_any_moment_of_a_scan_does_what_the_reference_model_says() {
    let scene = short_scans();
    let sensor = Sensor::new(&scene);
    let plan = plan(&sensor);
    // Reset, start, preparation, scan, its results, and the next one's preparation.
    let scan = plan.start_clocks() + 2 * plan.period_chips + 2 * 16;
    let pitch = 2 * scan + 40;
    let writes = vec![
        (CONTROL, 0),
        (CONTROL, 2),
        (CONTROL, 3),
        (setting_address(0), 19),
        (setting_address(1), 1),
        (setting_address(1), plan.whole_groups.expect("there are whole scans") as u32),
        (setting_address(2), 11),
        (setting_address(3), 5),
        (setting_address(0), 3),
        (STATUS, u32::MAX),
    ];
    is_predicted_whenever_a_host_writes(&scene, pitch, scan + 30, writes);
}

/// The same of a scan that looks for a target, its peak's decision, a window, and that one's decision.
#[test]
fn a_write_at_any_moment_of_a_window_does_what_the_reference_model_says() {
    let mut scene = short_scans();
    scene.hardware.peak_detector = true;
    scene.hardware.track = true;
    let sensor = Sensor::new(&scene);
    let plan = plan(&sensor);
    let track = plan.track.expect("the hardware follows a target");
    let begins = plan.start_clocks() + 2 * plan.period_chips;
    let scan = begins + 2 * plan.least_chips + 40;
    let window = begins + track.window_steps() * plan.least_chips + 20;
    let window = window + u64::from(track.decision_clocks());
    let follows = |gain_halvings, threshold_halvings, patience| {
        let setting = TrackSetting { is_on: true, gain_halvings, threshold_halvings, patience };
        (setting_address(plan.track_setting().expect("it has one")), setting.word())
    };
    let off = (follows(0, 0, 0).0, 0);
    let writes = vec![
        (setting_address(0), plan.least_chips as u32),
        follows(0, 7, 15),
        (CONTROL, 0),
        (CONTROL, 2),
        (setting_address(2), 11),
        follows(7, 1, 1),
        (setting_address(0), 3),
        (setting_address(0), plan.least_chips as u32),
        off,
        follows(2, 7, 2),
        (STATUS, u32::MAX),
        (setting_address(1), 1),
        (setting_address(1), 2),
    ];
    let pitch = scan + 2 * window + 20;
    is_predicted_whenever_a_host_writes(&scene, pitch, scan + window + 60, writes);
}

/// Addresses, bits and values at power-up in a header that PeakRDL makes of the SystemRDL, and in ours.
#[test]
fn systemrdl_compiles_and_says_what_the_c_header_says() {
    for scene in [SCENE, TAPS, TRACKING] {
        check_header(&sensor(scene));
    }
}

fn check_header(sensor: &Sensor) {
    let registers = emission(sensor).flow.registers.expect("the design has registers");
    let folder = tempfile::tempdir().expect("a temporary folder");
    let write = |name: &str, text: &str| {
        fs::write(folder.path().join(name), text).expect("it can be written");
    };
    write(&registers.systemrdl.name, &registers.systemrdl.text);
    write("ours.h", &registers.c_header.text);
    let peakrdl = concat!(env!("CARGO_TARGET_TMPDIR"), "/../python/bin/peakrdl");
    run(folder.path(), peakrdl, &["c-header", &registers.systemrdl.name, "-o", "theirs.h"]);
    let mut program =
        "#include <stddef.h>\n#include \"ours.h\"\n#include \"theirs.h\"\nint main(void) {\n"
            .to_owned();
    let mut compared = 0;
    let mut same = |ours: &str, theirs: &str| {
        program += &format!(
            "    if ((unsigned long)({ours}) != (unsigned long)({theirs})) return __LINE__;\n"
        );
        compared += 1;
    };
    for register in &registers.map {
        let ours = format!("SENSOR_TOP_REGISTERS_{}", register.name);
        same(&ours, &format!("offsetof(sensor_top_registers_t, {})", register.name));
        for field in &register.fields {
            let ours = format!("{ours}_{}", field.name);
            let theirs = format!("SENSOR_TOP_REGISTERS__{}_T__{}", register.name, field.name);
            same(&format!("{ours}_MASK"), &format!("{theirs}_bm"));
            same(&format!("{ours}_SHIFT"), &format!("{theirs}_bp"));
            if field.reset.is_some() {
                same(&format!("{ours}_RESET"), &format!("{theirs}_reset"));
            }
        }
    }
    assert!(compared >= 60, "{compared}");
    write("compare.c", &(program + "    return 0;\n}\n"));
    run(folder.path(), "gcc", &["-Wall", "-Werror", "-o", "compare", "compare.c"]);
    let status = Command::new(folder.path().join("compare")).status().expect("it runs");
    assert_eq!(status.code(), Some(0), "line of compare.c");
}

/// The manual's tables are those of the hardware: all registers of one scene, and of another what follows a target.
#[test]
fn the_manual_has_every_register() {
    page_has_registers("docs/registers.md", SCENE, |_, _| true);
    let is_of_tracking = |register: &MappedRegister, field: &RegisterField| {
        register.name.starts_with("TRACK") || field.name.starts_with("LOCK")
    };
    page_has_registers("docs/tracking.md", TRACKING, is_of_tracking);
}

fn page_has_registers(
    page: &str,
    scene: &str,
    has: impl Fn(&MappedRegister, &RegisterField) -> bool,
) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(page);
    let manual = fs::read_to_string(&path).unwrap_or_else(|error| panic!("{error}"));
    let sensor = sensor(scene);
    let mut table = "| address | register | bits | field | access | at power-up | |\n|---|---|---|---|---|---|---|\n".to_owned();
    let interface = sensor.interface();
    for register in plan(&sensor).map(&interface.timing, &interface.source_codes) {
        for field in register.fields.iter().filter(|field| has(&register, field)) {
            let last = field.first_bit + field.width - 1;
            let bits = match field.width {
                1 => last.to_string(),
                _ => format!("{last}:{}", field.first_bit),
            };
            let access = match field.access {
                Access::Read => "read",
                Access::ReadWrite => "read, write",
                Access::WriteOneToClear => "read, 1 clears",
            };
            let is_own = ["IDENTITY_LOW", "IDENTITY_HIGH"].contains(&register.name.as_str());
            let reset = match field.reset {
                Some(value) if !is_own => format!("{value:#x}"),
                Some(_) => "of the design".to_owned(),
                None => String::new(),
            };
            table += &format!(
                "| 0x{:03x} | `{}` | {bits} | `{}` | {access} | {reset} | {} |\n",
                register.address, register.name, field.name, field.about
            );
        }
    }
    let (begin, end) = ("<!-- registers -->\n", "<!-- end -->");
    let from = manual.find(begin).expect("the table has a beginning") + begin.len();
    let to = manual.find(end).expect("the table has an end");
    if std::env::var_os("GOLDTOF_UPDATE").is_some() {
        let renewed = format!("{}{table}{}", &manual[..from], &manual[to..]);
        fs::write(&path, renewed).expect("the manual can be written");
        return;
    }
    assert_eq!(&manual[from..to], table, "GOLDTOF_UPDATE=1 renews it");
}
