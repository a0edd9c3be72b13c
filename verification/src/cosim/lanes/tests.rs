//! Lanes against lock-step, and what has to be caught.

use std::path::Path;
use std::sync::atomic::AtomicBool;

use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::design::Backend;
use super::model::{LaneBlock, LaneModel, PeriodicOutput};
use super::netlist::{BitNet, Function, GateNetlist};
use super::planes::Planes;
use super::*;
use crate::cosim::TOP;
use crate::cosim::build::{build, cache_dir};
use crate::cosim::lockstep::Lockstep;
use crate::cosim::sent::SentCount;
use crate::cosim::source::sources_of;
use crate::cosim::verilated::Verilated;
use crate::deliver::{self, Prefix};
use crate::reference::photons::Photons;
use crate::reference::predictor::ReferenceModel;
use crate::reference::stimulus::clocks_for_scans;
use crate::scene::{self, DetectorIndex, Polarity, Scene, SourceIndex};
use crate::sensor::Sensor;
use crate::sensor::layout::Layout;
use crate::sensor::port::Direction;

const SEED: u64 = 7;

/// A standard scene with phase steps of few chips, and at most so many of them.
fn small(name: &str, steps: u64, change: impl FnOnce(&mut Scene)) -> Sensor {
    let path = format!("{}/../scenes/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    let mut scene = scene::load(Path::new(&path)).unwrap();
    scene.scan.integration_chips = 300;
    if scene.scan.steps > steps {
        scene.scan.steps = steps;
    }
    for source in &mut scene.sources {
        source.mean_power_w *= 20.0;
    }
    change(&mut scene);
    Sensor::new(&scene)
}

fn sources(sensor: &Sensor) -> Vec<SourceFile> {
    sources_of(&deliver::verilog(sensor, &Prefix::default(), "goldtof test").unwrap())
}

fn models(sensor: &Sensor) -> Vec<DetectorModel> {
    DetectorIndex::of(&sensor.scene().detectors)
        .map(|detector| DetectorModel::new(sensor, detector))
        .collect()
}

fn prepared(sensor: &Sensor, sources: &[SourceFile]) -> PreparedLanes {
    let interface = sensor.interface();
    let clocks = clocks_for_scans(interface, 1);
    PreparedLanes::new(TOP, sources, interface, clocks, &cache_dir().unwrap()).unwrap()
}

fn run(sensor: &Sensor, prepared: &PreparedLanes) -> Result<LanesOutcome, LaneRefusal> {
    let clocks = clocks_for_scans(sensor.interface(), 1);
    prepared.run(&models(sensor), SEED, clocks, &AtomicBool::new(false), &|_| ())
}

/// What the RTL sends in lock-step, which has to be a match.
fn in_lockstep(sensor: &Sensor) -> (Vec<SentCount>, crate::reference::exercise::Exercised) {
    let interface = sensor.interface();
    let layout = Layout::of(interface);
    let cache = cache_dir().unwrap();
    let built = build(TOP, &sources(sensor), interface, &cache).unwrap();
    let mut sent = Vec::new();
    let outcome = Lockstep {
        model: &mut Verilated::load(&built, &layout).unwrap(),
        reference: &mut ReferenceModel::new(interface.clone()).unwrap(),
        stimulus: &mut Photons::new(&models(sensor), interface, SEED),
        layout: &layout,
        window: crate::cosim::window::Window::Found,
    }
    .run_and_read(
        clocks_for_scans(interface, 1),
        &mut |_| (),
        &mut |count| sent.push(count),
        &mut |_| (),
    )
    .unwrap();
    assert_eq!(outcome.first, None);
    (sent, outcome.exercise)
}

/// Both engines compare every output at every clock with the same expectations; so
/// they are equal at every clock where both match.
fn assert_lanes_equal_lockstep(name: &str, sensor: &Sensor) {
    let outcome = run(sensor, &prepared(sensor, &sources(sensor)))
        .unwrap_or_else(|refusal| panic!("{name}: {refusal}"));
    assert_eq!(outcome.differs, None, "{name}");
    assert!(outcome.lanes >= 2, "{name}: {} lanes", outcome.lanes);
    let (sent, exercise) = in_lockstep(sensor);
    assert_eq!(outcome.sent, sent, "{name}");
    assert_eq!(outcome.exercise, exercise, "{name}");
    assert!(exercise.detectors.iter().all(|d| d.hits_up > 100), "{name}");
}

#[test]
fn lanes_equal_lockstep_on_standard_scenes() {
    for name in ["paper-single", "paper-square", "paper-interleaved"] {
        assert_lanes_equal_lockstep(name, &small(name, 600, |_| ()));
    }
}

#[test]
fn lanes_equal_lockstep_on_several_paths_codes_and_windows() {
    for name in ["dual-view", "multipath", "moving", "quick"] {
        assert_lanes_equal_lockstep(name, &small(name, 600, |_| ()));
    }
}

/// With several detectors, steps at once, peaks, a narrow count and a window.
fn rich() -> Sensor {
    small("dual-view", 601, |scene| {
        let mut second = scene.detectors[0].clone();
        second.name = "second".to_owned();
        second.reference = SourceIndex(1);
        scene.detectors.push(second);
        for mut path in scene.paths.clone() {
            path.detector = DetectorIndex(1);
            scene.paths.push(path);
        }
        scene.hardware.parallel = 4;
        scene.hardware.peak_detector = true;
        scene.hardware.counter_width = Some(7);
        scene.hardware.polarity = Polarity::Low;
        scene.scan.first_step = 37;
    })
}

#[test]
fn lanes_equal_lockstep_on_several_detectors_steps_at_once_and_windows() {
    assert_lanes_equal_lockstep("rich", &rich());
}

/// Nets and registers of 64 lanes, gate by gate.
struct OneByOne<'a> {
    netlist: &'a GateNetlist,
    /// In the order of the planes.
    outputs: &'a [BitNet],
    nets: Vec<u64>,
    registers: Vec<u64>,
}

