//! Waveform files: what stands in them, which clocks, when, and what viewers are told.

use std::collections::HashMap;
use std::fs;
use std::io::BufReader;
use std::ops::Range;
use std::path::Path;

use goldtof::cosim::window::Window;
use goldtof::cosim::{Cosimulation, VcdClocks, Verdict};
use goldtof::deliver::{emit, write};
use goldtof::scene::Scene;
use goldtof::sensor::Sensor;
use goldtof::{CosimOptions, Jobs as _, OwnRtl};
use vcd::{Command, IdCode, ScopeItem, TimescaleUnit, Value};

use crate::hdl_support::{Family, code, run, scene};

/// Chips of integration, and samples per chip.
const CHIPS: u64 = 40;
const LANES: u64 = 8;
/// Clocks of reset that a co-simulation begins with.
const RESET: u64 = 4;

fn plain() -> Scene {
    let mut scene = scene(&[code(Family::Gold(5), 0, 3)], 0, 8, 0, None, CHIPS, None);
    // Enough light, and no way that it takes: hits of both signs in every step.
    scene.detectors[0].background_rate_cps = 30e6;
    scene
}

fn co_simulated(scene: &Scene, own: OwnRtl, window: Window) -> Cosimulation {
    let options = CosimOptions { own, window, ..Default::default() };
    Sensor::new(scene).cosim(&options).expect("it can be run")
}

fn emitted(window: Window) -> Cosimulation {
    co_simulated(&plain(), OwnRtl::default(), window)
}

/// A waveform file as it was read: what each signal is at each time at which any changes.
struct Waves {
    timescale: Option<(u32, TimescaleUnit)>,
    signals: HashMap<String, IdCode>,
    /// Time, and the signals' values from then on.
    rows: Vec<(u64, HashMap<IdCode, u64>)>,
    comments: String,
}

impl Waves {
    fn read(path: &Path) -> Waves {
        let file = fs::File::open(path).expect("it was written");
        let mut parser = vcd::Parser::new(BufReader::new(file));
        let header = parser.parse_header().expect("it has a header");
        let mut signals = HashMap::new();
        name_all("", &header.items, &mut signals);
        let comments = header.items.iter().filter_map(|item| match item {
            ScopeItem::Comment(text) => Some(text.as_str()),
            _ => None,
        });
        let comments = comments.collect();
        let mut rows = Vec::new();
        let mut now: HashMap<IdCode, u64> = HashMap::new();
        let mut time = None;
        for command in parser {
            match command.expect("it is sound") {
                Command::Timestamp(next) => {
                    rows.extend(time.map(|time| (time, now.clone())));
                    time = Some(next);
                }
                Command::ChangeScalar(id, value) => {
                    now.insert(id, u64::from(value == Value::V1));
                }
                Command::ChangeVector(id, bits) => {
                    let value =
                        bits.iter().fold(0, |value, bit| value << 1 | u64::from(bit == Value::V1));
                    now.insert(id, value);
                }
                _ => {}
            }
        }
        Waves { timescale: header.timescale, signals, rows, comments }
    }

    fn of(cosimulation: &mut Cosimulation) -> Waves {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("a.vcd");
        cosimulation.write_vcd(&path).expect("it can be written");
        Waves::read(&path)
    }

    /// A signal's value after each rising edge of the clock, with its time.
    fn at_rising_edges(&self, clock: &str, signal: &str) -> Vec<(u64, u64)> {
        let (clock, signal) = (self.signals[clock], self.signals[signal]);
        let mut was = 1;
        let mut values = Vec::new();
        for (time, row) in &self.rows {
            let is = row.get(&clock).copied().unwrap_or(0);
            if is == 1 && was == 0 {
                values.push((*time, row.get(&signal).copied().unwrap_or(0)));
            }
            was = is;
        }
        values
    }

    fn values(&self, signal: &str) -> Vec<u64> {
        let values = self.at_rising_edges("cosim.i_clk", signal);
        values.into_iter().map(|(_, value)| value).collect()
    }

