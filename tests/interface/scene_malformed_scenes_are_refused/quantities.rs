//! Numbers, units and ranges that are wrong.

use super::refusal;

#[test]
fn a_number_without_a_unit() {
    insta::assert_snapshot!(
        refusal(r#"dead_time = "14 ns""#, r#"dead_time = "14""#),
        @r#"
    scenes/x.toml:14:13: detector.dead_time: "14" has no unit; write for example "14 ns"
      14 | dead_time = "14"
         |             ^^^^
    "#
    );
}

#[test]
fn a_bare_number_where_a_unit_is_needed() {
    insta::assert_snapshot!(
        refusal(r#"dead_time = "14 ns""#, "dead_time = 14"),
        @r#"
    scenes/x.toml:14:13: detector.dead_time: 14 has no unit; write for example "14 ns"
      14 | dead_time = 14
         |             ^^
    "#
    );
}

#[test]
fn a_time_where_a_distance_is_needed() {
    insta::assert_snapshot!(
        refusal(r#"distance = "3.2 m""#, r#"distance = "3 ns""#),
        @r#"
    scenes/x.toml:19:12: path.distance: "3 ns" is a time, but a distance is needed; write for example "3.2 m"
      19 | distance = "3 ns"
         |            ^^^^^^
    "#
    );
}

#[test]
fn an_unknown_unit() {
    insta::assert_snapshot!(
        refusal(r#"dead_time = "14 ns""#, r#"dead_time = "14 nsec""#),
        @r#"
    scenes/x.toml:14:13: detector.dead_time: "14 nsec" has the unknown unit "nsec"; a time takes fs, ps, ns, us, ms, s, min or h
      14 | dead_time = "14 nsec"
         |             ^^^^^^^^^
    "#
    );
}

#[test]
fn no_number_at_all() {
    insta::assert_snapshot!(
        refusal(r#"chip_period = "8 ns""#, r#"chip_period = "fast""#),
        @r#"
    scenes/x.toml:2:15: clock.chip_period: "fast" is not a number with a unit; write for example "8 ns"
      2 | chip_period = "fast"
        |               ^^^^^^
    "#
    );
}

#[test]
fn a_negative_time() {
    insta::assert_snapshot!(
        refusal(r#"dead_time = "14 ns""#, r#"dead_time = "-14 ns""#),
        @r#"
    scenes/x.toml:14:13: detector.dead_time: "-14 ns" is outside "0 s" to "10 ms"; write for example "14 ns"
      14 | dead_time = "-14 ns"
         |             ^^^^^^^^
    "#
    );
}

#[test]
fn a_chip_period_of_zero() {
    insta::assert_snapshot!(
        refusal(r#"chip_period = "8 ns""#, r#"chip_period = "0 ns""#),
        @r#"
    scenes/x.toml:2:15: clock.chip_period: "0 ns" is outside "1 ps" to "10 ms"; write for example "8 ns"
      2 | chip_period = "0 ns"
        |               ^^^^^^
    "#
    );
}

#[test]
fn a_quantity_beyond_any_number() {
    insta::assert_snapshot!(
        refusal(r#"integration = "20 us""#, r#"integration = "1e300 h""#),
        @r#"
    scenes/x.toml:22:15: scan.integration: "1e300 h" is outside "1 ps" to "1000000 s"; write for example "100 us"
      22 | integration = "1e300 h"
         |               ^^^^^^^^^
    "#
    );
}

#[test]
fn samples_per_chip_not_a_power_of_two() {
    insta::assert_snapshot!(
        refusal("samples_per_chip = 8", "samples_per_chip = 12"),
        @r#"
    scenes/x.toml:3:20: clock.samples_per_chip: 12 is not a power of two; use 8 or 16
      3 | samples_per_chip = 12
        |                    ^^
    "#
    );
}

#[test]
fn samples_per_chip_too_large() {
    insta::assert_snapshot!(
        refusal("samples_per_chip = 8", "samples_per_chip = 128"),
        @r#"
    scenes/x.toml:3:20: clock.samples_per_chip: 128 is outside 1 to 64; write for example 8
      3 | samples_per_chip = 128
        |                    ^^^
    "#
    );
}

#[test]
fn an_extinction_ratio_below_one() {
    insta::assert_snapshot!(
        refusal(r#"mean_power = "20 pW""#, "mean_power = \"20 pW\"\nextinction_ratio = 0.1"),
        @r#"
    scenes/x.toml:10:20: source.extinction_ratio: 0.1 is outside 1 to 1000000000000000; write for example 10, or "inf"
      10 | extinction_ratio = 0.1
         |                    ^^^
    "#
    );
}

#[test]
fn a_probability_above_one() {
    insta::assert_snapshot!(
        refusal(r#"dead_time = "14 ns""#, "dead_time = \"14 ns\"\nphoton_detection_probability = 31"),
        @r#"
    scenes/x.toml:15:32: detector.photon_detection_probability: 31 is outside 0 to 1; write for example 0.31
      15 | photon_detection_probability = 31
         |                                ^^
    "#
    );
}

#[test]
fn a_probability_that_is_nan() {
    insta::assert_snapshot!(
        refusal(r#"dead_time = "14 ns""#, "dead_time = \"14 ns\"\nphoton_detection_probability = nan"),
        @r#"
    scenes/x.toml:15:32: detector.photon_detection_probability: nan is outside 0 to 1; write for example 0.31
      15 | photon_detection_probability = nan
         |                                ^^^
    "#
    );
}

#[test]
fn afterpulsing_without_its_time_constant() {
    insta::assert_snapshot!(
        refusal(r#"dead_time = "14 ns""#, "dead_time = \"14 ns\"\nafterpulsing = { probability = 0.137 }"),
        @r#"
    scenes/x.toml:15:16: detector.afterpulsing: `time_constant` is missing; write for example time_constant = "5 ns"
      15 | afterpulsing = { probability = 0.137 }
         |                ^^^^^^^^^^^^^^^^^^^^^^^
    "#
    );
}

#[test]
fn afterpulsing_that_outlasts_any_simulation() {
    insta::assert_snapshot!(
        refusal(r#"dead_time = "14 ns""#, "dead_time = \"14 ns\"\nafterpulsing = { probability = 0.1, time_constant = \"1 s\" }"),
        @r#"
    scenes/x.toml:15:53: detector.afterpulsing.time_constant: "1 s" is outside "1 fs" to "10 ms"; write for example "5 ns"
      15 | afterpulsing = { probability = 0.1, time_constant = "1 s" }
         |                                                     ^^^^^
    "#
    );
}

#[test]
fn a_jitter_of_very_many_chips() {
    insta::assert_snapshot!(
        refusal(r#"dead_time = "14 ns""#, "dead_time = \"14 ns\"\njitter = [\"0.4 ms\", \"0.4 ms\"]"),
        @r#"
    scenes/x.toml:15:10: detector.jitter: ["0.4 ms", "0.4 ms"] is more than 65536 chips; write at most "524288 ns"
      15 | jitter = ["0.4 ms", "0.4 ms"]
         |          ^^^^^^^^^^^^^^^^^^^^
    "#
    );
}

#[test]
fn afterpulsing_that_never_dies_out() {
    insta::assert_snapshot!(
        refusal(r#"dead_time = "14 ns""#, "dead_time = \"14 ns\"\nafterpulsing = { probability = 1.0, time_constant = \"5 ns\" }"),
        @r#"
    scenes/x.toml:15:32: detector.afterpulsing.probability: 1.0 is outside 0 to 0.999999; write for example 0.137
      15 | afterpulsing = { probability = 1.0, time_constant = "5 ns" }
         |                                ^^^
    "#
    );
}

#[test]
fn an_integration_time_of_no_chip() {
    insta::assert_snapshot!(
        refusal(r#"integration = "20 us""#, r#"integration = "3 ns""#),
        @r#"
    scenes/x.toml:22:15: scan.integration: the integration time rounds to 0 chips of 8 ns; integrate for at least one chip
      22 | integration = "3 ns"
         |               ^^^^^^
    "#
    );
}

#[test]
fn an_integration_time_of_ages() {
    insta::assert_snapshot!(
        refusal(r#"integration = "20 us""#, r#"integration = "1e12 h""#),
        @r#"
    scenes/x.toml:22:15: scan.integration: "1e12 h" is outside "1 ps" to "1000000 s"; write for example "100 us"
      22 | integration = "1e12 h"
         |               ^^^^^^^^
    "#
    );
}

#[test]
fn steps_that_are_neither_word_nor_window() {
    insta::assert_snapshot!(
        refusal(r#"integration = "20 us""#, "integration = \"20 us\"\nsteps = \"some\""),
        @r#"
    scenes/x.toml:23:9: scan.steps: "some" is not a choice of phase steps; write "all", { first = 0, count = 64 } or { around = "3.2 m", halfwidth = 16 }
      23 | steps = "some"
         |         ^^^^^^
    "#
    );
}

#[test]
fn steps_that_mix_two_windows() {
    insta::assert_snapshot!(
        refusal(r#"integration = "20 us""#, "integration = \"20 us\"\nsteps = { first = 0, halfwidth = 3 }"),
        @r#"
    scenes/x.toml:23:9: scan.steps: these keys do not choose phase steps; write "all", { first = 0, count = 64 } or { around = "3.2 m", halfwidth = 16 }
      23 | steps = { first = 0, halfwidth = 3 }
         |         ^^^^^^^^^^^^^^^^^^^^^^^^^^^^
    "#
    );
}

#[test]
fn more_steps_than_the_period_has() {
    insta::assert_snapshot!(
        refusal(r#"integration = "20 us""#, "integration = \"20 us\"\nsteps = { first = 0, count = 249 }"),
        @r#"
    scenes/x.toml:23:30: scan.steps.count: 249 phase steps are more than the 248 of a code period; scan fewer, or "all"
      23 | steps = { first = 0, count = 249 }
         |                              ^^^
    "#
    );
}

#[test]
fn a_window_wider_than_the_period() {
    insta::assert_snapshot!(
        refusal(r#"integration = "20 us""#, "integration = \"20 us\"\nsteps = { around = \"3.2 m\", halfwidth = 124 }"),
        @r#"
    scenes/x.toml:23:41: scan.steps.halfwidth: 249 phase steps are more than the 248 of a code period; scan fewer, or "all"
      23 | steps = { around = "3.2 m", halfwidth = 124 }
         |                                         ^^^
    "#
    );
}

#[test]
fn a_first_step_outside_the_period() {
    insta::assert_snapshot!(
        refusal(r#"integration = "20 us""#, "integration = \"20 us\"\nsteps = { first = 248, count = 2 }"),
        @r#"
    scenes/x.toml:23:19: scan.steps.first: 248 is outside 0 to 247, the phase steps of a period
      23 | steps = { first = 248, count = 2 }
         |                   ^^^
    "#
    );
}

#[test]
fn a_window_around_a_power() {
    insta::assert_snapshot!(
        refusal(r#"integration = "20 us""#, "integration = \"20 us\"\nsteps = { around = \"3 pW\", halfwidth = 1 }"),
        @r#"
    scenes/x.toml:23:20: scan.steps.around: "3 pW" is a power, but a distance is needed; write for example "3.2 m"
      23 | steps = { around = "3 pW", halfwidth = 1 }
         |                    ^^^^^^
    "#
    );
}

#[test]
fn more_parallel_steps_than_the_scan_has() {
    insta::assert_snapshot!(
        refusal(r#"integration = "20 us""#, "integration = \"20 us\"\nsteps = { first = 0, count = 4 }\n\n[hardware]\nparallel = 8"),
        @r#"
    scenes/x.toml:26:12: hardware.parallel: 8 phase steps at once are more than the 4 of the scan; use 4 or less, or scan more steps
      26 | parallel = 8
         |            ^
    "#
    );
}