impl OneByOne<'_> {
    fn settle(&mut self) {
        self.nets[BitNet::ONE.index()] = u64::MAX;
        for (register, &value) in self.netlist.registers.iter().zip(&self.registers) {
            self.nets[register.q.index()] = value;
        }
        for gate in &self.netlist.gates {
            let [a, b, s] = gate.inputs.map(|net| self.nets[net.index()]);
            self.nets[gate.output.index()] = match gate.function {
                Function::Mux => s & b | !s & a,
                Function::Table(table) => {
                    let minterms = [!a & !b, a & !b, !a & b, a & b];
                    let holds =
                        |(i, value): (usize, u64)| if table >> i & 1 == 1 { value } else { 0 };
                    minterms.into_iter().enumerate().map(holds).fold(0, |sum, value| sum | value)
                }
            };
        }
    }

    /// A clock, with these values of the inputs' bits; gives those of the outputs' bits after it.
    fn clock(&mut self, input: impl Fn(&str, usize) -> u64) -> Vec<u64> {
        for port in &self.netlist.inputs {
            for (bit, net) in port.nets.iter().enumerate() {
                self.nets[net.index()] = input(&port.name, bit);
            }
        }
        self.settle();
        let of = |net: BitNet| self.nets[net.index()];
        let next = self.netlist.registers.iter().zip(&self.registers).map(|(register, &old)| {
            let enable = register.enable.map_or(u64::MAX, of);
            let value = enable & of(register.d) | !enable & old;
            register.reset.map_or(value, |reset| match reset.value {
                true => value | of(reset.when),
                false => value & !of(reset.when),
            })
        });
        self.registers = next.collect();
        self.settle();
        self.outputs.iter().map(|net| self.nets[net.index()]).collect()
    }

    /// The outputs clock by clock under samples, and whether a result stood at each of them.
    fn clocks(
        &mut self,
        samples: &[u64],
        of_clock: usize,
        reset: u64,
        valid: usize,
        stood: &mut [bool],
    ) -> Vec<Vec<u64>> {
        let of_clocks = samples.chunks(of_clock).zip(stood);
        let outputs = of_clocks.map(|(samples, stood)| {
            let outputs = self.clock(|port, bit| match port {
                "i_rst" => reset,
                "m_axis_tready" => u64::MAX,
                _ => samples[bit],
            });
            *stood |= outputs[valid] != 0;
            outputs
        });
        outputs.collect()
    }
}

/// One word of lanes of each row.
fn words(planes: &Planes, word: usize) -> Vec<u64> {
    planes.rows().map(|row| row[word]).collect()
}

