//! Several sensors in one design: names that do not collide, for Verilog and VHDL.

use goldtof::scene::SourceIndex;
use std::collections::{BTreeMap, HashSet};
use std::fs;
use std::path::Path;
use std::process::Command;

use goldtof::cosim::{StimulusKind, Verdict};
use goldtof::deliver::{Emission, Prefix, emit, emit_prefixed, write};
use goldtof::scene::Scene;
use goldtof::sensor::Sensor;
use goldtof::{CosimOptions, Jobs as _, OwnRtl};
use serde_json::Value;

use crate::hdl_support::{Family, code, random_scene, run, scene, stimulus};

fn plain() -> Scene {
    scene(&[code(Family::Gold(5), 0, 3)], 0, 8, 0, None, 40, None)
}

/// Two detectors, several steps at once, a window, interleaving, a peak detector.
fn rich() -> Scene {
    let codes = [code(Family::Gold(5), 2, 3), code(Family::Gold(5), 2, 5)];
    let mut scene = scene(&codes, 0, 4, 118, Some(22), 375, Some(6));
    let mut other = scene.detectors[0].clone();
    other.name = "other".into();
    other.reference = SourceIndex(1);
    scene.detectors.push(other);
    scene.hardware.parallel = 4;
    scene.hardware.peak_detector = true;
    scene.hardware.total_counts = Some(true);
    scene
}

fn prefixed(scene: &Scene, prefix: &str) -> Emission {
    let prefix: Prefix = prefix.parse().expect("it is a prefix");
    emit_prefixed(&Sensor::new(scene), &prefix, "goldtof emit test.toml")
        .expect("the scene is fine")
}

/// Three sensors in folders of their own: two scenes, and one of them again.
fn three(folder: &Path) -> Vec<(&'static str, Emission)> {
    let emissions = vec![
        ("left_", prefixed(&plain(), "left_")),
        ("right_", prefixed(&rich(), "right_")),
        ("Third", prefixed(&plain(), "Third")),
    ];
    for (prefix, emission) in &emissions {
        write(emission, &folder.join(prefix)).expect("the files can be written");
    }
    emissions
}

/// A top module with an instance of each sensor, all of their ports at its own.
fn one_top(emissions: &[(&str, Emission)]) -> String {
    let mut ports = vec!["    input wire i_clk".to_owned()];
    let mut body = String::new();
    for (prefix, emission) in emissions {
        let mut pins = Vec::new();
        for port in &emission.ports {
            let (name, width) = (&port.name, port.width);
            if name == "i_clk" {
                pins.push(format!(".{name}({name})"));
                continue;
            }
            pins.push(format!(".{name}({prefix}{name})"));
            let direction =
                if name.starts_with("i_") || name == "m_axis_tready" { "input" } else { "output" };
            let range = if width > 1 { format!("[{}:0] ", width - 1) } else { String::new() };
            ports.push(format!("    {direction} wire {range}{prefix}{name}"));
        }
        body += &format!("    {prefix}sensor_top {prefix}sensor ({});\n", pins.join(", "));
    }
    format!(
        "`default_nettype none\nmodule three (\n{}\n);\n{body}endmodule\n`default_nettype wire\n",
        ports.join(",\n")
    )
}

#[test]
fn three_sensors_are_one_design_for_verilator_icarus_and_yosys() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let emissions = three(folder.path());
    fs::write(folder.path().join("three.v"), one_top(&emissions)).expect("it can be written");
    let of = |(prefix, emission): &(&str, Emission)| -> Vec<String> {
        let files = emission.files.iter();
        files.map(|file| format!("{prefix}/{}", file.name)).collect()
    };
    let mut files: Vec<String> = emissions.iter().flat_map(of).collect();
    files.push("three.v".to_owned());
    let names: Vec<&str> = files.iter().map(String::as_str).collect();

    let lint = ["--lint-only", "-Wall", "-Wno-DECLFILENAME", "--top-module", "three"];
    let said = run(folder.path(), "verilator", &[&lint[..], &names].concat());
    assert_eq!(said, "");
    let elaborate = ["-g2005", "-Wall", "-s", "three", "-o", "three.vvp"];
    let said = run(folder.path(), "iverilog", &[&elaborate[..], &names].concat());
    assert_eq!(said, "");
    let script = format!(
        "read_verilog {}; hierarchy -check -top three; proc; check -assert",
        names.join(" ")
    );
    assert_eq!(run(folder.path(), "yosys", &["-q", "-p", &script]), "");

    // The check can fail: without prefixes the tools see modules twice.
    let twice =
        [["read_verilog left_/left_sensor_top.v"; 2].join("; "), "hierarchy".into()].join("; ");
    let yosys = Command::new("yosys")
        .args(["-q", "-p", &twice])
        .current_dir(folder.path())
        .output()
        .expect("yosys is there");
    assert!(!yosys.status.success());
}