    fn times(&self) -> Vec<u64> {
        let values = self.at_rising_edges("cosim.i_clk", "cosim.i_clk");
        values.into_iter().map(|(time, _)| time).collect()
    }
}

fn name_all(scope: &str, items: &[ScopeItem], signals: &mut HashMap<String, IdCode>) {
    for item in items {
        match item {
            ScopeItem::Scope(inner) => {
                name_all(&format!("{scope}{}.", inner.identifier), &inner.items, signals);
            }
            ScopeItem::Var(var) => {
                signals.insert(format!("{scope}{}", var.reference), var.code);
            }
            _ => {}
        }
    }
}

/// The counts of a scan's first steps from the sample words alone: every rising edge is
/// a hit, and counts up where the chip of its step is 1.
fn counted(chips: &[u8], words: &[u64], steps: u64) -> Vec<i64> {
    let samples: Vec<u64> =
        words.iter().flat_map(|word| (0..LANES).map(move |lane| word >> lane & 1)).collect();
    let code = (chips.len() as u64 * LANES) as i64;
    let count = |step: u64| {
        let of_step = step * CHIPS * LANES..(step + 1) * CHIPS * LANES;
        let hits = of_step
            .filter(|&at| samples[at as usize] == 1 && (at == 0 || samples[at as usize - 1] == 0));
        let sign = |at: u64| match chips
            [((at as i64 - step as i64).rem_euclid(code) / LANES as i64) as usize]
        {
            1 => 1,
            _ => -1,
        };
        hits.map(sign).sum()
    };
    (0..steps).map(count).collect()
}

#[test]
fn both_sides_show_the_code_and_the_counts_that_follow_from_the_samples() {
    let chips = &code(Family::Gold(5), 0, 3).chips;
    let mut found = emitted(Window::Clocks(0..20_000));
    assert_eq!(found.report.verdict, Verdict::Match);
    let waves = Waves::of(&mut found);
    // A whole scan of 248 steps of 40 chips, all of it in the file.
    let clocks = found.report.clocks;
    assert!(clocks < 20_000);
    let expected = VcdClocks { from: 0, clocks };
    assert_eq!(found.report.vcd_clocks, Some(expected));
    assert_eq!(waves.timescale, Some((1, TimescaleUnit::NS)));
    let times: Vec<u64> = (0..clocks).map(|clock| 8 * clock + 4).collect();
    assert_eq!(waves.times(), times);

    // The samples of chip n are on the port at the clock after its edge.
    let words = &waves.values("cosim.dut.i_samples")[RESET as usize + 1..];
    let counts = counted(chips, words, 240);
    assert!(counts.iter().any(|&count| count > 2) && counts.iter().any(|&count| count < -2));
    for side in ["dut", "model"] {
        let lasers = waves.values(&format!("cosim.{side}.o_laser"));
        let lit = lasers[RESET as usize..].iter().map(|&level| level as u8);
        assert!(
            lit.eq(chips.iter().copied().cycle().take(lasers.len() - RESET as usize)),
            "{side}"
        );
        let valid = waves.values(&format!("cosim.{side}.m_axis_tvalid"));
        let data = waves.values(&format!("cosim.{side}.m_axis_tdata"));
        let sent = valid.iter().zip(&data).filter(|(valid, _)| **valid == 1);
        let sent: Vec<i64> = sent.map(|(_, &data)| i64::from(data as u16 as i16)).collect();
        assert!(sent.len() >= 240, "{side}: {}", sent.len());
        assert_eq!(sent[..240], counts, "{side}");
    }
    assert!(waves.values("cosim.differs.any").iter().all(|&differs| differs == 0));
}

/// The clocks of a file, by the times of its rising edges.
fn clocks(waves: &Waves) -> Range<u64> {
    let times = waves.times();
    (times[0] - 4) / 8..(times[times.len() - 1] - 4) / 8 + 1
}