/// Where the samples of a detector change, as a block of lanes has it, of rows that are clocks'
/// samples one after another.
fn edges_of(samples: &Planes, lanes: usize, of_clock: usize, of_detector: usize) -> Vec<u32> {
    let mut edges = Vec::new();
    for lane in 0..lanes {
        let mut levels = vec![false; of_clock / of_detector];
        for (row, _) in samples.rows().enumerate() {
            let level = &mut levels[row % of_clock / of_detector];
            let sample = samples.get(row, lane);
            if std::mem::replace(level, sample) != sample {
                edges.push((row * lanes + lane) as u32);
            }
        }
    }
    edges
}

/// Both programs of a netlist, from any registers, with any inputs and resets of any lanes, against
/// the gates themselves: all registers, and what was found of the outputs.
fn assert_programs_equal_the_gates(name: &str, sensor: &Sensor) {
    const CLOCKS: u64 = 40;
    let interface = sensor.interface();
    let cache = cache_dir().unwrap();
    let netlist = LaneDesign::netlist(TOP, &sources(sensor), Memories::Refused, &cache).unwrap();
    let design = LaneDesign::of(&netlist, interface, &cache).unwrap();
    let layout = Layout::of(interface);
    let outputs = super::design::planes(&netlist.outputs, &layout.outputs).unwrap();
    let before = layout.outputs.fields.iter();
    let before = before.take_while(|field| field.port.name != "m_axis_tvalid");
    let valid: usize = before.map(|field| field.port.width as usize).sum();
    let mut beats = 0;
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(SEED);
    for backend in [Backend::Vectors, Backend::Verilator] {
        let lanes = backend.lanes();
        let mut random = |rows: usize| {
            Planes::of_words(lanes, (0..rows * lanes / 64).map(|_| rng.random()).collect())
        };
        let dark =
            |output| PeriodicOutput { output, planes: Planes::new(lanes, 1).into(), length: 1 };
        let tables: Vec<PeriodicOutput> = (0..design.tables).map(dark).collect();
        let mut model = LaneModel::load(&design, backend, &tables).unwrap();
        let start = random(netlist.registers.len());
        model.set_registers(&start).unwrap();
        model.expect(&Planes::new(lanes, design.outputs)).unwrap();
        let everywhere = Planes::row_where(lanes, (0..lanes).map(|_| true));
        let resets = [Planes::new(lanes, 1), random(1), Planes::new(lanes, 1)];
        let mut gates: Vec<OneByOne> = (0..lanes / 64)
            .map(|word| OneByOne {
                netlist: &netlist,
                outputs: &outputs,
                nets: vec![0; netlist.nets],
                registers: words(&start, word),
            })
            .collect();
        for reset in resets {
            let samples = random(CLOCKS as usize * design.samples);
            let edges = edges_of(&samples, lanes, design.samples, interface.lanes() as usize);
            let block = LaneBlock {
                clocks: CLOCKS,
                reset: reset.clone(),
                watched: everywhere.clone(),
                edges,
                events: Vec::new(),
                phases: vec![0; design.tables],
            };
            model.submit(&block).unwrap();
            let found = model.collect().unwrap();
            let registers = model.registers().unwrap();
            let mut stood = vec![false; CLOCKS as usize];
            for (word, gates) in gates.iter_mut().enumerate() {
                // Pulses make the samples low where the comparator inverts.
                let idle = if interface.polarity == Polarity::Low { u64::MAX } else { 0 };
                let samples: Vec<u64> = words(&samples, word).iter().map(|s| s ^ idle).collect();
                let outputs = gates.clocks(
                    &samples,
                    design.samples,
                    words(&reset, word)[0],
                    valid,
                    &mut stood,
                );
                for (clock, beat) in &found.beats {
                    let expected = &outputs[*clock as usize];
                    assert_eq!(&words(beat, word), expected, "{name} {backend:?} {clock}");
                }
                let different = outputs.iter().flatten().fold(0, |all, output| all | output);
                assert_eq!(words(&found.different, word)[0], different, "{name} {backend:?}");
                assert_eq!(words(&registers, word), gates.registers, "{name} {backend:?}");
            }
            let told: Vec<u64> = found.beats.iter().map(|beat| beat.0).collect();
            let expected: Vec<u64> = (0..CLOCKS).filter(|&clock| stood[clock as usize]).collect();
            assert_eq!(told, expected, "{name} {backend:?}");
            beats += told.len();
        }
    }
    // With anything in the registers a result stands somewhere.
    assert!(beats > 0, "{name}");
}

