//! The rules of each table of a scene, one malformed scene per rule; the whole
//! messages are in `snapshots/`.

use super::refusal;

/// A rule, and the departure from the right scene that breaks it.
type Case = (&'static str, &'static str, &'static str);

/// All refusals, each under the name of the rule that it belongs to.
fn refusals(cases: &[Case]) -> String {
    let texts: Vec<String> = cases
        .iter()
        .map(|(rule, right, wrong)| format!("{rule}\n{}\n", refusal(right, wrong)))
        .collect();
    texts.join("\n")
}

#[test]
fn text_that_is_not_toml() {
    const CASES: [Case; 13] = [
        ("a string that does not end", r#""8 ns""#, r#""8 ns"#),
        ("a table header that does not end", "[scan]", "[scan"),
        ("a key without a value", r#"dead_time = "14 ns""#, "dead_time ="),
        ("a key without an equals sign", r#"dead_time = "14 ns""#, r#"dead_time "14 ns""#),
        ("two keys on one line", "samples_per_chip = 8", "samples_per_chip = 8 jitter = []"),
        ("an unknown escape", r#""8 ns""#, r#""8\qns""#),
        ("an inline table that does not end", "degree = 5 }", "degree = 5"),
        ("an array that does not end", r#"dead_time = "14 ns""#, r#"jitter = ["4 ps""#),
        ("a number that is none", "samples_per_chip = 8", "samples_per_chip = 8x"),
        ("a leading zero", "samples_per_chip = 8", "samples_per_chip = 08"),
        ("a control character", r#""laser""#, "\"la\u{7}ser\""),
        ("a table given twice", "[scan]", "[scan]\nintegration = \"1 us\"\n\n[scan]"),
        ("a table that is an array elsewhere", "[[path]]", "[detector]\n\n[[path]]"),
    ];
    insta::assert_snapshot!(refusals(&CASES));
}

#[test]
fn clock() {
    const CASES: [Case; 9] = [
        ("no chip period", "chip_period = \"8 ns\"\n", ""),
        (
            "a clock that is a number",
            "[clock]\nchip_period = \"8 ns\"\nsamples_per_chip = 8\n",
            "clock = 8\n",
        ),
        ("a clock that is an array of tables", "[clock]", "[[clock]]"),
        ("a chip period that is a rate", r#""8 ns""#, r#""125 Mcps""#),
        ("a chip period that is a truth value", r#""8 ns""#, "true"),
        ("a chip period in two units", r#""8 ns""#, r#""8 ns 3 ps""#),
        ("samples that are not a whole number", "samples_per_chip = 8", "samples_per_chip = 8.0"),
        ("samples in quotes", "samples_per_chip = 8", "samples_per_chip = \"8\""),
        ("no samples", "samples_per_chip = 8", "samples_per_chip = 0"),
    ];
    insta::assert_snapshot!(refusals(&CASES));
}

#[test]
fn source() {
    const CASES: [Case; 11] = [
        ("no name", "name = \"laser\"\n", ""),
        ("an empty name", "name = \"laser\"", "name = \"\""),
        ("a name that is a number", "name = \"laser\"", "name = 1"),
        ("no code", "code = { family = \"gold\", degree = 5 }\n", ""),
        ("a wavelength that is a time", r#""783 nm""#, r#""783 ns""#),
        ("a wavelength of zero", r#""783 nm""#, r#""0 nm""#),
        ("a power that is a wavelength", r#""20 pW""#, r#""20 nm""#),
        ("a negative power", r#""20 pW""#, r#""-20 pW""#),
        ("a power in a wrong case", r#""20 pW""#, r#""20 PW""#),
        (
            "an extinction ratio in decibels",
            "mean_power = \"20 pW\"",
            "mean_power = \"20 pW\"\nextinction_ratio = \"10 dB\"",
        ),
        (
            "two sources of one name",
            "[[detector]]",
            "[[source]]\nname = \"laser\"\ncode = { family = \"square\" }\nwavelength = \"783 nm\"\n\
             mean_power = \"1 pW\"\n\n[[detector]]",
        ),
    ];
    insta::assert_snapshot!(refusals(&CASES));
}

#[test]
fn code() {
    const CODE: &str = r#"{ family = "gold", degree = 5 }"#;
    const CASES: [Case; 22] = [
        ("no family", CODE, "{ degree = 5 }"),
        ("a family that is a number", r#"family = "gold""#, "family = 5"),
        ("a degree in quotes", "degree = 5", r#"degree = "5""#),
        ("a degree that is negative", "degree = 5", "degree = -5"),
        ("a degree below the least", "degree = 5", "degree = 2"),
        ("a degree beyond 64 bits", "degree = 5", "degree = 99999999999999999999"),
        ("an index below the least", "degree = 5", "degree = 5, index = -3"),
        ("an index that is not a whole number", "degree = 5", "degree = 5, index = 1.5"),
        ("an index of an m-sequence", CODE, r#"{ family = "m-sequence", degree = 5, index = 1 }"#),
        ("an interleaving depth that is negative", "degree = 5", "degree = 5, interleave = -1"),
        (
            "interleaving to more chips than a code may have",
            "degree = 5",
            "degree = 19, interleave = 8",
        ),
        ("polynomials that are text", "degree = 5", r#"degree = 5, polynomials = "5,2,0""#),
        ("polynomials that are not lists", "degree = 5", "degree = 5, polynomials = [5, 2, 0]"),
        ("exponents in quotes", "degree = 5", r#"degree = 5, polynomials = [["5", "2", "0"]]"#),
        (
            "an exponent beyond the largest degree",
            "degree = 5",
            "degree = 5, polynomials = [[21, 2, 0], [5, 2, 0]]",
        ),
        (
            "a polynomial of another degree",
            "degree = 5",
            "degree = 5, polynomials = [[5, 2, 0], [6, 1, 0]]",
        ),
        (
            "the same polynomial twice",
            "degree = 5",
            "degree = 5, polynomials = [[5, 2, 0], [5, 2, 0]]",
        ),
        ("an empty polynomial", "degree = 5", "degree = 5, polynomials = [[], [5, 2, 0]]"),
        (
            "two polynomials for one register",
            CODE,
            r#"{ family = "m-sequence", degree = 5, polynomials = [[5, 2, 0], [5, 4, 3, 2, 0]] }"#,
        ),
        ("seeds that are one text", "degree = 5", r#"degree = 5, seeds = "11111""#),
        ("seeds that are numbers", "degree = 5", "degree = 5, seeds = [11111, 11111]"),
        ("one seed for two registers", "degree = 5", r#"degree = 5, seeds = ["11111"]"#),
    ];
    insta::assert_snapshot!(refusals(&CASES));
}

#[test]
fn code_given_as_chips_or_in_large() {
    const CODE: &str = r#"{ family = "gold", degree = 5 }"#;
    const CASES: [Case; 8] = [
        ("a seed that is not binary", "degree = 5", r#"degree = 5, seeds = ["11112", "11111"]"#),
        ("a flag that is a number", "degree = 5", "degree = 5, allow_non_preferred = 1"),
        (
            "a flag of an m-sequence",
            CODE,
            r#"{ family = "m-sequence", degree = 5, allow_non_preferred = true }"#,
        ),
        ("chips that are missing", CODE, r#"{ family = "chips" }"#),
        ("no chips", CODE, r#"{ family = "chips", chips = "" }"#),
        ("chips that are a number", CODE, r#"{ family = "chips", chips = 110 }"#),
        ("chips of a Gold code", "degree = 5", r#"degree = 5, chips = "0110""#),
        ("an unknown key", "degree = 5", "degree = 5, depth = 1"),
    ];
    insta::assert_snapshot!(refusals(&CASES));
}

#[test]
fn detector() {
    const AT: &str = r#"dead_time = "14 ns""#;
    const CASES: [Case; 17] = [
        ("no name", "name = \"spad\"\n", ""),
        ("no reference", "reference = \"laser\"\n", ""),
        ("a reference that is a number", r#"reference = "laser""#, "reference = 0"),
        ("a dead time that is a distance", AT, r#"dead_time = "14 m""#),
        ("a probability in quotes", AT, r#"photon_detection_probability = "31 %""#),
        ("a negative probability", AT, "photon_detection_probability = -0.31"),
        ("a dark count rate in hertz", AT, r#"dark_count_rate = "71 kHz""#),
        ("a negative background", AT, r#"background_rate = "-1 cps""#),
        ("a pulse without width", AT, r#"pulse_width = "0 ns""#),
        ("a negative delay", AT, r#"delay = "-1.75 ns""#),
        ("one jitter without its list", AT, r#"jitter = "4 ps""#),
        ("a jitter without a unit", AT, r#"jitter = ["53.5 ps", 4]"#),
        ("a negative jitter", AT, r#"jitter = ["-4 ps"]"#),
        ("afterpulsing that is a number", AT, "afterpulsing = 0.137"),
        (
            "afterpulsing without its probability",
            AT,
            r#"afterpulsing = { time_constant = "5 ns" }"#,
        ),
        (
            "afterpulsing without any delay",
            AT,
            r#"afterpulsing = { probability = 0.1, time_constant = "0 ns" }"#,
        ),
        ("an unknown key of the counter", AT, r#"counter = { rise_delay = "340 ps" }"#),
    ];
    insta::assert_snapshot!(refusals(&CASES));
}

#[test]
fn path() {
    const AT: &str = r#"distance = "3.2 m""#;
    const CASES: [Case; 8] = [
        ("no source", "source = \"laser\"\n", ""),
        ("a path from no source", "source = \"laser\"", "source = \"sun\""),
        ("a negative distance", AT, r#"distance = "-3.2 m""#),
        ("a distance in feet", AT, r#"distance = "10 ft""#),
        ("a negative delay", AT, r#"delay = "-21 ns""#),
        ("a transmission above one", AT, "distance = \"3.2 m\"\ntransmission = 1.1"),
        ("a transmission in quotes", AT, "distance = \"3.2 m\"\ntransmission = \"50 %\""),
        ("one path that is a table", "[[path]]", "[path]"),
    ];
    insta::assert_snapshot!(refusals(&CASES));
}

#[test]
fn path_that_moves() {
    const AT: &str = r#"distance = "3.2 m""#;
    const CASES: [Case; 6] = [
        ("a velocity that is a distance", AT, "distance = \"3.2 m\"\nvelocity = \"1.5 m\""),
        ("a velocity near that of light", AT, "distance = \"3.2 m\"\nvelocity = \"300 km/s\""),
        ("a fluctuation that is a number", AT, "distance = \"3.2 m\"\nfluctuation = 3"),
        (
            "a fluctuation without its correlation time",
            AT,
            "distance = \"3.2 m\"\nfluctuation = { std = \"1 mm\" }",
        ),
        (
            "a fluctuation as long as the path",
            AT,
            "distance = \"3.2 m\"\nfluctuation = { std = \"3 m\", correlation_time = \"1 s\" }",
        ),
        (
            "a fluctuation faster than chips",
            AT,
            "distance = \"3.2 m\"\nfluctuation = { std = \"1 nm\", correlation_time = \"8 ns\" }",
        ),
    ];
    insta::assert_snapshot!(refusals(&CASES));
}

#[test]
fn scan() {
    const AT: &str = r#"integration = "20 us""#;
    const CASES: [Case; 12] = [
        ("no integration time", "integration = \"20 us\"\n", ""),
        ("an integration time of zero", AT, r#"integration = "0 s""#),
        ("an integration time in chips", AT, "integration = 2500"),
        ("a word for the steps", AT, "integration = \"20 us\"\nsteps = \"some\""),
        ("a number of steps", AT, "integration = \"20 us\"\nsteps = 64"),
        ("a window without its count", AT, "integration = \"20 us\"\nsteps = { first = 0 }"),
        ("a window of no step", AT, "integration = \"20 us\"\nsteps = { first = 0, count = 0 }"),
        (
            "a window that begins before 0",
            AT,
            "integration = \"20 us\"\nsteps = { first = -1, count = 8 }",
        ),
        ("a window without its centre", AT, "integration = \"20 us\"\nsteps = { halfwidth = 16 }"),
        (
            "a centre before the sensor",
            AT,
            "integration = \"20 us\"\nsteps = { around = \"-3.2 m\", halfwidth = 16 }",
        ),
        (
            "a centre without a unit",
            AT,
            "integration = \"20 us\"\nsteps = { around = 3.2, halfwidth = 16 }",
        ),
        (
            "an unknown key of the window",
            AT,
            "integration = \"20 us\"\nsteps = { first = 0, count = 8, step = 2 }",
        ),
    ];
    insta::assert_snapshot!(refusals(&CASES));
}

#[test]
fn estimate_and_hardware() {
    const CASES: [Case; 14] = [
        ("an unknown estimator", "[scan]", "[estimate]\nestimator = \"fit\"\n\n[scan]"),
        ("an estimator that is a truth value", "[scan]", "[estimate]\nestimator = true\n\n[scan]"),
        ("an estimate that is a word", "[clock]", "estimate = \"fft\"\n[clock]"),
        ("a target that is a number", "[scan]", "[hardware]\ntarget = 7\n\n[scan]"),
        ("no parallel step", "[scan]", "[hardware]\nparallel = 0\n\n[scan]"),
        ("too many parallel steps", "[scan]", "[hardware]\nparallel = 65\n\n[scan]"),
        ("a counter of one bit", "[scan]", "[hardware]\ncounter_width = 1\n\n[scan]"),
        ("a counter beyond 64 bits", "[scan]", "[hardware]\ncounter_width = 65\n\n[scan]"),
        ("an unknown key of the hardware", "[scan]", "[hardware]\ncounter_bits = 20\n\n[scan]"),
        ("total counts that are a number", "[scan]", "[hardware]\ntotal_counts = 1\n\n[scan]"),
        ("total counts that are a word", "[scan]", "[hardware]\ntotal_counts = \"yes\"\n\n[scan]"),
        ("taps without registers", "[scan]", "[hardware]\ncode_taps = true\n\n[scan]"),
        (
            "taps of a code without an LFSR",
            "[clock]\nchip_period = \"8 ns\"\nsamples_per_chip = 8\n\n[[source]]\nname = \"laser\"\n\
             code = { family = \"gold\", degree = 5 }",
            "[hardware]\nregisters = \"axi4-lite\"\ncode_taps = true\n\n[clock]\nchip_period = \"8 ns\"\n\
             samples_per_chip = 8\n\n[[source]]\nname = \"laser\"\ncode = { family = \"square\" }",
        ),
        (
            "the model estimator without total counts",
            "[scan]",
            "[estimate]\nestimator = \"model\"\n\n[hardware]\ntotal_counts = false\n\n[scan]",
        ),
    ];
    insta::assert_snapshot!(refusals(&CASES));
}
