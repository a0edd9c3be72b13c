//! Other people's Verilog is judged by the interface, and found as simulators find it.

use std::fs;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

use crate::hdl_support::goldtof;

const QUICK: &str = "scenes/quick.toml";
const EXAMPLE: &str = "examples/own-rtl";
const OWN_LATENCY: u64 = 10;

/// `goldtof cosim` of the quick scene: exit status, JSON, stderr.
fn cosim(arguments: &[&str]) -> (Option<i32>, Value, String) {
    let mut all = vec!["cosim", QUICK, "--json"];
    all.extend(arguments);
    let output = goldtof(&all);
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    let json = serde_json::from_slice(&output.stdout).unwrap_or_default();
    (output.status.code(), json, stderr)
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

fn write(folder: &Path, name: &str, text: &str) {
    let path = folder.join(name);
    fs::create_dir_all(path.parent().unwrap()).unwrap();
    fs::write(path, text).unwrap();
}

/// A copy of the hand-written sensor.
fn copy(to: &Path) {
    let files = [
        "range_top.f",
        "include/sensor_defs.vh",
        "rtl/range_top.v",
        "rtl/code_rom.v",
        "rtl/correlator.v",
        "rtl/stream_port.sv",
    ];
    for file in files {
        write(to, file, &fs::read_to_string(Path::new(EXAMPLE).join(file)).unwrap());
    }
}

fn emitted(folder: &Path) {
    let output = goldtof(&["emit", QUICK, "--quiet", "--out", text(folder)]);
    assert!(output.status.success());
}

#[test]
fn the_hand_written_sensor_matches_with_its_own_latency() {
    let list = format!("{EXAMPLE}/range_top.f");
    for stimulus in ["photons", "adversarial"] {
        let (status, report, stderr) = cosim(&[
            "--filelist",
            &list,
            "--top",
            "range_top",
            "--latency",
            "auto",
            "--stimulus",
            stimulus,
        ]);
        assert_eq!((status, &report["verdict"]), (Some(0), &"match".into()), "{stderr}");
        assert_eq!(report["latency"]["result_clocks"], OWN_LATENCY);
        assert_eq!(report["latency"]["emitted_result_clocks"], 6);
        let remark = report["remarks"][0].as_str().unwrap();
        assert!(remark.starts_with("o_step: an output"), "{remark}");
        if stimulus == "adversarial" {
            let coverage = &report["coverage"];
            assert_eq!(coverage["covered"], coverage["points"]);
        }
    }
}

/// Macros of the command line, and the stages that they give.
#[test]
fn every_latency_is_found_and_the_wrong_one_is_told_by_its_clocks() {
    let folder = tempfile::tempdir().unwrap();
    copy(folder.path());
    write(folder.path(), "bare.f", "+incdir+include rtl/range_top.v -y rtl +libext+.v+.sv");
    let list = folder.path().join("bare.f");
    let asked = |stages: u64, latency: &str| {
        let define = format!("ADDER_STAGES={stages}");
        let all =
            ["--filelist", text(&list), "--top", "range_top", "-D", &define, "--clocks", "9000"];
        cosim(&[&all[..], &["--latency", latency]].concat())
    };
    // Earlier than the emitted design's, by as much, and later.
    for stages in [1, 4, 60] {
        let (status, report, stderr) = asked(stages, "auto");
        assert_eq!(status, Some(0), "{stages}: {stderr}");
        let held = report["latency"]["result_clocks"].as_u64();
        assert_eq!(held, (stages != 4).then_some(stages + 2), "{stages}");
        for wrong in [stages, stages + 5] {
            let (status, report, _) = asked(stages, &wrong.to_string());
            assert_eq!((status, &report["verdict"]), (Some(1), &"mismatch".into()));
            let late = stages as i64 + 2 - wrong as i64;
            let told = report["differences"].as_array().unwrap();
            // A count that stands already, or still, may make up for a late payload.
            assert!(told.iter().any(|d| d["port"] == "m_axis_tvalid"), "{told:?}");
            for difference in told {
                assert_eq!(difference["clocks_late"], late, "{stages} {wrong} {told:?}");
            }
        }
    }
}

#[test]
fn a_late_peak_is_held_to_its_own_latency() {
    const PEAK: &str = "tests/scenes/peak.toml";
    let folder = tempfile::tempdir().unwrap();
    let rtl = folder.path();
    assert!(goldtof(&["emit", PEAK, "--quiet", "--out", text(rtl)]).status.success());
    let manifest: Value =
        serde_json::from_str(&fs::read_to_string(rtl.join("manifest.json")).unwrap()).unwrap();
    let mut ports = Vec::new();
    let mut delayed = Vec::new();
    let mut connected = Vec::new();
    for port in manifest["ports"].as_array().unwrap() {
        let (name, width) = (port["name"].as_str().unwrap(), port["width_bits"].as_u64().unwrap());
        let direction = port["direction"].as_str().unwrap();
        ports.push(format!("{direction} [{}:0] {name}", width - 1));
        if name.starts_with("o_peak") {
            connected.push(format!(".{name}(now_{name})"));
            delayed.push(format!(
                "wire [{0}:0] now_{name}; reg [{0}:0] a_{name}, b_{name}; assign {name} = b_{name};\n\
                 always @(posedge i_clk) begin a_{name} <= i_rst ? 0 : now_{name};\n\
                 b_{name} <= i_rst ? 0 : a_{name}; end\n",
                width - 1
            ));
        } else {
            connected.push(format!(".{name}({name})"));
        }
    }
    let late = format!(
        "module late_top ({});\n{}\nsensor_top inner ({});\nendmodule\n",
        ports.join(", "),
        delayed.concat(),
        connected.join(", ")
    );
    write(rtl, "late_top.v", &late);
    fs::remove_file(rtl.join("manifest.json")).unwrap();
    let run = |latency: &[&str]| {
        let all = ["cosim", PEAK, "--json", "--rtl", text(rtl), "--top", "late_top"];
        let output = goldtof(&[&all[..], latency].concat());
        let report: Value = serde_json::from_slice(&output.stdout).unwrap();
        (output.status.code(), report)
    };
    // Some clocks more than a scan, so that what comes late comes.
    let clocks = run(&[]).1["clocks"].as_u64().unwrap() + 1500;
    let (status, report) = run(&["--clocks", &clocks.to_string()]);
    assert_eq!(status, Some(1));
    let differences = report["differences"].as_array().unwrap();
    assert!(differences.iter().any(|d| d["port"] == "o_peak_valid"));
    for difference in differences {
        assert_eq!(difference["clocks_late"], 2, "{difference}");
    }
    let (status, report) = run(&["--latency", "auto"]);
    assert_eq!(status, Some(0), "{report}");
    let latency = &report["latency"];
    let clocks = |key: &str| latency[key].as_u64().unwrap();
    assert_eq!(clocks("peak_clocks"), clocks("emitted_peak_clocks") + 2);
    assert_eq!(clocks("result_clocks"), clocks("emitted_result_clocks"));
}

/// File of the hand-written sensor, and an edit of it.
const FAULTS: &[(&str, &str, &str)] = &[
    ("include/sensor_defs.vh", "31'b00000000100", "31'b00000000101"),
    ("include/sensor_defs.vh", "2500 ", "2499 "),
    ("rtl/code_rom.v", "chip + 5'd1", "chip + 5'd2"),
    ("rtl/correlator.v", "`SAMPLES - step_ends", "`SAMPLES + step_ends"),
    ("rtl/correlator.v", "forward - PLACES :", "forward - PLACES + 1 :"),
    ("rtl/correlator.v", "level   <= samples[`SAMPLES-1];", "level   <= 0;"),
    ("rtl/correlator.v", "lane >= `SAMPLES ?", "lane > `SAMPLES ?"),
    ("rtl/correlator.v", "sum + 5'sd1 : sum - 5'sd1", "sum + 5'sd1 : sum"),
    ("rtl/correlator.v", "? 16'sd0 : new_total", "? sums[`ADDER_STAGES-1] : new_total"),
    ("rtl/correlator.v", "            total     <= 0;\n", ""),
    ("rtl/correlator.v", "step <= scan_ends ? 0 : step + 1", "step <= step + 1"),
    ("rtl/correlator.v", "sums[stage]  <= 0;", ""),
    ("rtl/stream_port.sv", "if (put && !is_free)", "if (put && tvalid)"),
    ("rtl/stream_port.sv", "!tvalid || tready", "!tvalid"),
    ("rtl/stream_port.sv", "if (is_free) begin", "if (is_free || put) begin"),
    ("rtl/stream_port.sv", "            lost   <= '0;\n", ""),
    ("rtl/range_top.v", "o_epoch <= chip == 0;", "o_epoch <= chip == 1;"),
    ("rtl/range_top.v", ".put_last(done_last)", ".put_last(1'b0)"),
];

#[test]
fn planted_faults_of_the_hand_written_sensor_are_found() {
    for (file, from, to) in FAULTS {
        let folder = tempfile::tempdir().unwrap();
        copy(folder.path());
        let sound = fs::read_to_string(folder.path().join(file)).unwrap();
        assert_eq!(sound.matches(from).count(), 1, "{file}: {from}");
        write(folder.path(), file, &sound.replace(from, to));
        let list = folder.path().join("range_top.f");
        let latency = OWN_LATENCY.to_string();
        let (status, report, stderr) = cosim(&[
            "--filelist",
            text(&list),
            "--top",
            "range_top",
            "--latency",
            &latency,
            "--stimulus",
            "adversarial",
        ]);
        let found = (status, &report["verdict"]);
        assert_eq!(found, (Some(1), &"mismatch".into()), "{from} -> {to}: {stderr}");
    }
}

/// The hand-written sensor in another form, and the options that find it.
fn in_another_form(form: &str, folder: &Path) -> Vec<String> {
    let plain = folder.join("plain");
    copy(&plain);
    let read = |name: &str| fs::read_to_string(plain.join(name)).unwrap();
    let sources = ["rtl/range_top.v", "rtl/code_rom.v", "rtl/correlator.v", "rtl/stream_port.sv"];
    let at = folder.join(form);
    let odd_testbench = "class t extends uvm_test; `uvm_object_utils(t) endclass";
    match form {
        "subfolders with spaces, and a link that leads back" => {
            for name in sources {
                write(&at, &format!("my {name}"), &read(name));
            }
            write(&at, "my headers/sensor_defs.vh", &read("include/sensor_defs.vh"));
            write(&at, "test bench/range_tb.sv", odd_testbench);
            symlink("..", at.join("my rtl/up")).unwrap();
            symlink(".", at.join("here")).unwrap();
        }
        "other names of files" => {
            let all: String = sources[1..].iter().map(|name| read(name)).collect();
            write(&at, "lib_cells.sv", &all);
            write(&at, "main design.v", &read(sources[0]));
            write(&at, "sensor_defs.vh", &read("include/sensor_defs.vh"));
            write(&at, "a_testbench.sv", odd_testbench);
            write(&at, "another.v", "module another; missing u(); endmodule");
        }
        "a package and a macro file" => {
            let top = read(sources[0]).replace("`include \"sensor_defs.vh\"\n", "");
            let top = top.replace("chip == 0;", "chip == zeros_pkg::ZERO;");
            write(&at, "zz_pkg.sv", "package zeros_pkg; localparam ZERO = 0; endpackage");
            write(&at, "range_top.v", &top);
            for name in &sources[1..] {
                write(&at, name, &read(name));
            }
            write(&at, "0_macros.v", &read("include/sensor_defs.vh"));
            write(&at, "rtl/sensor_defs.vh", &read("include/sensor_defs.vh"));
        }
        "a list of lists from elsewhere" => {
            write(&at, "lists/all.f", "-f lists/inner.f -F ../plain/range_top.f // both\n");
            write(&at, "lists/inner.f", "-sverilog +define+UNUSED\n");
            fs::remove_file(plain.join("range_top.f")).unwrap();
            write(
                &plain,
                "range_top.f",
                "+incdir+include -v rtl/code_rom.v -y rtl +libext+.sv+.v\n",
            );
            let copied = "lists/lists/inner.f";
            write(&at, copied, "-sverilog\n");
            let list = at.join("lists/all.f");
            let nested = fs::read_to_string(&list).unwrap().replace("../plain", "../../plain");
            fs::write(&list, nested).unwrap();
            return vec!["--filelist".to_owned(), text(&list).to_owned()];
        }
        other => panic!("{other}"),
    }
    vec!["--rtl".to_owned(), text(&at).to_owned()]
}

#[test]
fn a_design_is_found_in_whatever_form_it_is() {
    for form in [
        "subfolders with spaces, and a link that leads back",
        "other names of files",
        "a package and a macro file",
        "a list of lists from elsewhere",
    ] {
        let folder = tempfile::tempdir().unwrap();
        let options = in_another_form(form, folder.path());
        let mut all: Vec<&str> = options.iter().map(String::as_str).collect();
        all.extend(["--top", "range_top", "--latency", "3", "--clocks", "6000"]);
        let (status, report, stderr) = cosim(&all);
        let found = (status, &report["verdict"]);
        assert_eq!(found, (Some(0), &"match".into()), "{form}: {stderr}");
    }
}

#[test]
fn further_ports_are_remarked_and_others_refused() {
    let folder = tempfile::tempdir().unwrap();
    emitted(folder.path());
    let top = folder.path().join("sensor_top.v");
    let sound = fs::read_to_string(&top).unwrap();
    let with = |ports: &str, lines: &str| {
        let changed =
            sound.replacen("input  wire        i_rst,", &format!("input wire i_rst, {ports}"), 1);
        let at = changed.rfind("endmodule").unwrap();
        fs::write(&top, format!("{}{lines}\n{}", &changed[..at], &changed[at..])).unwrap();
        cosim(&["--clocks", "6000", "--rtl", text(folder.path())])
    };
    let ports = "input wire [69:0] i_spare, output wire \\o+odd , output wire [69:0] o_wide,";
    let (status, report, stderr) = with(ports, "assign o_wide = ~i_spare; assign \\o+odd = 1'b1;");
    assert_eq!(status, Some(0), "{stderr}");
    let remarks = report["remarks"].as_array().unwrap().iter();
    let mut remarks: Vec<&str> = remarks.map(|r| r.as_str().unwrap()).collect();
    remarks.sort_unstable();
    assert_eq!(
        remarks,
        [
            "i_spare: an input that the interface does not have is 0 at every clock",
            "o+odd: an output that the interface does not have is not compared",
            "o_wide: an output that the interface does not have is not compared",
        ]
    );
    // It is 0 indeed.
    let stops = "always @(posedge i_clk) if (i_spare != 0) $fatal(1, \"not 0\");";
    let (status, _, stderr) = with("input wire [69:0] i_spare,", stops);
    assert_eq!(status, Some(0), "{stderr}");
    for (ports, told) in [
        ("inout wire pad,", "port pad (inout of 1 bit(s)) is not one of this scene's ports"),
        ("output wire o_many [1:0],", "port o_many (an array, each an output of 1 bit(s)) is not"),
    ] {
        let (status, _, stderr) = with(ports, "");
        assert_eq!(status, Some(2), "{stderr}");
        assert!(stderr.contains(told), "{stderr}");
    }
}

/// What is done to a copy of the hand-written sensor, the options, and what is told.
type Hostile = (&'static str, fn(&Path), &'static [&'static str], &'static [&'static str]);

const HOSTILE: &[Hostile] = &[
    (
        "a module is missing",
        |at| fs::remove_file(at.join("rtl/correlator.v")).unwrap(),
        &["--rtl", "."],
        &["Cannot find file containing module: 'correlator'", "rtl/range_top.v:"],
    ),
    (
        "an include is missing",
        |at| fs::remove_file(at.join("include/sensor_defs.vh")).unwrap(),
        &["--rtl", "."],
        &["Cannot find include file: sensor_defs.vh", "rtl/range_top.v:2:"],
    ),
    (
        "a syntax error",
        |at| write(at, "rtl/stream_port.sv", "module stream_port(;\nendmodule\n"),
        &["--rtl", "."],
        &["rtl/stream_port.sv:1:", "syntax error"],
    ),
    (
        "two tops",
        |at| {
            write(at, "old/range_top.v", "module range_top; endmodule");
        },
        &["--rtl", "."],
        &["module range_top: it may be ./old/range_top.v or ./rtl/range_top.v"],
    ),
    (
        "two tops in a list",
        |at| {
            write(at, "again.f", "-F range_top.f twice.v");
            write(at, "twice.v", "module range_top; endmodule");
        },
        &["--filelist", "again.f"],
        &["Duplicate declaration of module: 'range_top'", "twice.v:1:"],
    ),
    (
        "two files to include",
        |at| {
            let header = fs::read_to_string(at.join("include/sensor_defs.vh")).unwrap();
            write(at, "rtl/sensor_defs.vh", &header);
        },
        &["--rtl", "."],
        &["`include in ./rtl/", "./include/sensor_defs.vh or ./rtl/sensor_defs.vh"],
    ),
    (
        "no such top",
        |at| fs::remove_file(at.join("rtl/range_top.v")).unwrap(),
        &["--rtl", "."],
        &["no module range_top is in the Verilog to check; --top"],
    ),
    (
        "another width",
        |at| {
            let top = at.join("rtl/range_top.v");
            let text = fs::read_to_string(&top).unwrap();
            fs::write(top, text.replace("[15:0]         m_axis_tdata", "[14:0] m_axis_tdata"))
                .unwrap();
        },
        &["--rtl", "."],
        &[
            "the ports of module range_top do not fit the scene",
            "m_axis_tdata is an output of 15 bit(s); it should be an output of 16 bit(s)",
        ],
    ),
    (
        "a list that names what is not there",
        |at| write(at, "bad.f", "rtl/range_top.v\n  rtl/nothing.v\n"),
        &["--filelist", "bad.f"],
        &["bad.f:2:3: \"rtl/nothing.v\" is neither there from the list's folder"],
    ),
    (
        "a list with an option of another tool",
        |at| write(at, "bad.f", "+acc+rn\n"),
        &["--filelist", "bad.f"],
        &["bad.f:1:1: the option \"+acc+rn\" is not understood"],
    ),
    (
        "a macro that is none",
        |_| (),
        &["--rtl", ".", "-D", "2X=1"],
        &["-D: \"2X=1\" defines no macro"],
    ),
    (
        "a folder that is not there",
        |_| (),
        &["--rtl", ".", "-I", "nowhere"],
        &["nowhere: cannot read it"],
    ),
    (
        "an endless list",
        |at| write(at, "bad.f", "-F bad.f\n"),
        &["--filelist", "bad.f"],
        &["more than 32 lists within each other"],
    ),
];

#[test]
fn what_is_wrong_with_a_design_is_told_with_its_place() {
    let scene = fs::canonicalize(QUICK).unwrap();
    for (case, spoil, options, told) in HOSTILE {
        let folder = tempfile::tempdir().unwrap();
        copy(folder.path());
        spoil(folder.path());
        let output = Command::new(env!("CARGO_BIN_EXE_goldtof"))
            .args(["cosim", text(&scene), "--top", "range_top", "--clocks", "3000"])
            .args(*options)
            .current_dir(folder.path())
            .output()
            .unwrap();
        let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{case}: {stderr}");
        assert!(output.stdout.is_empty(), "{case}");
        for part in *told {
            assert!(stderr.contains(part), "{case}: {part} is not in: {stderr}");
        }
        // Nothing of where the tools were started.
        assert!(!stderr.contains("goldtof-") && !stderr.contains("rtl/0/"), "{case}: {stderr}");
    }
}

#[test]
fn options_of_own_verilog_need_own_verilog() {
    for option in [["--top", "x"], ["-I", "."], ["-D", "X"]] {
        let (status, _, stderr) = cosim(&option);
        assert_eq!(status, Some(2), "{stderr}");
        assert!(stderr.contains("--rtl") || stderr.contains("--filelist"), "{stderr}");
    }
}

/// Idle payload is nobody's business: neither co-simulation's nor the testbench's.
#[test]
fn payload_without_tvalid_may_be_anything() {
    let folder = tempfile::tempdir().unwrap();
    emitted(folder.path());
    let stream = folder.path().join("sensor_top.v");
    let sound = fs::read_to_string(&stream).unwrap();
    let idle = sound.replacen("module sensor_top (", "module inner_top (", 1);
    let wrapped = format!(
        "{idle}\nmodule sensor_top (input i_clk, input i_rst, output o_laser, output o_epoch,\n\
         input [7:0] i_samples, output [15:0] m_axis_tdata, output m_axis_tvalid,\n\
         input m_axis_tready, output m_axis_tlast, output o_overrun);\n\
         wire [15:0] data; wire last;\n\
         reg [15:0] noise; always @(posedge i_clk) noise <= i_rst ? 0 : noise + 16'd4711;\n\
         assign m_axis_tdata = m_axis_tvalid ? data : noise;\n\
         assign m_axis_tlast = m_axis_tvalid ? last : noise[3];\n\
         inner_top inner (i_clk, i_rst, o_laser, o_epoch, i_samples, data, m_axis_tvalid,\n\
         m_axis_tready, last, o_overrun);\nendmodule\n"
    );
    fs::write(&stream, &wrapped).unwrap();
    let (status, _, stderr) = cosim(&["--stimulus", "adversarial", "--rtl", text(folder.path())]);
    assert_eq!(status, Some(0), "{stderr}");
    let built = folder.path().join("testbench.vvp");
    let whole = "-DSENSOR_TOP_TB_WHOLE";
    let iverilog = Command::new("iverilog")
        .args(["-g2012", whole, "-s", "sensor_top_tb", "-f", "sensor_top_tb.f", "-o"])
        .arg(&built)
        .current_dir(folder.path())
        .output()
        .unwrap();
    assert!(iverilog.status.success(), "{}", String::from_utf8_lossy(&iverilog.stderr));
    let run = |built: &PathBuf| {
        let ran = Command::new("vvp").arg(built).current_dir(folder.path()).output().unwrap();
        String::from_utf8_lossy(&ran.stdout).into_owned()
    };
    let said = run(&built);
    assert!(said.contains("PASS"), "{said}");
}

/// A clock that a latch lets through, as clock-gating cells do: it needs the falling edge,
/// which a design of rising edges alone does not.
#[test]
fn a_gated_clock_has_its_falling_edges() {
    let folder = tempfile::tempdir().unwrap();
    emitted(folder.path());
    let top = folder.path().join("sensor_top.v");
    let text_of_top = fs::read_to_string(&top).unwrap();
    let with_latch = |initial: &str| {
        let ports_end = text_of_top.find(");\n").unwrap() + ");\n".len();
        let (ports, rest) = text_of_top.split_at(ports_end);
        let of_instance = |line: &str| match line.trim_start().starts_with(".i_clk ") {
            true => line.replace("(i_clk)", "(gated)") + "\n",
            false => line.to_owned() + "\n",
        };
        let rest: String = rest.lines().map(of_instance).collect();
        assert!(rest.matches("(gated)").count() > 3);
        format!(
            "{ports}    reg awake = 1'b0;\n    reg open = 1'b0;\n    \
             always @(posedge i_clk) awake <= 1'b1;\n    \
             always @* if (!i_clk) open = {initial};\n    \
             wire gated = i_clk & open;\n{rest}"
        )
    };
    // Open from the reset's first clock on, or never.
    for (opened, status) in [("awake | i_rst", 0), ("1'b0", 1)] {
        fs::write(&top, with_latch(opened)).unwrap();
        let (found, report, stderr) =
            cosim(&["--rtl", text(folder.path()), "--engine", "lockstep"]);
        assert_eq!(found, Some(status), "{opened}: {report} {stderr}");
    }
}