#[test]
fn vectors_and_words_are_the_gates_of_every_standard_scene() {
    for name in [
        "paper-single",
        "paper-square",
        "paper-interleaved",
        "dual-view",
        "multipath",
        "moving",
        "quick",
    ] {
        assert_programs_equal_the_gates(name, &small(name, 600, |_| ()));
    }
    assert_programs_equal_the_gates("rich", &rich());
}

/// So long that few groups are watched: too few to see a reference's period among them, which waits
/// for a chip in every eighth.
#[test]
fn lanes_equal_lockstep_where_phase_steps_are_long() {
    let long = |name, integration_chips, change: fn(&mut Scene)| {
        let sensor = small(name, 48, |scene| {
            scene.scan.integration_chips = integration_chips;
            for source in &mut scene.sources {
                source.mean_power_w /= 20.0;
            }
            change(scene);
        });
        assert_lanes_equal_lockstep(name, &sensor);
    };
    long("quick", 125_000, |_| ());
    long("paper-single", 101_000, |scene| {
        scene.hardware.parallel = 2;
        scene.scan.steps = 200;
        scene.scan.first_step = 16_300;
    });
}

/// Pulses longer than the dead time overlap, and many reach from one block of clocks, and
/// from one lane's slice, into the next.
#[test]
fn lanes_equal_lockstep_where_pulses_overlap() {
    let sensor = small("paper-single", 600, |scene| {
        let detector = &mut scene.detectors[0];
        detector.pulse_width_ps = 2.6 * detector.dead_time_ps;
    });
    assert_lanes_equal_lockstep("overlapping pulses", &sensor);
    let short = small("paper-single", 600, |_| ());
    let hits = |sensor| in_lockstep(sensor).1.detectors[0].hits_up;
    // Else nothing has overlapped.
    assert!(10 * hits(&sensor) < 9 * hits(&short));
}

#[test]
fn a_run_that_is_not_wanted_any_more_ends() {
    let sensor = small("paper-single", 300, |_| ());
    let clocks = clocks_for_scans(sensor.interface(), 1);
    let stop = AtomicBool::new(true);
    let outcome =
        prepared(&sensor, &sources(&sensor)).run(&models(&sensor), SEED, clocks, &stop, &|_| ());
    assert!(
        matches!(outcome, Err(LaneRefusal::Unfit(reason)) if reason.to_string() == "it was stopped")
    );
}

#[test]
fn a_flipped_register_and_a_scan_one_step_short_differ() {
    let sensor = small("paper-single", 300, |_| ());
    let interface = sensor.interface();
    let cache = cache_dir().unwrap();
    let good = prepared(&sensor, &sources(&sensor));
    let short = small("paper-single", 299, |_| ());
    let bad = LaneDesign::build(TOP, &sources(&short), interface, &cache).unwrap();
    let with = |design: LaneDesign| PreparedLanes {
        starts: Starts::of(&design, interface, &cache).unwrap(),
        design,
        interface: interface.clone(),
    };
    let outcome = run(&sensor, &with(bad));
    let caught = |outcome: Result<LanesOutcome, LaneRefusal>| match outcome {
        Ok(outcome) => outcome.differs.is_some(),
        Err(LaneRefusal::NoVerdict(_)) => true,
        Err(error) => panic!("{error}"),
    };
    assert!(caught(outcome), "a step short");
    let mut netlist =
        LaneDesign::netlist(TOP, &sources(&sensor), Memories::Refused, &cache).unwrap();
    let chosen = netlist.registers.len() / 2;
    let register = &mut netlist.registers[chosen];
    let (d, inverted) = (register.d, BitNet(netlist.nets as u32));
    register.d = inverted;
    netlist.nets += 1;
    netlist.gates.push(super::netlist::LogicGate {
        function: Function::NOT,
        inputs: [d, BitNet::ZERO, BitNet::ZERO],
        output: inverted,
    });
    let flipped = LaneDesign::of(&netlist, interface, &cache).unwrap();
    assert!(caught(run(&sensor, &with(flipped))), "a flipped register");
    assert!(!caught(run(&sensor, &good)), "neither");
}

