//! What goldtof does with any input at all: it answers or refuses, without a
//! panic, in bounded memory.
//!
//! Each function takes the bytes of one input; `targets/` hands them to
//! libFuzzer, `tests/hostile_input_stays_bounded.rs` to a plain mutator.

use std::path::{Component, Path};

use goldtof::code::{CodeSpec, parse_polynomials, parse_seeds, report as codes_report};
use goldtof::cosim::own::manifest as rtl_manifest;
use goldtof::cosim::ports as rtl_ports;
use goldtof::scene::{Scene, SceneErrors, parse};
use goldtof::sensor::Sensor;
use goldtof::sensor::port::Port;
use goldtof::sensor::port::PortRole;
use goldtof::{deliver, plan, report};

/// One kind of input.
pub struct Target {
    /// Its name, and that of its corpus and its dictionary.
    pub name: &'static str,
    /// What is done with one input.
    pub run: fn(&[u8]),
    /// Most bytes that one input may make it hold at a time.
    pub most_bytes: usize,
}

const MIB: usize = 1 << 20;

/// All kinds of input. The bounds are those of the largest answers: a scene may
/// have 2^25 chips of codes; `codes` prints 2^24 and transforms 2^20.
pub const TARGETS: [Target; 5] = [
    Target { name: "scene", run: scene, most_bytes: 96 * MIB },
    Target { name: "quantity", run: quantity, most_bytes: MIB },
    Target { name: "codes", run: codes, most_bytes: 256 * MIB },
    Target { name: "manifest", run: manifest, most_bytes: MIB },
    Target { name: "ports", run: ports, most_bytes: MIB },
];

/// A scene file on its whole way to Verilog.
pub fn scene(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else {
        return;
    };
    match parse("scenes/x.toml", text) {
        Err(error) => check_refusal(&error, text),
        Ok(scene) => {
            let sensor = Sensor::new(&scene);
            let plan = plan::plan(&sensor);
            assert!(!report::plan::parts(&plan, Some(80)).is_empty());
            if is_quick_to_emit(&scene) {
                match deliver::emit(&sensor, "goldtof emit x.toml") {
                    Ok(emission) => {
                        assert!(emission.files.iter().all(|file| !file.text.is_empty()))
                    }
                    Err(error) => assert!(!error.to_string().is_empty()),
                }
            }
        }
    }
}

/// Larger hardware is emitted too, but not thousands of times.
fn is_quick_to_emit(scene: &Scene) -> bool {
    scene.sources.len() <= 2 && scene.detectors.len() <= 2 && scene.hardware.parallel <= 4
}

/// Every refusal names places that the text has, and fits on a few screens.
fn check_refusal(error: &SceneErrors, text: &str) {
    let SceneErrors::Invalid { errors, .. } = error else {
        panic!("text cannot be unreadable");
    };
    assert!(!errors.is_empty());
    for error in errors {
        assert!(!error.message.is_empty());
        let line = text.split('\n').nth(error.line - 1).expect("a line of the text");
        assert!(error.column <= line.chars().count() + 1);
    }
    assert!(error.to_string().len() < MIB);
}

/// A quantity in the place of each kind of quantity; the first byte chooses.
pub fn quantity(data: &[u8]) {
    let Some((&kind, text)) = data.split_first() else {
        return;
    };
    let Ok(text) = std::str::from_utf8(text) else {
        return;
    };
    let literal = serde_json::Value::from(text).to_string();
    let places = [
        ("chip_period = \"8 ns\"", "chip_period = "),
        ("wavelength = \"783 nm\"", "wavelength = "),
        ("mean_power = \"20 pW\"", "mean_power = "),
        ("dark_count_rate = \"71 kcps\"", "dark_count_rate = "),
        ("distance = \"3.2 m\"", "distance = "),
        ("velocity = \"1 m/s\"", "velocity = "),
        ("integration = \"20 us\"", "integration = "),
    ];
    let (right, key) = places[usize::from(kind) % places.len()];
    let scene_text = QUANTITIES.replace(right, &format!("{key}{literal}"));
    match parse("scenes/x.toml", &scene_text) {
        Err(error) => check_refusal(&error, &scene_text),
        Ok(scene) => {
            let path = &scene.paths[0];
            let read = [
                scene.chip_period_ps,
                scene.sources[0].wavelength_nm,
                scene.sources[0].mean_power_w,
                scene.detectors[0].dark_count_rate_cps,
                path.delay_ps,
                path.delay_rate(),
                scene.scan.requested_integration_ps,
            ];
            assert!(read.iter().all(|value| value.is_finite()), "{read:?}");
            assert!(scene.scan.integration_chips > 0);
        }
    }
}