#[test]
fn a_match_shows_its_first_result_and_what_is_asked_for_is_what_is_there() {
    let mut found = emitted(Window::Found);
    let waves = Waves::of(&mut found);
    let valid = waves.values("cosim.dut.m_axis_tvalid");
    let result = valid.iter().position(|&valid| valid == 1).expect("a result");
    let clocks_shown = clocks(&waves);
    // The first step ends after 40 chips: fewer than a thousand clocks lie before it.
    assert_eq!(clocks_shown.start, 0);
    assert_eq!(clocks_shown.end, result as u64 + 1000);

    for asked in [0..1, 500..501, 1234..2345, 9000..100_000] {
        let mut found = emitted(Window::Clocks(asked.clone()));
        let waves = Waves::of(&mut found);
        assert_eq!(clocks(&waves), asked.start..asked.end.min(found.report.clocks));
    }
    let window = Window::Clocks(300..400);
    let options = CosimOptions { clocks: Some(300), window, ..Default::default() };
    let error = Sensor::new(&plain()).cosim(&options).expect_err("it ends before");
    assert!(error.to_string().contains("which has 300 clocks, 0 to 299"), "{error}");
}

#[test]
fn a_mismatch_shows_where_the_sides_part() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let emission = emit(&Sensor::new(&plain()), "goldtof emit test.toml").expect("it is fine");
    write(&emission, folder.path()).expect("the files can be written");
    let path = folder.path().join("result_stream.v");
    let text = fs::read_to_string(&path).expect("it is there");
    // Each result in its lowest bit.
    let faulty = text.replacen("o_data = {", "o_data = 16'd1 ^ {", 1);
    assert_ne!(faulty, text);
    fs::write(&path, faulty).expect("it can be written");
    let rtl = || OwnRtl::folder(folder.path());
    let mut found = co_simulated(&plain(), rtl(), Window::Found);
    let first = found.report.first_mismatch.clone().expect("they differ");
    assert_eq!(first.port, "m_axis_tdata");
    let waves = Waves::of(&mut found);
    let shown = clocks(&waves);
    assert!(shown.contains(&first.clock));
    let at = (first.clock - shown.start) as usize;
    let any = waves.values("cosim.differs.any");
    assert_eq!(any.iter().position(|&differs| differs == 1), Some(at));
    assert_eq!(waves.values("cosim.differs.m_axis_tdata")[at], 1);
    assert_eq!(waves.values("cosim.differs.m_axis_tvalid")[at], 0);
    let [dut, model] =
        ["dut", "model"].map(|side| waves.values(&format!("cosim.{side}.m_axis_tdata"))[at]);
    assert_eq!(dut ^ 1, model);
    // What a stream holds while it is not valid is the user's own business.
    let valid = waves.values("cosim.model.m_axis_tvalid");
    assert!(valid.iter().zip(&any).all(|(valid, any)| any <= valid));

    // Of clocks that the run does not come to, those round the mismatch are shown.
    let mut early = co_simulated(&plain(), rtl(), Window::Clocks(9900..9910));
    if early.report.clocks < 9900 {
        assert!(clocks(&Waves::of(&mut early)).contains(&first.clock));
    }
}

#[test]
fn a_period_that_is_no_whole_number_of_any_unit_is_rounded_and_said() {
    let mut scene = plain();
    scene.chip_period_ps = 1e4 / 3.0;
    let mut found = co_simulated(&scene, OwnRtl::default(), Window::Clocks(0..100));
    let waves = Waves::of(&mut found);
    assert_eq!(waves.timescale, Some((1, TimescaleUnit::FS)));
    assert!(waves.comments.contains("rounded to 1 fs"), "{}", waves.comments);
    // Thirds of 10 ns, without a drift.
    let expected: Vec<u64> = (0..100).map(|clock| (10_000_000 * (2 * clock + 1) + 3) / 6).collect();
    assert_eq!(waves.times(), expected);
}

