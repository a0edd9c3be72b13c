//! Scenes that are wrong in large: refused in bounded time, memory and text.

use std::fmt::Write as _;

use goldtof::scene::{SceneErrors, parse};

use super::{SCENE, refusal};

#[test]
fn of_very_many_errors_the_first_are_told_and_the_others_counted() {
    let keys: String = (0..20_000).fold(String::new(), |mut keys, i| {
        let _ = write!(keys, "k{i} = 1, ");
        keys
    });
    let scene = format!("wrong = {{ {keys} last = 1 }}\n{SCENE}");
    let refused = parse("scenes/x.toml", &scene).unwrap_err();
    assert!(refused.to_string().len() < 1_000);

    let lines = keys.replace(", ", "\n");
    let scene = format!("{lines}\n{SCENE}");
    let Err(SceneErrors::Invalid { errors, left_out }) = parse("scenes/x.toml", &scene) else {
        panic!("accepted");
    };
    assert_eq!((errors.len(), left_out), (50, 19_950));
    let places: Vec<usize> = errors.iter().map(|error| error.line).collect();
    assert_eq!(places, (1..=50).collect::<Vec<_>>());
    let text = SceneErrors::Invalid { errors, left_out }.to_string();
    assert!(text.ends_with("and 19950 more errors"), "{text}");
}

#[test]
fn of_a_very_long_line_only_what_surrounds_the_error_is_shown() {
    let digits = "01".repeat(500);
    let text = refusal(
        r#"{ family = "gold", degree = 5 }"#,
        &format!(r#"{{ family = "chips", chips = "{digits}", index = 3 }}"#),
    );
    insta::assert_snapshot!(text, @r#"
    scenes/x.toml:7:1048: source.code.index: `index` does not belong to family "chips"; leave it out
      7 | ... 1010101010101010101010101010101010101010101010101", index = 3 }
        |                                                                 ^
    "#);
}

#[test]
fn of_a_very_long_value_only_start_and_end_are_quoted() {
    let text = refusal(r#""8 ns""#, &format!(r#""8 {}""#, "n".repeat(100_000)));
    assert!(text.len() < 2_000, "{text}");
    assert!(text.contains("a time takes fs, ps, ns, us, ms, s, min or h"), "{text}");
}

#[test]
fn very_many_tables_are_refused_with_the_limit() {
    let path = "[[path]]\nsource = \"laser\"\ndetector = \"spad\"\ndistance = \"3.2 m\"\n";
    let text = refusal("[scan]", &format!("{}\n[scan]", path.repeat(256)));
    insta::assert_snapshot!(text, @r#"
    scenes/x.toml:16:1: path: 257 tables [[path]] are more than 256; use fewer
      16 | [[path]]
         | ^^^^^^^^
    "#);
}

#[test]
fn codes_that_fill_the_memory_together_are_refused() {
    let source = |i: u32| {
        format!(
            "[[source]]\nname = \"s{i}\"\nwavelength = \"783 nm\"\nmean_power = \"1 pW\"\n\
             code = {{ family = \"m-sequence\", degree = 16, interleave = 8 }}\n\n"
        )
    };
    let sources: String = (0..4).map(source).collect();
    insta::assert_snapshot!(refusal("[[detector]]", &format!("{sources}[[detector]]")), @r#"
    scenes/x.toml:23:1: source: with this source the scene's codes have 50330911 chips in all, more than 33554432; use fewer sources, smaller degrees or interleaving depths
      23 | [[source]]
         | ^^^^^^^^^^
    "#);
}

#[test]
fn a_name_among_very_many_is_not_answered_with_all_of_them() {
    let source = |i: u32| {
        format!(
            "[[source]]\nname = \"s{i}\"\nwavelength = \"783 nm\"\nmean_power = \"1 pW\"\n\
             code = {{ family = \"square\" }}\n\n"
        )
    };
    let sources: String = (0..99).map(source).collect();
    let scene = SCENE.replace("[[detector]]", &format!("{sources}[[detector]]"));
    let text = parse("scenes/x.toml", &scene.replace("source = \"laser\"", "source = \"sun\""))
        .unwrap_err()
        .to_string();
    assert!(text.contains("or one of 68 more"), "{text}");
}
