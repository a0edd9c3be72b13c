//! Keys, tables and references that are wrong.

use super::refusal;

#[test]
fn an_unknown_key_with_a_near_one() {
    insta::assert_snapshot!(
        refusal(r#"dead_time = "14 ns""#, r#"deadtime = "14 ns""#),
        @r#"
    scenes/x.toml:14:1: detector.deadtime: `detector` has no key `deadtime`; did you mean `dead_time`?
      14 | deadtime = "14 ns"
         | ^^^^^^^^
    "#
    );
}

#[test]
fn an_unknown_key_with_none_near() {
    insta::assert_snapshot!(
        refusal(r#"integration = "20 us""#, "integration = \"20 us\"\ncolour = \"red\""),
        @r#"
    scenes/x.toml:23:1: scan.colour: `scan` has no key `colour`; it takes steps or integration
      23 | colour = "red"
         | ^^^^^^
    "#
    );
}

#[test]
fn an_unknown_table() {
    insta::assert_snapshot!(
        refusal("[scan]", "[skan]\n[scan]"),
        @r#"
    scenes/x.toml:21:2: skan: a scene has no key `skan`; did you mean `scan`?
      21 | [skan]
         |  ^^^^
    "#
    );
}

#[test]
fn a_required_key_that_is_missing() {
    insta::assert_snapshot!(
        refusal("chip_period = \"8 ns\"\n", ""),
        @r#"
    scenes/x.toml:1:1: clock: `chip_period` is missing; write for example chip_period = "8 ns"
      1 | [clock]
        | ^^^^^^^
    "#
    );
}

#[test]
fn a_required_table_that_is_missing() {
    insta::assert_snapshot!(
        refusal("[scan]\nintegration = \"20 us\"\n", ""),
        @r#"
    scenes/x.toml:1:1: the table [scan] is missing; a scene needs it
      1 | [clock]
        | ^
    "#
    );
}

#[test]
fn no_detector() {
    insta::assert_snapshot!(
        refusal("[[detector]]\nname = \"spad\"\nreference = \"laser\"\ndead_time = \"14 ns\"\n\n[[path]]\nsource = \"laser\"\ndetector = \"spad\"\ndistance = \"3.2 m\"\n", ""),
        @r#"
    scenes/x.toml:1:1: the table [[detector]] is missing; a scene needs it
      1 | [clock]
        | ^
    "#
    );
}

#[test]
fn a_reference_to_no_source() {
    insta::assert_snapshot!(
        refusal(r#"reference = "laser""#, r#"reference = "lazer""#),
        @r#"
    scenes/x.toml:13:13: detector.reference: no source is named "lazer"; did you mean "laser"?
      13 | reference = "lazer"
         |             ^^^^^^^
    "#
    );
}

#[test]
fn a_path_to_no_detector() {
    insta::assert_snapshot!(
        refusal(r#"detector = "spad""#, r#"detector = "camera""#),
        @r#"
    scenes/x.toml:18:12: path.detector: no detector is named "camera"; there is "spad"
      18 | detector = "camera"
         |            ^^^^^^^^
    "#
    );
}

#[test]
fn two_detectors_of_one_name() {
    insta::assert_snapshot!(
        refusal("[[path]]", "[[detector]]\nname = \"spad\"\nreference = \"laser\"\n\n[[path]]"),
        @r#"
    scenes/x.toml:17:8: detector.name: "spad" already names another detector; choose another name
      17 | name = "spad"
         |        ^^^^^^
    "#
    );
}

#[test]
fn distance_and_delay() {
    insta::assert_snapshot!(
        refusal(r#"distance = "3.2 m""#, "distance = \"3.2 m\"\ndelay = \"21 ns\""),
        @r#"
    scenes/x.toml:20:9: path.delay: the path has a distance already; give one of `distance` and `delay`
      20 | delay = "21 ns"
         |         ^^^^^^^
    "#
    );
}

#[test]
fn neither_distance_nor_delay() {
    insta::assert_snapshot!(
        refusal("distance = \"3.2 m\"\n", ""),
        @r#"
    scenes/x.toml:16:1: path: neither `distance` nor `delay` is given; write for example distance = "3.2 m"
      16 | [[path]]
         | ^^^^^^^^
    "#
    );
}

#[test]
fn an_unknown_target() {
    insta::assert_snapshot!(
        refusal("[scan]", "[hardware]\ntarget = \"ecp5-25k\"\n\n[scan]"),
        @r#"
    scenes/x.toml:22:10: hardware.target: "ecp5-25k" is not known; did you mean "ecp5-25k-6"?
      22 | target = "ecp5-25k"
         |          ^^^^^^^^^^
    "#
    );
}

#[test]
fn text_that_is_not_toml() {
    insta::assert_snapshot!(
        refusal(r#"name = "laser""#, "name = laser"),
        @r#"
    scenes/x.toml:6:8: not TOML: here a value is needed: a number, true or false, or text or a quantity in quotation marks
      6 | name = laser
        |        ^^^^^
    "#
    );
}

#[test]
fn a_key_given_twice() {
    insta::assert_snapshot!(
        refusal(r#"dead_time = "14 ns""#, "dead_time = \"14 ns\"\ndead_time = \"15 ns\""),
        @r#"
    scenes/x.toml:15:1: not TOML: duplicate key: a key or table may stand only once; leave one of them out
      15 | dead_time = "15 ns"
         | ^^^^^^^^^
    "#
    );
}
