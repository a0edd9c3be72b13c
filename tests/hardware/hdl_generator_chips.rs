//! The emitted generators give the code table, chip by chip.

use goldtof::deliver::{emit, write};
use goldtof::sensor::Sensor;
use std::fs;
use std::sync::Arc;

use crate::hdl_support::{run, scene};
use goldtof::code::{Code, CodeSpec, Family};

/// Writes `o_laser` after every clock as 64 bits.
const BENCH: &str = r#"
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include "Vsensor_top.h"
int main(int argc, char **argv) {
    Vsensor_top top;
    std::FILE *out = std::fopen("laser.bin", "wb");
    const long cycles = std::atol(argv[argc - 1]);
    top.i_samples = 0;
    top.m_axis_tready = 1;
    for (long cycle = -2; cycle < cycles; ++cycle) {
        top.i_rst = cycle < 0;
        top.i_clk = 0;
        top.eval();
        top.i_clk = 1;
        top.eval();
        const std::uint64_t laser = top.o_laser;
        if (cycle >= 0) std::fwrite(&laser, sizeof laser, 1, out);
    }
    return std::fclose(out);
}
"#;

/// A code of the library, as a scene with these keys would have it.
fn code(family: Family, degree: Option<u32>, index: Option<i64>, interleave: u32) -> Arc<Code> {
    let spec = CodeSpec { degree, index, interleave, ..CodeSpec::new(family) };
    Arc::new(spec.build().expect("the family has this code"))
}

/// All codes at once, each on a laser of its own, so that one model is built
/// and run for as long as the longest takes.
#[test]
fn emitted_chips_equal_the_table_over_two_periods_for_every_degree_and_depth() {
    // Every degree that has a preferred pair, and the others for one LFSR.
    let gold_degrees = [3, 5, 6, 7, 9, 10, 11, 13, 14, 15];
    let other_degrees = [4, 8, 12, 16];
    let mut codes = Vec::new();
    for interleave in 0..=3 {
        for degree in gold_degrees {
            let index = i64::from(degree) - 2;
            codes.push(code(Family::Gold, Some(degree), Some(index), interleave));
        }
        codes.push(code(Family::Square, None, None, interleave));
    }
    for degree in other_degrees {
        codes.push(code(Family::MSequence, Some(degree), None, 0));
    }
    for index in [-2, -1] {
        codes.push(code(Family::Gold, Some(7), Some(index), 1));
    }
    let scene = scene(&codes, 0, 1, 0, Some(3), 5, None);
    let emission = emit(&Sensor::new(&scene), "goldtof emit test.toml --out build")
        .expect("the scene is fine");
    let folder = tempfile::tempdir().expect("a temporary folder");
    write(&emission, folder.path()).expect("the files can be written");
    fs::write(folder.path().join("bench.cpp"), BENCH).expect("so can the bench");

    let mut arguments = vec!["--cc", "--exe", "--build", "-O3", "-CFLAGS", "-O1"];
    arguments.extend(["--top-module", "sensor_top", "bench.cpp"]);
    arguments.extend(emission.files.iter().map(|f| f.name.as_str()));
    run(folder.path(), "verilator", &arguments);
    let cycles = 2 * codes.iter().map(|c| c.chips.len()).max().expect("codes");
    let program = folder.path().join("obj_dir/Vsensor_top");
    let program = program.to_str().expect("a plain path");
    run(folder.path(), program, &[&cycles.to_string()]);

    let laser = fs::read(folder.path().join("laser.bin")).expect("the testbench wrote it");
    assert_eq!(laser.len(), 8 * cycles);
    let words = laser.chunks_exact(8);
    for (n, word) in words.enumerate() {
        let word = u64::from_le_bytes(word.try_into().expect("8 bytes"));
        for (m, code) in codes.iter().enumerate() {
            let expected = u64::from(code.chips[n % code.chips.len()]);
            assert_eq!(
                word >> m & 1,
                expected,
                "chip {n} of source {m}, {:?}, interleaved to {}",
                code.generator,
                code.interleave
            );
        }
    }
}
