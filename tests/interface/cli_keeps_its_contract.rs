//! The program as a script sees it: exit codes, JSON, files, messages.

use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::program::{QUICK, command, goldtof, json, said};

/// Emits the quick scene into a folder.
fn emit(folder: &Path) {
    json(&["emit", QUICK, "--json", "--out", folder.to_str().unwrap()]);
}

#[test]
fn run_does_the_whole_way_and_says_so_in_json() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("new/quick");
    let report = json(&["run", QUICK, "--json", "--out", out.to_str().unwrap()]);
    assert_eq!(report["cosim"]["verdict"], "match");
    assert_eq!(report["cosim"]["phase_steps"], 248);
    assert_eq!(report["cosim"]["mismatches"], 0);
    assert!(report["plan"]["hardware"].as_array().unwrap().len() > 5);
    assert_eq!(report["emit"]["top"], "sensor_top");
    let estimate = &report["estimates"][0];
    let deviation = estimate["deviation_in_std"].as_f64().unwrap();
    assert!(deviation.abs() < 5.0, "{estimate}");
    let page = fs::read_to_string(out.join("report.html")).unwrap();
    for part in ["match", "<svg", "Cramer-Rao bound", "edge_detector"] {
        assert!(page.contains(part), "{part}");
    }
    let counts = fs::read_to_string(out.join("counts.csv")).unwrap();
    assert_eq!(counts.lines().count(), 1 + 248);
    assert!(out.join("rtl/sensor_top.v").exists());
}

#[test]
fn a_run_with_the_model_estimator_fits_totals_that_the_verilog_sends() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let report = json(&["run", QUICK, "--estimator", "model", "--json", "--out", out]);
    assert_eq!(report["cosim"]["verdict"], "match");
    let total = &report["emit"]["parameters"]["total_count"];
    let signed_bits = most_hits_bits(&report) + 1;
    assert_eq!(total["first_bit"], signed_bits.div_ceil(8) * 8, "{total}");
    assert_eq!(total["bits"], most_hits_bits(&report), "{total}");
    let estimate = &report["estimates"][0];
    assert_eq!(estimate["estimator"], "model");
    assert!(estimate["distance_m"].is_number(), "{estimate}");
    assert!(estimate["remark"].is_null(), "{estimate}");
    // The phase of the same counts, with the walk that the fit does not have.
    let phase = &report["other_estimates"][0];
    assert_eq!(phase["estimator"], "fft");
    assert!(phase["expected_bias_m"].as_f64().unwrap() < -0.02, "{phase}");
    // The corner at the phase step nearby: 0.16 mm, a sixtieth of the scatter.
    assert!(estimate["expected_bias_m"].as_f64().unwrap().abs() < 0.3e-3);
    assert_eq!(phase["bound_m"], estimate["bound_m"]);
    let counts = fs::read_to_string(folder.path().join("counts.csv")).unwrap();
    let mut lines = counts.lines();
    let heading = "measurement,phase_step,distance_m,count,detector,total_count";
    assert_eq!(lines.next(), Some(heading));
    let mut hits = 0;
    for line in lines {
        let fields: Vec<&str> = line.split(',').collect();
        let (count, total): (i64, i64) = (fields[3].parse().unwrap(), fields[5].parse().unwrap());
        // Hits up less hits down, and both together.
        assert!(total >= count.abs() && (total - count) % 2 == 0, "{line}");
        hits += total;
    }
    assert!(hits > 0);
}

/// Bits of the most hits that a phase step of a run can have, S / 2 in each chip.
fn most_hits_bits(report: &Value) -> u64 {
    let parameter = |name: &str| report["emit"]["parameters"][name].as_u64().unwrap();
    let most = parameter("integration_chips") * parameter("samples_per_chip") / 2;
    u64::from(u64::BITS - most.leading_zeros())
}

#[test]
fn the_phase_estimator_has_no_totals_and_the_model_estimator_does_not_go_without() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let out = out.to_str().unwrap();
    let emission = json(&["emit", QUICK, "--json", "--out", out]);
    assert!(emission["parameters"]["total_count"].is_null());
    let scene = folder.path().join("without.toml");
    let text = fs::read_to_string(QUICK).unwrap();
    fs::write(&scene, format!("{text}\n[hardware]\ntotal_counts = false\n")).unwrap();
    let scene = scene.to_str().unwrap();
    for command in [
        vec!["run", scene, "--estimator", "model", "--out", out],
        vec!["simulate", scene, "--estimator", "model"],
    ] {
        let output = goldtof(&command);
        assert_eq!(output.status.code(), Some(2), "{command:?}");
        assert!(said(&output).contains("total_counts = false"), "{command:?}");
    }
}