const QUANTITIES: &str = r#"[clock]
chip_period = "8 ns"

[[source]]
name = "laser"
code = { family = "square" }
wavelength = "783 nm"
mean_power = "20 pW"

[[detector]]
name = "spad"
reference = "laser"
dark_count_rate = "71 kcps"

[[path]]
source = "laser"
detector = "spad"
distance = "3.2 m"
velocity = "1 m/s"

[scan]
integration = "20 us"
"#;

/// The arguments of `goldtof codes`, one per line: family, degree, index,
/// interleaving depth, polynomials, seeds, chips, and anything in an eighth line
/// to allow pairs that are not preferred. Empty ones are not given.
pub fn codes(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else {
        return;
    };
    let mut lines = text.split('\n').map(|line| (!line.is_empty()).then_some(line));
    let mut next = || lines.next().flatten();
    let Ok(family) = next().unwrap_or("gold").parse() else {
        return;
    };
    let mut spec = CodeSpec::new(family);
    spec.degree = next().and_then(|degree| degree.parse().ok());
    spec.index = next().and_then(|index| index.parse().ok());
    spec.interleave = next().and_then(|depth| depth.parse().ok()).unwrap_or(0);
    match next().map(parse_polynomials).transpose() {
        Ok(polynomials) => spec.polynomials = polynomials,
        Err(error) => return assert!(!error.to_string().is_empty()),
    }
    spec.seeds = next().map(parse_seeds);
    spec.chips = next().map(str::to_owned);
    spec.allow_non_preferred = next().map(|_| true);
    match codes_report(&spec) {
        Err(error) => assert!(!error.to_string().is_empty()),
        Ok(report) => {
            assert_eq!(report.chips.len() as u64, report.length_chips);
            let ones = report.chips.bytes().filter(|&chip| chip == b'1').count();
            assert_eq!(ones as u64, report.weight_chips);
            let lags: u64 = report.autocorrelation.counts.iter().sum();
            assert_eq!(lags + 1, report.length_chips);
            assert_eq!(report.autocorrelation.peak as u64, report.length_chips);
            assert!(!report.to_text().is_empty());
        }
    }
}

/// The manifest of a folder of Verilog.
pub fn manifest(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else {
        return;
    };
    match rtl_manifest::file_names(text) {
        Err(reason) => assert!(!reason.is_empty()),
        Ok(named) => {
            for name in &named.files {
                let mut components = Path::new(name).components();
                assert!(matches!(components.next(), Some(Component::Normal(_))), "{name:?}");
                assert!(components.next().is_none(), "{name:?}");
            }
        }
    }
}

/// The C++ header in which Verilator names the ports of somebody's Verilog.
pub fn ports(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else {
        return;
    };
    let found = rtl_ports::verilated_ports(text);
    let wanted: Vec<Port> = found
        .iter()
        .filter_map(|port| {
            let (name, direction) = (port.name.clone(), port.direction?);
            Some(Port { name, direction, ..PortRole::Samples.port(port.width) })
        })
        .collect();
    for difference in rtl_ports::differences(&wanted, &found) {
        assert!(!difference.is_empty());
    }
}