#[test]
fn views_name_signals_that_are_there_and_leave_others_files_alone() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let folder = folder.path();
    let mut found = emitted(Window::Found);
    let path = folder.join("a.vcd");
    // Our own are replaced, again and again.
    for _ in 0..2 {
        found.write_vcd(&path).expect("it can be written");
    }
    let waves = Waves::read(&path);
    let outputs = found.report.compared_ports.len();
    let view = |name: &str| fs::read_to_string(folder.join(name)).expect("it was written");
    let gtkwave = view("a.gtkw");
    let traces = gtkwave.lines().filter(|line| line.contains("cosim.") && !line.starts_with('['));
    let named: Vec<&str> = traces
        .map(|line| line.rsplit(' ').next().unwrap_or(line))
        .map(|name| name.split('[').next().unwrap_or(name))
        .collect();
    assert_eq!(named.len(), 2 + 3 + 2 * outputs);
    let surfer = view("a.sucl");
    let added: Vec<&str> =
        surfer.lines().filter_map(|line| line.strip_prefix("variable_add ")).collect();
    assert_eq!(added, named);
    let questa = view("a.do");
    let added: Vec<String> = questa
        .lines()
        .filter(|line| line.starts_with("add wave ") && !line.contains("-divider"))
        .map(|line| line.rsplit(" /").next().unwrap_or(line).replace('/', "."))
        .collect();
    assert_eq!(added, named);
    for name in named {
        assert!(waves.signals.contains_key(name), "{name}");
    }
    // The marker stands at the first result's edge.
    let valid = waves.at_rising_edges("cosim.i_clk", "cosim.dut.m_axis_tvalid");
    let (time, _) = valid.iter().find(|(_, valid)| *valid == 1).expect("a result");
    assert!(gtkwave.contains(&format!(" {time} -1\n")), "{gtkwave}");
    assert!(surfer.contains(&format!("cursor_set {time}\n")), "{surfer}");
    assert!(questa.contains(&format!("wave cursor add -time {time} ")), "{questa}");

    // A view that the user has saved, and one that is a link, stay as they are.
    fs::write(folder.join("b.gtkw"), "[*] GTKWave Analyzer\n").expect("written");
    std::os::unix::fs::symlink("elsewhere", folder.join("b.sucl")).expect("a link");
    found.write_vcd(&folder.join("b.vcd")).expect("it can be written");
    assert_eq!(view("b.gtkw"), "[*] GTKWave Analyzer\n");
    assert!(!folder.join("elsewhere").exists());
    // Beside a device there is nothing to view.
    found.write_vcd(Path::new("/dev/null")).expect("it can be written");
    assert!(!Path::new("/dev/null.gtkw").exists() && !Path::new("/dev/gtkw").exists());
}

#[test]
fn the_testbenchs_waves_have_the_chips_time_in_both_simulators() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let folder = folder.path();
    let emission = emit(&Sensor::new(&plain()), "goldtof emit test.toml").expect("it is fine");
    write(&emission, folder).expect("the files can be written");
    let top = "sensor_top_tb";
    let waves = folder.join("sensor_top_tb.vcd");
    // Rising edges after half a period of 8 ns, and one every period.
    let check = |unit, ticks_per_ns: u64| {
        let waves = Waves::read(&waves);
        assert_eq!(waves.timescale, Some((1, unit)));
        let clock = format!("{top}.i_clk");
        let clock = match waves.signals.contains_key(&clock) {
            true => clock,
            false => format!("TOP.{clock}"),
        };
        let edges = waves.at_rising_edges(&clock, &clock);
        assert!(edges.len() > 1000);
        for (number, (time, _)) in (0..).zip(&edges) {
            assert_eq!(*time, (8 * number + 4) * ticks_per_ns);
        }
    };
    run(folder, "iverilog", &["-g2005", "-s", top, "-o", "tb.vvp", "-f", "sensor_top_tb.f"]);
    assert!(run(folder, "vvp", &["-n", "tb.vvp", "+vcd"]).contains("PASS"));
    check(TimescaleUnit::NS, 1);
    fs::remove_file(&waves).expect("it is there");
    let build = ["--binary", "--trace", "-Wall", "--top-module", top, "-f", "sensor_top_tb.f"];
    run(folder, "verilator", &build);
    assert!(run(folder, "./obj_dir/Vsensor_top_tb", &["+vcd"]).contains("PASS"));
    check(TimescaleUnit::PS, 1000);
}
