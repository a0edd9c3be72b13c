//! The library as its users have it: a program in C, a testbench in C++, and
//! SystemVerilog in Verilator, on the emitted Verilog, on somebody's own, and with faults.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use goldtof::deliver::Prefix;
use goldtof::deliver::testbenches::bind;
use goldtof::scene::{SceneText, Setting};
use goldtof::{EmitOptions, Jobs as _, Sensor};
use tempfile::TempDir;

const DESIGN: &str = "generated/quick";

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap()
}

/// Where cargo has put the library.
fn library() -> PathBuf {
    let test = std::env::current_exe().unwrap();
    let folder = test.parent().unwrap();
    assert!(folder.join("libgoldtof_c.so").exists(), "{}", folder.display());
    folder.to_owned()
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

fn ran(output: &Output) -> String {
    format!(
        "{:?}\n{}{}",
        output.status.code(),
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr)
    )
}

fn run(command: &mut Command) -> Output {
    let output = command.current_dir(root()).output();
    output.unwrap_or_else(|error| panic!("{command:?}: {error}"))
}

fn must_run(command: &mut Command) -> String {
    let output = run(command);
    assert!(output.status.success(), "{command:?}: {}", ran(&output));
    String::from_utf8(output.stdout).unwrap()
}

/// A program in C, linked as `link` says.
fn compiled(folder: &TempDir, source: &str, link: &[&str]) -> PathBuf {
    let program = folder.path().join("program");
    let mut command = Command::new("gcc");
    command.args(["-std=c99", "-Wall", "-Wextra", "-Werror", "-Icapi/include"]);
    command.args([source, "-o", text(&program)]);
    must_run(command.args(link));
    program
}

/// At step 0 every pulse is counted up, and the pulses are as many as the example has
/// made: neither number is the model's word alone.
fn is_looped_back(printed: &str) {
    let lines: Vec<&str> = printed.lines().collect();
    let number = |line: &str, word: &str| -> i64 {
        let mut words = line.split(' ').skip_while(|&w| w != word).skip(1);
        words.next().unwrap().parse().unwrap()
    };
    assert_eq!(lines.len(), 3, "{printed}");
    let (count, total) = (number(lines[1], "counts"), number(lines[1], "of"));
    // Chips of 31 in a period, in 2,500 chips: 80.6 periods of 16, or of 12 or 20, ones.
    assert!(count == total && total > 2500 / 3, "{printed}");
    assert!(number(lines[2], "counts") <= number(lines[2], "of"), "{printed}");
    let pulses: i64 = lines[0].split(' ').next().unwrap().parse().unwrap();
    let in_two_steps = total + number(lines[2], "of");
    assert!((pulses - in_two_steps).abs() < 998 && pulses > in_two_steps, "{printed}");
}

#[test]
fn c_programs_link_either_library() {
    let folder = TempDir::new().unwrap();
    let library = library();
    let example = "capi/examples/loop_back.c";
    let archive = library.join("libgoldtof_c.a");
    let program = compiled(&folder, example, &[text(&archive), "-lm", "-lpthread", "-ldl"]);
    is_looped_back(&must_run(Command::new(&program).arg("scenes/quick.toml")));

    let rpath = format!("-Wl,-rpath,{}", library.display());
    let shared = ["-L", text(&library), "-lgoldtof_c", &rpath];
    let program = compiled(&folder, example, &shared);
    is_looped_back(&must_run(Command::new(&program).arg("scenes/quick.toml")));

    let broken = folder.path().join("broken.toml");
    fs::write(&broken, "clock.chip_period = 8\n").unwrap();
    let output = run(Command::new(&program).arg(&broken));
    let told = ran(&output);
    assert_eq!(output.status.code(), Some(2), "{told}");
    assert!(told.contains("broken.toml:1:21: ") && told.contains("has no unit"), "{told}");
}

#[test]
fn wrong_use_gets_an_error_and_never_a_crash() {
    let folder = TempDir::new().unwrap();
    let library = library();
    let rpath = format!("-Wl,-rpath,{}", library.display());
    let shared = ["-L", text(&library), "-lgoldtof_c", &rpath];
    let program = compiled(&folder, "capi/tests/wrong_use.c", &shared);
    let told = must_run(&mut Command::new(program));
    assert!(told.ends_with("all refused\n"), "{told}");
}

/// The generated design with a fault in one file.
fn with_fault(folder: &Path, file: &str, sound: &str, faulty: &str) -> PathBuf {
    let copy = folder.join("design");
    fs::create_dir(&copy).unwrap();
    for entry in fs::read_dir(root().join(DESIGN)).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|extension| extension == "v") {
            fs::copy(&path, copy.join(path.file_name().unwrap())).unwrap();
        }
    }
    let path = copy.join(file);
    let design = fs::read_to_string(&path).unwrap();
    assert_eq!(design.matches(sound).count(), 1, "{file}");
    fs::write(&path, design.replace(sound, faulty)).unwrap();
    copy
}

