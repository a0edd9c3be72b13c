//! Plan, manifest and Verilog agree on what a scene does without.

use std::collections::BTreeMap;

use crate::hdl_support::draw::{self, Extent};
use goldtof::deliver::Emission;
use goldtof::plan::{Plan, plan};
use goldtof::sensor::Sensor;
use optics_support::repeated;
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;

/// Whether the plan keeps the part `name` for any source.
fn keeps(plan: &Plan, name: &str) -> bool {
    let is_it = |part: &str| part == name || part.starts_with(&format!("{name} ("));
    let mut parts = plan.hardware.iter().filter(|part| is_it(&part.part)).peekable();
    assert!(parts.peek().is_some(), "no part {name}");
    parts.any(|part| part.kept)
}

/// Each part that leaves a trace in the Verilog, and whether it is there.
fn traces(emission: &Emission) -> Vec<(&'static str, bool)> {
    let has_port = |name: &str| emission.ports.iter().any(|port| port.name == name);
    let has_module = |name: &str| {
        let begins = |line: &str| {
            let module = line.strip_prefix("module ").unwrap_or_default();
            module.starts_with(name)
        };
        emission.files.iter().any(|file| file.text.lines().any(begins))
    };
    let text_of = |name: &str| {
        let mut files = emission.files.iter();
        &files.find(|file| file.name == name).expect("it is emitted").text
    };
    let mut traces = vec![
        ("second_lfsr", has_module("gold_generator")),
        ("interleaver", has_module("interleaver")),
        ("saturation", has_port("o_saturated")),
        ("peak_detector", has_port("o_peak_valid")),
    ];
    if emission.parameters.histogram.is_some() {
        let channel = text_of("histogram_channel.v");
        let adders = channel.matches("bin_adder ").count();
        traces.push(("further_adders", adders > 1 || channel.contains(": gen_adder")));
        return traces;
    }
    traces.extend([
        ("scan_realignment", text_of("scan_controller.v").contains("o_start")),
        ("lane_choice", emission.parameters.samples_per_chip > 1),
        ("parallel_correlators", emission.parameters.parallel > 1),
    ]);
    traces
}

#[test]
fn in_random_scenes() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(7);
    let mut seen = BTreeMap::<&str, [u32; 2]>::new();
    for number in 0..repeated(70, 160) {
        let (scene, emission) = draw::emitted(&mut rng, Extent::SHORT, |_| ());
        let plan = plan(&Sensor::new(&scene));
        for (part, is_there) in traces(&emission) {
            assert_eq!(keeps(&plan, part), is_there, "scene {number}: {part}");
            seen.entry(part).or_default()[usize::from(is_there)] += 1;
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
        assert_eq!(named(&manifest["left_out"]), named(&plan["hardware"]), "scene {number}");
    }
    let often = |times: &[u32; 2]| times.iter().all(|&times| times > 2);
    assert!(seen.len() == 8 && seen.values().all(often), "{seen:?}");
}