#[test]
fn a_start_state_that_is_wrong_in_one_bit_does_not_stitch() {
    let sensor = small("paper-single", 300, |_| ());
    let mut prepared = prepared(&sensor, &sources(&sensor));
    let told = |outcome: Result<LanesOutcome, LaneRefusal>| match outcome {
        Err(LaneRefusal::NoVerdict(reason)) => reason,
        Err(error) => panic!("{error}"),
        Ok(outcome) => format!("differs: {:?}", outcome.differs),
    };
    assert_eq!(told(run(&sensor, &prepared)), "differs: None");
    // A total is never cleared and shows nowhere but in the stitch.
    assert!(prepared.starts.spoil_a_count());
    let reason = told(run(&sensor, &prepared));
    assert!(reason.contains("do not begin a lane as the lane before ends"), "{reason}");
}

/// A top module with this body.
fn with_body(body: &str, interface: &Interface) -> [SourceFile; 1] {
    let ports: Vec<String> = interface
        .ports()
        .iter()
        .map(|port| {
            let direction = match port.direction {
                Direction::Input => "input",
                Direction::Output => "output reg",
            };
            format!("{direction} [{}:0] {}", port.width - 1, port.name)
        })
        .collect();
    let other = if body.starts_with("input i_other;") { ", i_other" } else { "" };
    let names: Vec<String> = interface.ports().into_iter().map(|port| port.name).collect();
    let text = format!(
        "module sensor_top({}{other});\n{};\n{body}\nendmodule\n",
        names.join(", "),
        ports.join(";\n")
    );
    [SourceFile { name: "sensor_top.v".to_owned(), text, origin: None }]
}

/// What lanes say of a top module with this body; "taken" if they take it.
fn said_of(body: &str, interface: &Interface, cache: &Path) -> String {
    match LaneDesign::build(TOP, &with_body(body, interface), interface, cache) {
        Err(LaneRefusal::Unfit(reason)) => reason.to_string(),
        Err(error) => panic!("{error}"),
        Ok(_) => "taken".to_owned(),
    }
}

#[test]
fn what_has_no_place_in_lanes_is_named() {
    let sensor = small("paper-single", 300, |_| ());
    let interface = sensor.interface();
    let cache = cache_dir().unwrap();
    let rest = "always @(posedge i_clk) {o_laser, o_epoch, m_axis_tdata, m_axis_tvalid, \
                m_axis_tlast} <= 0;";
    let cases = [
        ("always @(posedge i_clk) o_overrun <= i_rst;", "taken"),
        ("always @* o_overrun = i_samples[0];", "o_overrun follows an input within a clock"),
        ("always @* if (i_samples[0]) o_overrun = i_samples[1];", "latch"),
        ("always @(negedge i_clk) o_overrun <= i_rst;", "rising edge of i_clk"),
        ("always @(posedge i_samples[0]) o_overrun <= i_rst;", "rising edge of i_clk"),
        (
            "reg [7:0] m [0:4095]; reg [11:0] a; always @(posedge i_clk) begin a <= a + 1; \
             m[a] <= i_samples; o_overrun <= m[a + 5][0]; end",
            "a memory",
        ),
        ("assign o_overrun = ;", "Yosys does not take it"),
        // Nothing would say what level it has.
        ("input i_other; always @(posedge i_clk) o_overrun <= i_other;", "i_other is not one"),
    ];
    for (body, told) in cases {
        let reason = said_of(&format!("{body}\n{rest}"), interface, &cache).to_lowercase();
        assert!(reason.contains(&told.to_lowercase()), "{body}: {reason}");
    }
}

/// The rest of a top module whose output `o_overrun` is made of something else.
const REST: &str = "always @(posedge i_clk) {o_laser, o_epoch, m_axis_tdata, m_axis_tvalid, \
                    m_axis_tlast} <= 0;";