#[test]
fn a_run_prints_both_estimators_and_what_the_hardware_does_not_send() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let text = |more: &[&str]| {
        let output = goldtof(&[&["run", QUICK, "--out", out], more].concat());
        assert_eq!(output.status.code(), Some(0), "{}", said(&output));
        String::from_utf8(output.stdout).unwrap()
    };
    let row = |text: &str, name: &str| {
        let mut lines = text.lines().map(str::trim_start);
        let row = lines.find(|line| line.starts_with(name));
        row.unwrap_or_else(|| panic!("no {name}: {text}")).to_owned()
    };
    let signed = text(&[]);
    let both = text(&["--estimator", "model"]);
    // The same light gives the same signed counts, and so the same phase.
    assert_eq!(row(&signed, "phase (article) "), row(&both, "phase (article) "));
    // Signed counts alone are fitted with the scene's light, and that is said.
    for text in [&signed, &both] {
        let fitted = row(text, "model fit  ");
        let in_std = fitted.strip_suffix(" std").and_then(|row| row.split(' ').next_back());
        let in_std: f64 = in_std.and_then(|number| number.parse().ok()).expect(&fitted);
        assert!(in_std.abs() < 4.0, "{fitted}");
    }
    assert!(signed.contains("total_counts = true"), "{signed}");
    assert!(!both.contains("total_counts"), "{both}");
}

#[test]
fn a_degree_that_is_suggested_leads_to_hardware() {
    let folder = tempfile::tempdir().unwrap();
    let emit = |degree: &str| {
        let scene = folder.path().join(format!("{degree}.toml"));
        let text = fs::read_to_string(QUICK).unwrap();
        let text = text.replace("degree = 5", &format!("degree = {degree}"));
        let text = text.replace("steps = \"all\"", "steps = { first = 0, count = 8 }");
        fs::write(&scene, text).unwrap();
        let out = folder.path().join("out");
        goldtof(&["emit", scene.to_str().unwrap(), "--out", out.to_str().unwrap()])
    };
    for degree in ["4", "8", "12", "16", "20"] {
        let output = emit(degree);
        assert_eq!(output.status.code(), Some(2), "{degree}");
        let told = said(&output);
        let advice = told.split("use degree ").nth(1).unwrap_or_else(|| panic!("{told}"));
        let suggested = advice.split([' ', ',']).next().unwrap();
        let output = emit(suggested);
        assert_eq!(output.status.code(), Some(0), "{suggested}: {}", said(&output));
        let alone = advice.contains("in simulation alone");
        assert_eq!(alone, degree.parse::<u32>().unwrap() + 1 > 16, "{told}");
    }
}

#[test]
fn a_path_beyond_the_range_is_told_first() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("far.toml");
    let text = fs::read_to_string(QUICK).unwrap();
    fs::write(&scene, text.replace("3.2 m", "500 m")).unwrap();
    let (scene, out) = (scene.to_str().unwrap(), folder.path().join("out"));
    let out = out.to_str().unwrap();
    for command in [
        vec!["plan", scene],
        vec!["run", scene, "--out", out],
        vec!["simulate", scene, "--fidelity", "expected"],
    ] {
        let output = goldtof(&command);
        let told = said(&output);
        let first = told.lines().next().unwrap_or_default();
        assert!(first.contains("500.0000 m are beyond"), "{command:?}: {told}");
        // 511 chips of 8 ns are 612.8 m, 255 are 305.8 m and no Gold code's.
        assert!(first.contains("degree 9 "), "{first}");
        if command[0] == "run" {
            let text = String::from_utf8(output.stdout).unwrap();
            assert_eq!(text.matches("500.0000 m").count(), 1, "{text}");
        }
    }
}