#[test]
fn the_testbench_and_the_header_of_each_have_its_names() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for (prefix, emission) in three(folder.path()) {
        let folder = folder.path().join(prefix);
        let top = format!("{prefix}sensor_top_tb");
        assert_eq!(emission.flow.testbench.top, top);
        let list = format!("{top}.f");
        let arguments = ["-g2005", "-s", &top, "-o", "tb.vvp", "-f", &list];
        run(&folder, "iverilog", &arguments);
        assert!(run(&folder, "vvp", &["tb.vvp"]).contains("PASS"), "{prefix}");

        let header = fs::read_to_string(folder.join(format!("{prefix}sensor_top.vh")));
        let capitals = prefix.to_uppercase();
        let width = format!("`define {capitals}SENSOR_TOP_I_SAMPLES_BITS ");
        assert!(header.expect("it is there").contains(&width));
        for file in emission.flow.files().chain(emission.formal.files()) {
            // Of a module or a macro that has another name here nobody speaks.
            for bare in [" sensor_top", " SENSOR_TOP", "`SENSOR_TOP", " prove_", "(sensor_top"] {
                assert!(!file.text.contains(bare), "{}: {bare}", file.name);
            }
        }
    }
}

/// Two designs have no module in common when their prefixes differ, because no
/// module's name is the end of another's.
#[test]
fn no_name_of_a_module_is_the_end_of_another() {
    let mut names = HashSet::new();
    let mut noise = stimulus::Noise::new(7);
    let random = (0..40).map(|case| random_scene(&mut noise, case));
    for scene in random.chain([plain(), rich()]) {
        let emission = emit(&Sensor::new(&scene), "a test").expect("the scene is fine");
        let files = emission.files.into_iter();
        names.extend(files.map(|file| file.name.trim_end_matches(".v").to_owned()));
    }
    assert!(names.len() > 20, "{names:?}");
    for one in &names {
        for other in names.iter().filter(|other| *other != one) {
            assert!(!one.ends_with(other.as_str()), "{one} ends with {other}");
        }
    }
}

#[test]
fn another_prefix_takes_the_place_of_the_first_in_a_folder() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let folder = folder.path();
    write(&prefixed(&rich(), "left_"), folder).expect("the files can be written");
    fs::write(folder.join("left_mine.v"), "// the user's own\n").expect("written");
    let second = prefixed(&plain(), "right_");
    write(&second, folder).expect("the files can be written");
    let listed = |folder: &Path| -> HashSet<String> {
        fs::read_dir(folder)
            .expect("the folder is there")
            .map(|entry| entry.expect("readable").file_name().into_string().expect("plain"))
            .collect()
    };
    let expected = second.files.iter().chain(second.flow.files());
    let mut expected: HashSet<String> = expected.map(|file| file.name.clone()).collect();
    expected.extend(["formal", "manifest.json", "left_mine.v"].map(str::to_owned));
    assert_eq!(listed(folder), expected);
    let proofs = second.formal.files().map(|file| file.name.clone());
    assert_eq!(listed(&folder.join("formal")), proofs.collect());
}

#[test]
fn a_prefixed_folder_is_co_simulated_by_its_manifest() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let folder = folder.path();
    write(&prefixed(&rich(), "right_"), folder).expect("the files can be written");
    let options =
        |own| CosimOptions { own, stimulus: StimulusKind::Adversarial, ..Default::default() };
    let of_folder = || {
        let options = options(OwnRtl::folder(folder));
        Sensor::new(&rich()).cosim(&options).expect("it can be run").report
    };
    let found = of_folder();
    assert_eq!(found.verdict, Verdict::Match);
    // The scan's counters were found under their names: the same is covered as of the
    // design without a prefix, in as many clocks.
    let bare = Sensor::new(&rich()).cosim(&options(OwnRtl::default())).expect("it can be run");
    assert_eq!(found.clocks, bare.report.clocks);
    assert_eq!(found.coverage, bare.report.coverage);

    let path = folder.join("right_sensor_top.v");
    let top = fs::read_to_string(&path).expect("the top is there");
    let faulty = top.replace("o_laser <= chips", "o_laser <= ~chips");
    assert_ne!(faulty, top);
    fs::write(&path, faulty).expect("the top can be written");
    assert_eq!(of_folder().verdict, Verdict::Mismatch);
}

