//! Paths that move too fast, too wildly, or into the sensor.

use super::refusal;

/// The path at 3.2 m, with more keys.
fn refused_path(keys: &str) -> String {
    const DISTANCE: &str = "distance = \"3.2 m\"";
    refusal(DISTANCE, &format!("{DISTANCE}\n{keys}"))
}

#[test]
fn a_speed_without_a_unit() {
    insta::assert_snapshot!(refused_path("velocity = 1.5"), @r#"
    scenes/x.toml:20:12: path.velocity: 1.5 has no unit; write for example "1.5 m/s"
      20 | velocity = 1.5
         |            ^^^
    "#);
}

#[test]
fn a_distance_as_a_speed() {
    insta::assert_snapshot!(refused_path("velocity = \"1.5 m\""), @r#"
    scenes/x.toml:20:12: path.velocity: "1.5 m" is a length, but a speed is needed; write for example "1.5 m/s"
      20 | velocity = "1.5 m"
         |            ^^^^^^^
    "#);
}

#[test]
fn an_unknown_unit_of_speed() {
    insta::assert_snapshot!(refused_path("velocity = \"30 mph\""), @r#"
    scenes/x.toml:20:12: path.velocity: "30 mph" has the unknown unit "mph"; a speed takes um/s, mm/s, m/s, km/s or km/h
      20 | velocity = "30 mph"
         |            ^^^^^^^^
    "#);
}

#[test]
fn a_speed_near_that_of_light() {
    insta::assert_snapshot!(refused_path("velocity = \"-300 km/s\""), @r#"
    scenes/x.toml:20:12: path.velocity: "-300 km/s" is outside "-299 km/s" to "299 km/s"; write for example "1.5 m/s"
      20 | velocity = "-300 km/s"
         |            ^^^^^^^^^^^
    "#);
}

#[test]
fn a_target_that_reaches_the_sensor_within_a_scan() {
    insta::assert_snapshot!(refused_path("velocity = \"-700 m/s\""), @r#"
    scenes/x.toml:20:12: path.velocity: the target reaches the sensor after 4.571 ms, before the scan of 4.960 ms ends; start farther away, or scan fewer steps
      20 | velocity = "-700 m/s"
         |            ^^^^^^^^^^
    "#);
}

#[test]
fn a_fluctuation_without_its_correlation_time() {
    insta::assert_snapshot!(refused_path("fluctuation = { std = \"2 mm\" }"), @r#"
    scenes/x.toml:20:15: path.fluctuation: `correlation_time` is missing; write for example correlation_time = "1 ms"
      20 | fluctuation = { std = "2 mm" }
         |               ^^^^^^^^^^^^^^^^
    "#);
}

#[test]
fn a_fluctuation_that_is_a_distance() {
    insta::assert_snapshot!(refused_path("fluctuation = \"2 mm\""), @r#"
    scenes/x.toml:20:15: path.fluctuation: "2 mm" is a string, but a table is needed; write for example { std = "2 mm", correlation_time = "1 ms" }
      20 | fluctuation = "2 mm"
         |               ^^^^^^
    "#);
}

#[test]
fn a_misspelt_key_of_a_fluctuation() {
    insta::assert_snapshot!(
        refused_path("fluctuation = { std = \"2 mm\", corelation_time = \"1 ms\" }"),
        @r#"
    scenes/x.toml:20:15: path.fluctuation: `correlation_time` is missing; write for example correlation_time = "1 ms"
      20 | fluctuation = { std = "2 mm", corelation_time = "1 ms" }
         |               ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^
    scenes/x.toml:20:31: path.fluctuation.corelation_time: `path.fluctuation` has no key `corelation_time`; did you mean `correlation_time`?
      20 | fluctuation = { std = "2 mm", corelation_time = "1 ms" }
         |                               ^^^^^^^^^^^^^^^
    "#
    );
}

#[test]
fn a_negative_fluctuation() {
    insta::assert_snapshot!(
        refused_path("fluctuation = { std = \"-2 mm\", correlation_time = \"1 ms\" }"),
        @r#"
    scenes/x.toml:20:23: path.fluctuation.std: "-2 mm" is outside "0 m" to "1000 km"; write for example "2 mm"
      20 | fluctuation = { std = "-2 mm", correlation_time = "1 ms" }
         |                       ^^^^^^^
    "#
    );
}

#[test]
fn a_fluctuation_from_chip_to_chip() {
    insta::assert_snapshot!(
        refused_path("fluctuation = { std = \"1 um\", correlation_time = \"100 ns\" }"),
        @r#"
    scenes/x.toml:20:50: path.fluctuation.correlation_time: "100 ns" is shorter than 16 chips; write at least "128 ns"
      20 | fluctuation = { std = "1 um", correlation_time = "100 ns" }
         |                                                  ^^^^^^^^
    "#
    );
}

#[test]
fn a_fluctuation_over_ages() {
    insta::assert_snapshot!(
        refused_path("fluctuation = { std = \"1 mm\", correlation_time = \"3000 h\" }"),
        @r#"
    scenes/x.toml:20:50: path.fluctuation.correlation_time: "3000 h" is longer than 2^50 chips; write at most "2501 h"
      20 | fluctuation = { std = "1 mm", correlation_time = "3000 h" }
         |                                                  ^^^^^^^^
    "#
    );
}

#[test]
fn a_fluctuation_faster_than_light_can_follow() {
    insta::assert_snapshot!(
        refused_path("fluctuation = { std = \"20 mm\", correlation_time = \"1 us\" }"),
        @r#"
    scenes/x.toml:20:23: path.fluctuation.std: "20 mm" is too much for so short a correlation time; write at most "2997 um", or a longer `correlation_time`
      20 | fluctuation = { std = "20 mm", correlation_time = "1 us" }
         |                       ^^^^^^^
    "#
    );
}

#[test]
fn a_fluctuation_as_large_as_the_distance() {
    insta::assert_snapshot!(
        refused_path("fluctuation = { std = \"60 cm\", correlation_time = \"1 s\" }"),
        @r#"
    scenes/x.toml:20:15: path.fluctuation: the path comes as near as 3.2000 m within a scan; with this fluctuation it must keep 6 standard deviations, 3.6000 m; write a std of at most "533333 um", or start farther away
      20 | fluctuation = { std = "60 cm", correlation_time = "1 s" }
         |               ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^
    "#
    );
}