#[test]
fn a_run_shows_every_detector() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("two.toml");
    let text = fs::read_to_string(QUICK).unwrap();
    let start = text.find("[[detector]]").unwrap();
    let end = text.find("[scan]").unwrap();
    let second = text[start..end].replace("\"spad\"", "\"second\"");
    fs::write(&scene, format!("{text}\n{second}")).unwrap();
    let out = folder.path().join("out");
    let report = json(&["run", scene.to_str().unwrap(), "--json", "--out", out.to_str().unwrap()]);
    assert_eq!(report["cosim"]["verdict"], "match");
    let counts = fs::read_to_string(out.join("counts.csv")).unwrap();
    for name in ["spad", "second"] {
        let of_detector: Vec<i64> = counts
            .lines()
            .filter(|line| line.ends_with(&format!(",{name}")))
            .map(|line| line.split(',').nth(3).unwrap().parse().unwrap())
            .collect();
        assert_eq!(of_detector.len(), 248, "{name}");
        // Its counts, and not the other one's: the largest is where it says.
        let estimates = report["estimates"].as_array().unwrap();
        let estimate = estimates.iter().find(|e| e["detector"] == name).unwrap();
        let coarse = estimate["coarse_phase_step"].as_u64().unwrap() as usize;
        assert_eq!(of_detector.iter().max(), Some(&of_detector[coarse]));
    }
    let page = fs::read_to_string(out.join("report.html")).unwrap();
    for name in ["spad", "second"] {
        assert!(page.contains(&format!("Counts of {name}, round the peak")), "{name}");
    }
}

#[test]
fn the_same_seed_gives_the_same_bytes_and_another_seed_others() {
    let folder = tempfile::tempdir().unwrap();
    let counts = |seed: &str, name: &str| {
        let out = folder.path().join(name);
        json(&["run", QUICK, "--json", "--seed", seed, "--out", out.to_str().unwrap()]);
        fs::read(out.join("counts.csv")).unwrap()
    };
    assert_eq!(counts("7", "a"), counts("7", "b"));
    assert_ne!(counts("7", "c"), counts("8", "d"));
}

#[test]
fn emit_names_ports_clock_and_what_it_left_out() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let emission = json(&["emit", QUICK, "--json", "--out", out]);
    assert_eq!(emission["clock_hz"], 125e6);
    assert_eq!(emission["ports"][0]["name"], "i_clk");
    assert_eq!(emission["ports"][0]["direction"], "input");
    assert_eq!(emission["ports"][0]["width_bits"], 1);
    assert!(!emission["left_out"].as_array().unwrap().is_empty());
    for file in emission["files"].as_array().unwrap() {
        assert!(folder.path().join(file.as_str().unwrap()).exists(), "{file}");
    }
    let manifest = fs::read_to_string(folder.path().join("manifest.json")).unwrap();
    assert_eq!(serde_json::from_str::<Value>(&manifest).unwrap(), emission);
}

#[test]
fn the_command_in_emitted_files_is_one_that_a_shell_takes() {
    let folder = tempfile::tempdir().unwrap();
    let [scene, out] = ["it's quick; rm x.toml", "out"].map(|name| folder.path().join(name));
    fs::copy(QUICK, &scene).unwrap();
    let (scene, out) = (scene.to_str().unwrap(), out.to_str().unwrap());
    json(&["emit", scene, "--json", "--out", out, "--set", "path.distance=4 m"]);
    let manifest = fs::read_to_string(format!("{out}/manifest.json")).unwrap();
    let manifest: Value = serde_json::from_str(&manifest).unwrap();
    let command = manifest["command"].as_str().unwrap();
    // A shell says which words it reads.
    let words = format!("goldtof() {{ printf '%s\\n' \"$@\"; }}; {command}");
    let said = std::process::Command::new("sh").args(["-c", &words]).output().unwrap();
    let said = String::from_utf8(said.stdout).unwrap();
    let words: Vec<&str> = said.lines().collect();
    assert_eq!(words, ["emit", "it's quick; rm x.toml", "--set", "path.distance=4 m"]);
}

#[test]
fn codes_gives_the_first_chips_of_gps_satellite_1() {
    let report = json(&[
        "codes",
        "--degree",
        "10",
        "--polynomials",
        "10,3,0;10,9,8,6,3,2,0",
        "--index",
        "1018",
        "--json",
    ]);
    // Octal 1440, as the interface specification prints it.
    assert!(report["chips"].as_str().unwrap().starts_with("1100100000"));
    assert_eq!(report["length_chips"], 1023);
    assert_eq!(report["autocorrelation"]["peak"], 1023);
    assert_eq!(report["autocorrelation"]["values"], serde_json::json!([-65, -1, 63]));
}