/// Verilator, whose makefiles optimise nothing: what they make runs for moments. What `-CFLAGS`
/// says of that stands before their own `-Os`.
fn verilator() -> Command {
    let mut command = Command::new("verilator");
    command.env("MAKEFLAGS", "OPT_FAST=-O0 OPT_SLOW=-O0 OPT_GLOBAL=-O0");
    command
}

/// The example testbench in Verilator, with the design that `arguments` name.
fn simulated(arguments: &[&str]) -> Output {
    simulated_with("capi/examples/testbench.sv", arguments)
}

/// Another testbench.
fn simulated_with(testbench: &str, arguments: &[&str]) -> Output {
    let folder = TempDir::new().unwrap();
    let library = library();
    let mut verilator = verilator();
    verilator.args(["--binary", "--timing", "-Icapi/sv", "--top", "testbench"]);
    verilator.args(["--Mdir", text(folder.path())]);
    // Nothing in the scoreboard is anything that lint would stop at; the designs are
    // linted elsewhere.
    verilator.arg(testbench).args(arguments);
    verilator.arg(library.join("libgoldtof_c.so"));
    verilator.args(["-LDFLAGS", &format!("-Wl,-rpath,{}", library.display())]);
    must_run(&mut verilator);
    run(&mut Command::new(folder.path().join("Vtestbench")))
}

#[test]
fn systemverilog_testbenches_compare_every_port() {
    let output = simulated(&["-y", DESIGN, "generated/quick/sensor_top.v"]);
    let told = ran(&output);
    assert!(output.status.success(), "{told}");
    // Of 7 steps, 3 before the second reset, 2 end while the receiver stalls for 4,096
    // clocks: the result of one waits, and that of the other is lost.
    assert!(told.contains("goldtof_scoreboard: match: 20000 clocks compared"), "{told}");
    assert!(told.contains("spad: 6 results") && told.contains("1 overruns"), "{told}");
}

#[test]
fn a_planted_fault_fails_the_simulation_with_clock_and_port() {
    let folder = TempDir::new().unwrap();
    let design = with_fault(
        folder.path(),
        "result_stream.v",
        "o_valid <= i_counted | blocked;",
        "o_valid <= i_counted | (blocked & ~o_last);",
    );
    // It shows nowhere within these clocks: no scan ends in them.
    let top = design.join("sensor_top.v");
    let output = simulated(&["-y", text(&design), text(&top)]);
    assert!(output.status.success(), "{}", ran(&output));

    let folder = TempDir::new().unwrap();
    let design = with_fault(
        folder.path(),
        "edge_detector.v",
        "last_sample_r <= i_samples[7];",
        "last_sample_r <= 1'b0;",
    );
    let top = design.join("sensor_top.v");
    let output = simulated(&["-y", text(&design), text(&top)]);
    let told = ran(&output);
    assert!(!output.status.success(), "{told}");
    // i_rst is high at clocks 0 to 4. Clock 5's word comes before the first chip's; the
    // step's last one is 2,500 clocks later, and its count shows 6 clocks after that.
    assert!(told.contains("clock 2511 "), "{told}");
    assert!(told.contains("port m_axis_tdata should be 0x"), "{told}");
}

#[test]
fn other_peoples_designs_are_held_to_their_latency() {
    let own = ["-F", "examples/own-rtl/range_top.f", "+define+DESIGN=range_top"];
    let quiet = ["-Wno-lint", "+define+LATENCY=10"];
    let output = simulated(&[&own[..], &quiet[..]].concat());
    let told = ran(&output);
    assert!(output.status.success() && told.contains("match: 20000 clocks"), "{told}");

    // Or to the one that its first result shows, of a scoreboard that is not told it.
    let output = simulated(&[&own[..], &["-Wno-lint", "+define+LATENCY=-2"]].concat());
    let told = ran(&output);
    assert!(output.status.success() && told.contains("match: 20000 clocks"), "{told}");
    assert!(told.contains("results after 10 clocks, 4 later than the emitted design's"), "{told}");

    // Held to the emitted design's it comes four clocks late.
    let output = simulated(&[&own[..], &quiet[..1]].concat());
    let told = ran(&output);
    assert!(!output.status.success(), "{told}");
    assert!(told.contains("clock 2511 ") && told.contains("port m_axis_tdata should be"), "{told}");
}

/// The emitted design in a folder, and what `emit --bind` puts beside it.
fn with_bound_files(folder: &Path, settings: &[Setting]) -> PathBuf {
    let scene = SceneText::read(&root().join("scenes/quick.toml"), settings).unwrap();
    let sensor = Sensor::new(&scene.scene().unwrap());
    let emission = sensor.emit(&EmitOptions::default()).unwrap();
    let design = folder.join("design");
    goldtof::deliver::write(&emission, &design).unwrap();
    for file in bind(&emission, &Prefix::default(), &scene) {
        fs::write(design.join(file.name), file.text).unwrap();
    }
    design
}