/// What drives `o_overrun` so that synthesis may make something else of it than simulation, and
/// what is said of it.
const AMBIGUOUS: [(&str, &str); 21] = [
    ("wire [2:0] t = i_samples[2:0]; `AT o_overrun <= t[i_samples[4:3]];", "select"),
    ("wire [6:0] t = i_samples[6:0]; `AT o_overrun <= |t[i_samples[2:0] +: 2];", "select"),
    ("wire [2:0] t = i_samples[2:0]; `AT o_overrun <= t[5];", "an x"),
    ("`AT o_overrun <= i_rst ? 1'b1 : 1'bx;", "an x"),
    ("`AT o_overrun <= ^{i_samples, {4{1'bx}}};", "an x"),
    ("`AT o_overrun <= i_samples[3:0] == 4'b10x1;", "an x"),
    ("`AT if (i_samples[0] ^ 1'bx) o_overrun <= 1'b1; else o_overrun <= 1'b0;", "an x"),
    (
        "`AT case (i_samples[1:0]) 0: o_overrun <= 1; 1: o_overrun <= 0; default: o_overrun <= 1'bx; \
      endcase",
        "an x",
    ),
    ("`AT o_overrun <= i_samples / i_samples[3:0] == 3;", "division"),
    ("`AT o_overrun <= i_samples % i_samples[3:0] == 3;", "remainder"),
    ("`AT o_overrun <= i_samples[1:0] ** i_samples[3:2] == 1;", "a power"),
    ("wire u; `AT o_overrun <= u;", "nothing drives"),
    ("wire [1:0] u; assign u[0] = i_rst; `AT o_overrun <= ^u;", "nothing drives"),
    ("reg m [0:3]; `AT o_overrun <= m[i_samples[1:0]];", ""),
    (
        "reg [3:0] m [0:2]; `AT begin m[i_samples[1:0]] <= i_samples[7:4]; \
      o_overrun <= m[i_samples[3:2]][0]; end",
        "a memory",
    ),
    ("reg w; always @(i_rst) w = i_rst & i_samples[0]; `AT o_overrun <= w;", "a list"),
    ("reg n; `AT n = i_samples[0]; `AT o_overrun <= n;", "read elsewhere"),
    (
        "`AT (* full_case *) case (i_samples[1:0]) 0: o_overrun <= 1; 1: o_overrun <= 0; endcase",
        "full_case",
    ),
    (
        "`AT (* parallel_case *) casez (i_samples[1:0]) 2'b1?: o_overrun <= 1; 2'b?1: o_overrun <= 0; \
      endcase",
        "parallel_case",
    ),
    ("reg l; always @* if (i_samples[0]) l = i_samples[1]; `AT o_overrun <= l;", "latch"),
    (
        "wire y; inner inner (.a(), .y(y)); `AT o_overrun <= y; endmodule \
      module inner(input a, output y); assign y = ~a;",
        "",
    ),
];

/// The same things, where nothing is undefined.
const PLAIN: [&str; 6] = [
    "wire [3:0] t = i_samples[3:0]; `AT o_overrun <= t[i_samples[5:4]];",
    "`AT casez (i_samples[1:0]) 2'b1?: o_overrun <= 1; default: o_overrun <= 0; endcase",
    "reg w; always @* w = i_rst & i_samples[0]; `AT o_overrun <= w;",
    "reg w; always @(i_rst or i_samples) w = i_rst & i_samples[0]; `AT o_overrun <= w;",
    "reg n; `AT begin n = i_samples[0]; o_overrun <= n; end",
    "wire y; inner inner (.a(i_rst), .y(y)); `AT o_overrun <= y; endmodule \
     module inner(input a, output y); assign y = ~a;",
];

#[test]
fn what_synthesis_may_read_differently_is_for_lock_step() {
    let sensor = small("paper-single", 300, |_| ());
    let interface = sensor.interface();
    let cache = cache_dir().unwrap();
    let said = |body: &str| {
        let body = format!("{REST}\n{}", body.replace("`AT", "always @(posedge i_clk)"));
        match super::meaning::refuse_ambiguous(TOP, &with_body(&body, interface), &cache) {
            Err(LaneRefusal::Unfit(reason)) => reason.to_string(),
            Err(error) => panic!("{body}: {error}"),
            Ok(()) => "taken".to_owned(),
        }
    };
    for (body, told) in AMBIGUOUS {
        let reason = said(body);
        assert!(
            reason.contains("may not mean the same") && reason.contains(told),
            "{body}: {reason}"
        );
    }
    for body in PLAIN {
        assert_eq!(said(body), "taken", "{body}");
    }
}