#[test]
fn a_negative_index_of_a_gold_set_can_be_written_as_it_is() {
    let report = json(&["codes", "--degree", "5", "--index", "-2", "--json"]);
    assert_eq!(report["autocorrelation"]["values"], serde_json::json!([-1]));
}

#[test]
fn a_scene_that_is_wrong_ends_with_2_and_names_its_place() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("wrong.toml");
    let text = fs::read_to_string(QUICK).unwrap();
    fs::write(&path, text.replace("\"8 ns\"", "8")).unwrap();
    let output = goldtof(&["plan", path.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(2));
    assert!(output.stdout.is_empty());
    assert!(said(&output).contains("wrong.toml:5:15: "), "{}", said(&output));
}

#[test]
fn usage_errors_end_with_2_and_help_with_0() {
    assert_eq!(goldtof(&["emit", QUICK]).status.code(), Some(2));
    assert_eq!(goldtof(&["polish", QUICK]).status.code(), Some(2));
    assert_eq!(goldtof(&["--help"]).status.code(), Some(0));
    assert_eq!(goldtof(&["cosim", "--help"]).status.code(), Some(0));
}

#[test]
fn a_missing_tool_ends_with_3_and_says_how_to_install_it() {
    for (variable, package) in [("VERILATOR", "verilator"), ("CXX", "g++")] {
        let output =
            command(&["cosim", QUICK]).env(variable, "/nonexistent/tool").output().unwrap();
        assert_eq!(output.status.code(), Some(3));
        let message = format!("apt-get install {package}");
        assert!(said(&output).contains(&message), "{}", said(&output));
    }
}

#[test]
fn rtl_that_does_not_compile_is_bad_input_and_ends_with_2() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("sensor_top.v"), "module sensor_top (\n").unwrap();
    let output = goldtof(&["cosim", QUICK, "--rtl", folder.path().to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(2));
    assert!(said(&output).contains("syntax error"), "{}", said(&output));
}