/// The ports of a module as Yosys reads them: name, whether it is an input, and bits.
fn ports_in_yosys(folder: &Path, top: &str) -> BTreeMap<String, (bool, usize)> {
    let script = format!("read_verilog {top}.v; proc; write_json ports.json");
    run(folder, "yosys", &["-q", "-p", &script]);
    let text = fs::read_to_string(folder.join("ports.json")).expect("Yosys wrote it");
    let netlist: Value = serde_json::from_str(&text).expect("it is JSON");
    let ports = netlist["modules"][top]["ports"].as_object().expect("the module has ports");
    let port = |(name, port): (&String, &Value)| {
        let bits = port["bits"].as_array().expect("a port has bits").len();
        (name.clone(), (port["direction"] == "input", bits))
    };
    ports.iter().map(port).collect()
}

/// A VHDL entity with an instance of each sensor, whose signals have the widths that
/// Yosys reads, and one more bit at `widened`.
fn entity(folder: &Path, emissions: &[(&str, Emission)], widened: &str) -> String {
    let mut uses = String::new();
    let mut signals = String::new();
    let mut instances = String::new();
    for (prefix, _) in emissions {
        let top = format!("{prefix}sensor_top");
        uses += &format!("use work.{top}_pkg.all;\n");
        let mut pins = Vec::new();
        for (name, (_, bits)) in ports_in_yosys(&folder.join(prefix), &top) {
            let signal = format!("{prefix}{name}");
            let bits = bits + usize::from(signal == widened);
            let subtype = match bits {
                1 => "std_logic".to_owned(),
                _ => format!("std_logic_vector({} downto 0)", bits - 1),
            };
            signals += &format!("    signal {signal} : {subtype};\n");
            pins.push(format!("{name} => {signal}"));
        }
        instances += &format!("    {prefix}u : {top} port map ({});\n", pins.join(", "));
    }
    format!(
        "library ieee;\nuse ieee.std_logic_1164.all;\n{uses}entity three is end entity;\n\
         architecture test of three is\n{signals}begin\n{instances}end architecture;\n"
    )
}

/// Whether GHDL analyses and elaborates the entity, and what it says.
fn in_ghdl(folder: &Path, emissions: &[(&str, Emission)], widened: &str) -> Result<(), String> {
    fs::write(folder.join("three.vhd"), entity(folder, emissions, widened)).expect("written");
    let packages = emissions.iter().map(|(prefix, _)| format!("{prefix}/{prefix}sensor_top.vhd"));
    let files: Vec<String> = packages.chain(["three.vhd".to_owned()]).collect();
    let ghdl = |arguments: &[&str]| {
        let output = Command::new("ghdl").args(arguments).current_dir(folder).output();
        let output = output.unwrap_or_else(|error| panic!("scripts/test installs ghdl: {error}"));
        let said =
            String::from_utf8_lossy(&output.stderr) + String::from_utf8_lossy(&output.stdout);
        output.status.success().then_some(()).ok_or(said.into_owned())
    };
    let files = files.iter().map(String::as_str);
    ghdl(&Vec::from_iter(["-a", "--std=93"].into_iter().chain(files)))?;
    // The widths at the two ends of each port are compared when the design starts.
    ghdl(&["--elab-run", "--std=93", "three", "--stop-time=1ns"])
}

#[test]
fn vhdl_instantiates_the_sensors_with_the_widths_of_the_verilog() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let emissions = three(folder.path());
    in_ghdl(folder.path(), &emissions, "").expect("the packages fit the Verilog");
    // The check can fail: every port that is a vector, a bit wider.
    let mut vectors = 0;
    for (prefix, _) in &emissions {
        let top = format!("{prefix}sensor_top");
        for (name, (_, bits)) in ports_in_yosys(&folder.path().join(prefix), &top) {
            if bits > 1 {
                vectors += 1;
                in_ghdl(folder.path(), &emissions, &format!("{prefix}{name}"))
                    .expect_err(&format!("{prefix}{name} is a bit wider"));
            }
        }
    }
    assert!(vectors >= 8, "{vectors}");
}
