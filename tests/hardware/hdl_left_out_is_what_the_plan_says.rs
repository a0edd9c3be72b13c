//! Plan, manifest and Verilog agree on what a scene does without.

use crate::hdl_support::draw::{self, Extent};
use goldtof::deliver::Emission;
use goldtof::plan::{Plan, plan};
use goldtof::sensor::Sensor;
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;

/// Whether the plan keeps the part `name` for any source.
fn keeps(plan: &Plan, name: &str) -> bool {
    let is_it = |part: &str| part == name || part.starts_with(&format!("{name} ("));
    let mut parts = plan
        .hardware
        .iter()
        .filter(|part| is_it(&part.part))
        .peekable();
    assert!(parts.peek().is_some(), "no part {name}");
    parts.any(|part| part.kept)
}

/// Each part that leaves a trace in the Verilog, and whether it is there.
fn traces(emission: &Emission) -> [(&'static str, bool); 7] {
    let has_port = |name: &str| emission.ports.iter().any(|port| port.name == name);
    let has_module = |name: &str| {
        let begins = |line: &str| {
            let module = line.strip_prefix("module ").unwrap_or_default();
            module.starts_with(name)
        };
        emission
            .files
            .iter()
            .any(|file| file.text.lines().any(begins))
    };
    let controller = emission
        .files
        .iter()
        .find(|file| file.name == "scan_controller.v");
    let samples = emission
        .ports
        .iter()
        .find(|port| port.name == "i_samples")
        .unwrap();
    [
        ("second_lfsr", has_module("gold_generator")),
        ("interleaver", has_module("interleaver")),
        ("saturation", has_port("o_saturated")),
        ("peak_detector", has_port("o_peak_valid")),
        (
            "scan_realignment",
            controller.unwrap().text.contains("o_start"),
        ),
        (
            "lane_choice",
            samples.width as usize > emission.parameters.detectors,
        ),
        ("parallel_correlators", emission.parameters.parallel > 1),
    ]
}

#[test]
fn in_eighty_random_scenes() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(7);
    let mut seen = [[0_u32; 2]; 7];
    for number in 0..80 {
        let (scene, emission) = draw::emitted(&mut rng, Extent::SHORT, |_| ());
        let plan = plan(&Sensor::new(&scene));
        for (at, (part, is_there)) in traces(&emission).into_iter().enumerate() {
            assert_eq!(keeps(&plan, part), is_there, "scene {number}: {part}");
            seen[at][usize::from(is_there)] += 1;
        }
        // The documents that people get, and not the lists behind them.
        let [plan, manifest] = [serde_json::to_value(&plan), serde_json::to_value(&emission)]
            .map(|document| document.expect("it is JSON"));
        let named = |list: &serde_json::Value| -> Vec<(String, String)> {
            let text = |value: &serde_json::Value| value.as_str().expect("text").to_owned();
            let parts = list.as_array().expect("a list").iter();
            parts
                .filter(|part| part["kept"] != true)
                .map(|part| (text(&part["part"]), text(&part["reason"])))
                .collect()
        };
        assert_eq!(
            named(&manifest["left_out"]),
            named(&plan["hardware"]),
            "scene {number}"
        );
    }
    assert!(
        seen.as_flattened().iter().all(|&times| times > 2),
        "{seen:?}"
    );
}