#[test]
fn rtl_with_other_ports_is_refused_port_by_port() {
    let folder = tempfile::tempdir().unwrap();
    emit(folder.path());
    let path = folder.path().join("sensor_top.v");
    let text = fs::read_to_string(&path).unwrap();
    let wider = text.replace("output wire        o_overrun", "output wire [1:0]  o_overrun");
    assert_ne!(wider, text);
    fs::write(&path, wider).unwrap();
    let output = goldtof(&["cosim", QUICK, "--rtl", folder.path().to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(2));
    let message = "port o_overrun is an output of 2 bit(s); it should be an output of 1 bit(s)";
    assert!(said(&output).contains(message), "{}", said(&output));
}

#[test]
fn of_a_folder_without_a_manifest_the_bench_is_left_out() {
    let folder = tempfile::tempdir().unwrap();
    emit(folder.path());
    fs::remove_file(folder.path().join("manifest.json")).unwrap();
    let stranger = "module stranger; initial $finish; not_to_be_found u(); endmodule\n";
    fs::write(folder.path().join("stranger.v"), stranger).unwrap();
    assert!(folder.path().join("sensor_top_tb.v").exists());
    let rtl = folder.path().to_str().unwrap();
    let report = json(&["cosim", QUICK, "--json", "--clocks", "5000", "--rtl", rtl]);
    assert_eq!(report["verdict"], "match");
}

#[test]
fn light_without_its_code_gives_no_estimate() {
    let folder = tempfile::tempdir().unwrap();
    let flat = folder.path().join("flat.toml");
    let text = fs::read_to_string(QUICK).unwrap();
    let unmodulated = text.replace("extinction_ratio = 10", "extinction_ratio = 1");
    assert_ne!(unmodulated, text);
    fs::write(&flat, unmodulated).unwrap();
    let flat = flat.to_str().unwrap();
    let says_why = |estimate: &Value| {
        let remark = estimate["remark"].as_str().unwrap();
        assert!(remark.contains("no light that its source modulates"), "{remark}");
    };
    let simulated = &json(&["simulate", flat, "--json", "--repeat", "5"])["estimates"][0];
    for key in ["mean_distance_m", "bias_m", "std_m", "expected_bias_m", "bound_m"] {
        assert!(simulated[key].is_null(), "{key}: {simulated}");
    }
    assert_eq!(simulated["estimates"], 0);
    says_why(simulated);

    let out = folder.path().join("out");
    let run = &json(&["run", flat, "--json", "--out", out.to_str().unwrap()])["estimates"][0];
    for key in ["distance_m", "error_m", "expected_bias_m"] {
        assert!(run[key].is_null(), "{key}: {run}");
    }
    says_why(run);

    let compared = goldtof(&["fidelity", flat, "--budget-s", "1"]);
    assert_eq!(compared.status.code(), Some(2));
    assert!(said(&compared).contains("no light that its source modulates"));
}

#[test]
fn a_folder_without_verilog_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let output = goldtof(&["cosim", QUICK, "--rtl", folder.path().to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(2));
    assert!(said(&output).contains("holds no .v or .sv file"));
}

#[test]
fn verilog_that_ends_its_own_simulation_ends_with_1() {
    let folder = tempfile::tempdir().unwrap();
    emit(folder.path());
    let path = folder.path().join("sensor_top.v");
    let text = fs::read_to_string(&path).unwrap();
    let halting = text.replace("endmodule", "always @(posedge o_epoch) $finish;\nendmodule");
    fs::write(&path, halting).unwrap();
    let output = goldtof(&["cosim", QUICK, "--rtl", folder.path().to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(1), "{}", said(&output));
    assert!(said(&output).contains("$finish at"), "{}", said(&output));
}

#[test]
fn a_mismatch_ends_with_1_and_leaves_waveforms_of_both_sides() {
    let folder = tempfile::tempdir().unwrap();
    emit(folder.path());
    let path = folder.path().join("sensor_top.v");
    let text = fs::read_to_string(&path).unwrap();
    fs::write(&path, text.replace("o_laser <= transmit_chip", "o_laser <= ~transmit_chip"))
        .unwrap();
    let vcd = folder.path().join("mismatch.vcd");
    let output = goldtof(&[
        "cosim",
        QUICK,
        "--json",
        "--rtl",
        folder.path().to_str().unwrap(),
        "--vcd",
        vcd.to_str().unwrap(),
    ]);
    assert_eq!(output.status.code(), Some(1));
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    let first = &report["first_mismatch"];
    // The first clock after four clocks of reset shows the first chip.
    assert_eq!(first["clock"], 4);
    assert_eq!(first["time_ps"], 32_000.0);
    assert_eq!(first["port"], "o_laser");
    let mut parser = vcd::Parser::new(std::io::BufReader::new(fs::File::open(vcd).unwrap()));
    let header = parser.parse_header().unwrap();
    for side in ["model", "dut"] {
        let laser = header.find_var(&["cosim", side, "o_laser"]).unwrap().code;
        assert!(parser_has_changes(&mut parser, laser), "{side}");
    }
}

/// Whether the next changes of a waveform hold one of this signal.
fn parser_has_changes(
    parser: &mut vcd::Parser<std::io::BufReader<fs::File>>,
    code: vcd::IdCode,
) -> bool {
    parser.any(
        |command| matches!(command, Ok(vcd::Command::ChangeScalar(changed, _)) if changed == code),
    )
}

#[test]
fn an_output_folder_that_cannot_be_made_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    fs::write(&file, "").unwrap();
    let out = file.join("out");
    for command in ["emit", "run"] {
        let output = goldtof(&[command, QUICK, "--out", out.to_str().unwrap()]);
        assert_eq!(output.status.code(), Some(2));
        assert!(said(&output).contains("file/out"), "{}", said(&output));
    }
}

#[test]
fn a_run_needs_no_folder_and_a_saturated_detector_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let run = |arguments: &[&str]| {
        let output = command(arguments).current_dir(folder.path()).output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{}", said(&output));
        said(&output)
    };
    let quick = fs::canonicalize(QUICK).unwrap();
    let quick = quick.to_str().unwrap();
    assert!(!run(&["run", quick]).contains("saturates"));
    assert!(folder.path().join("out/quick/report.html").exists());
    // 20 pW fire it 2.444e7 times a second, 0.342 times in 14 ns: half ready at 2.92 times as much.
    let told = run(&["plan", quick, "--set", "source[laser].mean_power=4 mW"]);
    assert!(told.contains("spad saturates"), "{told}");
    assert!(told.contains("source[laser].mean_power = \"5.8e-11 W\""), "{told}");
}