/// The same in the testbench, whose own scoreboard is left out.
fn bound(testbench: &str, design: &Path) -> Output {
    let list = text(&design.join("sensor_top.f")).to_owned();
    let [rules, binding] =
        ["axis_rules.sv", "sensor_top_bind.sv"].map(|name| text(&design.join(name)).to_owned());
    let scene = format!("+define+GOLDTOF_SCENE=\"{}\"", text(&design.join("scene.toml")));
    let arguments = [
        "--assert",
        "-Wno-fatal",
        "+define+WITHOUT_SCOREBOARD",
        &scene,
        "-F",
        &list,
        &rules,
        &binding,
    ];
    simulated_with(testbench, &arguments)
}

/// What a testbench says with a fault in a file of the design.
fn bound_with_fault(testbench: &str, design: &Path, [file, sound, faulty]: [&str; 3]) -> String {
    let path = design.join(file);
    let before = fs::read_to_string(&path).unwrap();
    assert_eq!(before.matches(sound).count(), 1, "{file}");
    fs::write(&path, before.replace(sound, faulty)).unwrap();
    let told = ran(&bound(testbench, design));
    fs::write(&path, before).unwrap();
    told
}

#[test]
fn bound_files_hold_a_design_to_the_model_and_its_stream_to_its_rules() {
    const TESTBENCH: &str = "capi/examples/testbench.sv";
    let folder = TempDir::new().unwrap();
    let design = with_bound_files(folder.path(), &[]);
    let told = ran(&bound(TESTBENCH, &design));
    assert!(told.contains("goldtof_scoreboard: match: 20000 clocks compared"), "{told}");

    // An offer that is withdrawn breaks the stream's rules before a batch is compared.
    let withdrawn = ["result_stream.v", "o_valid <= i_counted | blocked;", "o_valid <= i_counted;"];
    let told = bound_with_fault(TESTBENCH, &design, withdrawn);
    assert!(told.contains("m_axis_tvalid fell before m_axis_tready was high"), "{told}");
    // Wrong counts keep the rules, and differ from the model's.
    let told = bound_with_fault(TESTBENCH, &design, EDGES);
    assert!(told.contains("clock 2511 ") && told.contains("port m_axis_tdata should be"), "{told}");
}

/// Hits that go over from word to word count twice.
const EDGES: [&str; 3] =
    ["edge_detector.v", "last_sample_r <= i_samples[7];", "last_sample_r <= 1'b0;"];

/// Scans with a host's settings, of which each begins when it asks: 7 of 5 steps, the first after a reset.
#[test]
fn bound_files_hold_a_design_with_registers_to_the_model_whatever_a_host_sets() {
    const TESTBENCH: &str = "capi/tests/registers.sv";
    let folder = TempDir::new().unwrap();
    let setting = Setting::of("hardware.registers", "axi4-lite", "--set").unwrap();
    let design = with_bound_files(folder.path(), &[setting]);
    let told = ran(&bound(TESTBENCH, &design));
    assert!(told.contains("35 results, 7 scans"), "{told}");
    assert!(told.contains("goldtof_scoreboard: match: "), "{told}");
    assert!(told.contains("spad: 35 results"), "{told}");

    let told = bound_with_fault(TESTBENCH, &design, EDGES);
    assert!(told.contains("mismatch") && told.contains("port m_axis_tdata should be"), "{told}");
    // Scans are counted wrong, which a host alone sees.
    let told = bound_with_fault(
        TESTBENCH,
        &design,
        ["register_file.v", "scans_r + 16'd1", "scans_r + 16'd3"],
    );
    assert!(told.contains("mismatch") && told.contains("port s_axil_rdata should be"), "{told}");
}

#[test]
fn cpp_testbenches_compare_every_port() {
    let folder = TempDir::new().unwrap();
    let library = library();
    let mut verilator = verilator();
    verilator.args(["--cc", "--exe", "--build", "--top", "sensor_top", "-y", DESIGN]);
    verilator.args(["generated/quick/sensor_top.v", "--Mdir", text(folder.path())]);
    let include = root().join("capi/include");
    verilator.args(["-CFLAGS", &format!("-Wall -Wextra -I{}", include.display())]);
    verilator.arg(root().join("capi/examples/testbench.cpp"));
    verilator.arg(library.join("libgoldtof_c.so"));
    verilator.args(["-LDFLAGS", &format!("-Wl,-rpath,{}", library.display())]);
    must_run(&mut verilator);
    let told = must_run(Command::new(folder.path().join("Vsensor_top")).arg("scenes/quick.toml"));
    assert!(told.starts_with("match: 20000 clocks compared"), "{told}");
}
