//! Scenes drawn at random from the whole interface: no tool has anything to say
//! about their Verilog, and no warning is waived.

use std::collections::BTreeMap;
use std::path::Path;

use crate::hdl_support::draw::{self, Extent};
use crate::hdl_support::run;
use goldtof::deliver::{Emission, write};
use goldtof::scene::Registers;
use optics_support::repeated;
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;

const SEED: u64 = 20_231_115;

/// The design, and these modules as tops, under Verilator, Icarus and Yosys; what they said.
pub fn lint(emission: &Emission, folder: &Path, tops: &[&str]) -> String {
    write(emission, folder).expect("the files can be written");
    let files: Vec<&str> = emission.files.iter().map(|f| f.name.as_str()).collect();
    let script = format!(
        "read_verilog {}; hierarchy -check -top sensor_top; proc; check -assert; \
         select -assert-none t:$dlatch t:$_DLATCH_*",
        files.join(" ")
    );
    let mut said = run(folder, "yosys", &["-q", "-p", &script]);
    for top in tops {
        let list = format!("{top}.f");
        // Warnings do not end the run, so that all tools get their say.
        let wall = ["--lint-only", "-Wall", "--timing", "-Wno-fatal", "--top-module"];
        said += &run(folder, "verilator", &[&wall[..], &[top, "-f", &list]].concat());
        // The testbench has a time scale; the design has no use for one.
        let wall = ["-Wall", "-Wno-timescale", "-g2005", "-o", "lint.vvp", "-s"];
        said += &run(folder, "iverilog", &[&wall[..], &[top, "-f", &list]].concat());
    }
    said
}

#[test]
fn random_scenes_are_clean_under_four_tools() {
    // Those that `emit` refuses are drawn again. A host sets every fifth.
    let scenes = repeated(50, 75) as usize;
    let drawn: Vec<(Emission, Vec<String>)> = (0..scenes as u64)
        .into_par_iter()
        .map(|number| {
            let mut rng = Xoshiro256PlusPlus::seed_from_u64(SEED + number);
            let mut refused = Vec::new();
            let registers = [Registers::None, Registers::Axi4Lite][usize::from(number % 5 == 4)];
            let (_, emission) = draw::emitted_with(&mut rng, Extent::WHOLE, registers, |reason| {
                let kind = reason.split([':', ',']).next().unwrap_or_default();
                let kind = kind.trim_end_matches(|c: char| c.is_ascii_digit());
                refused.push(kind.to_owned());
            });
            (emission, refused)
        })
        .collect();
    let (emissions, refused): (Vec<Emission>, Vec<Vec<String>>) = drawn.into_iter().unzip();
    let has_peak = |emission: &&Emission| emission.parameters.peak.is_some();
    assert!(emissions.iter().filter(has_peak).count() > scenes / 5);
    let has_totals = |emission: &&Emission| emission.parameters.total_count.is_some();
    assert!(emissions.iter().filter(has_totals).count() > scenes / 5);
    let keeps = |emission: &Emission, buffers| {
        let histogram = &emission.parameters.histogram;
        histogram.as_ref().is_some_and(|h| h.buffers == buffers)
    };
    for buffers in [1, 2] {
        assert!(emissions.iter().any(|emission| keeps(emission, buffers)), "{buffers}");
    }
    // Two memories are seldom drawn.
    let apart = repeated(3, 1) as usize;
    let is_chosen = |number: usize| number.is_multiple_of(apart) || keeps(&emissions[number], 2);
    let chosen: Vec<usize> = (0..scenes).filter(|&number| is_chosen(number)).collect();
    let folder = tempfile::tempdir().expect("a temporary folder");
    let folder_of = |number: usize| folder.path().join(format!("scene-{number}"));
    let said: String = chosen
        .par_iter()
        .map(|&number| {
            let words =
                lint(&emissions[number], &folder_of(number), &["sensor_top", "sensor_top_tb"]);
            match &words[..] {
                "" => words,
                words => format!("{:?}\n{words}\n", emissions[number].parameters),
            }
        })
        .collect();
    assert!(said.is_empty(), "{said}");
    let folders: Vec<String> =
        chosen.iter().map(|&number| folder_of(number).display().to_string()).collect();
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    // Beside the target's temporary folder, where scripts/python-tools puts it.
    let python = concat!(env!("CARGO_TARGET_TMPDIR"), "/../python/bin/python");
    let mut arguments = vec!["scripts/slang-lint"];
    arguments.extend(folders.iter().map(String::as_str));
    assert_eq!(run(root, python, &arguments), "", "slang");
    println!("{} scenes clean; drawn again:", chosen.len());
    let mut times = BTreeMap::<String, usize>::new();
    for reason in refused.into_iter().flatten() {
        *times.entry(reason).or_default() += 1;
    }
    for (reason, times) in times {
        println!("{times:4} {reason}");
    }
}
