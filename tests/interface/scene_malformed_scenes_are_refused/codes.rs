//! Codes that cannot be made.

use super::refusal;

#[test]
fn detectors_with_references_of_different_length() {
    insta::assert_snapshot!(
        refusal("[[path]]", "[[source]]\nname = \"other\"\ncode = { family = \"square\" }\nwavelength = \"783 nm\"\nmean_power = \"20 pW\"\n\n[[detector]]\nname = \"second\"\nreference = \"other\"\n\n[[path]]"),
        @r#"
    scenes/x.toml:24:13: detector.reference: this detector's reference code is 2 chips long, the first detector's 31; detectors are stepped together, so give them codes of one length
      24 | reference = "other"
         |             ^^^^^^^
    "#
    );
}

#[test]
fn an_unknown_family() {
    insta::assert_snapshot!(
        refusal(r#"family = "gold""#, r#"family = "golden""#),
        @r#"
    scenes/x.toml:7:19: source.code.family: "golden" is not known; did you mean "gold"?
      7 | code = { family = "golden", degree = 5 }
        |                   ^^^^^^^^
    "#
    );
}

#[test]
fn a_degree_without_preferred_pairs() {
    insta::assert_snapshot!(
        refusal("degree = 5", "degree = 8"),
        @r#"
    scenes/x.toml:7:36: source.code.degree: degree 8 has no preferred pair, because 4 divides it; use degree 7 or 9, or set allow_non_preferred = true
      7 | code = { family = "gold", degree = 8 }
        |                                    ^
    "#
    );
}

#[test]
fn a_degree_out_of_range() {
    insta::assert_snapshot!(
        refusal("degree = 5", "degree = 25"),
        @r#"
    scenes/x.toml:7:36: source.code.degree: 25 is outside 3 to 20; write for example 11
      7 | code = { family = "gold", degree = 25 }
        |                                    ^^
    "#
    );
}

#[test]
fn a_code_without_its_degree() {
    insta::assert_snapshot!(
        refusal(r#"{ family = "gold", degree = 5 }"#, r#"{ family = "gold" }"#),
        @r#"
    scenes/x.toml:7:8: source.code: family "gold" needs `degree`, for example degree = 11
      7 | code = { family = "gold" }
        |        ^^^^^^^^^^^^^^^^^^^
    "#
    );
}

#[test]
fn a_key_of_another_family() {
    insta::assert_snapshot!(
        refusal(r#"{ family = "gold", degree = 5 }"#, r#"{ family = "square", degree = 5 }"#),
        @r#"
    scenes/x.toml:7:38: source.code.degree: `degree` does not belong to family "square"; leave it out
      7 | code = { family = "square", degree = 5 }
        |                                      ^
    "#
    );
}

#[test]
fn an_index_outside_the_set() {
    insta::assert_snapshot!(
        refusal("degree = 5 }", "degree = 5, index = 31 }"),
        @r#"
    scenes/x.toml:7:47: source.code.index: index 31 is outside -2 to 30 (-2 is u, -1 is v, i is u XOR v advanced by i)
      7 | code = { family = "gold", degree = 5, index = 31 }
        |                                               ^^
    "#
    );
}

#[test]
fn a_pair_that_is_not_preferred() {
    insta::assert_snapshot!(
        refusal("degree = 5 }", "degree = 5, polynomials = [[5, 2, 0], [5, 3, 0]] }"),
        @r#"
    scenes/x.toml:7:53: source.code.polynomials: polynomials 5,2,0 and 5,3,0 are not a preferred pair: their cross-correlation takes 6 different values between -9 and 11, not just -9, -1 and 7; take another pair, or set allow_non_preferred = true
      7 | code = { family = "gold", degree = 5, polynomials = [[5, 2, 0], [5, 3, 0]] }
        |                                                     ^^^^^^^^^^^^^^^^^^^^^^
    "#
    );
}

#[test]
fn a_polynomial_that_is_not_primitive() {
    insta::assert_snapshot!(
        refusal("degree = 5 }", "degree = 5, polynomials = [[5, 1, 0], [5, 2, 0]] }"),
        @r#"
    scenes/x.toml:7:53: source.code.polynomials: polynomial 5,1,0 is not primitive; 5,2,0 is
      7 | code = { family = "gold", degree = 5, polynomials = [[5, 1, 0], [5, 2, 0]] }
        |                                                     ^^^^^^^^^^^^^^^^^^^^^^
    "#
    );
}

#[test]
fn exponents_in_the_wrong_order() {
    insta::assert_snapshot!(
        refusal("degree = 5 }", "degree = 5, polynomials = [[0, 2, 5], [5, 2, 0]] }"),
        @r#"
    scenes/x.toml:7:53: source.code.polynomials: polynomial 0,2,5 does not list exponents in descending order from the degree 5 down to 0, as 5,2,0 does
      7 | code = { family = "gold", degree = 5, polynomials = [[0, 2, 5], [5, 2, 0]] }
        |                                                     ^^^^^^^^^^^^^^^^^^^^^^
    "#
    );
}

#[test]
fn one_polynomial_for_two_registers() {
    insta::assert_snapshot!(
        refusal("degree = 5 }", "degree = 5, polynomials = [[5, 2, 0]] }"),
        @r#"
    scenes/x.toml:7:53: source.code.polynomials: family "gold" takes 2 polynomials, not 1
      7 | code = { family = "gold", degree = 5, polynomials = [[5, 2, 0]] }
        |                                                     ^^^^^^^^^^^
    "#
    );
}

#[test]
fn a_seed_of_zeros() {
    insta::assert_snapshot!(
        refusal("degree = 5 }", r#"degree = 5, seeds = ["00000", "11111"] }"#),
        @r#"
    scenes/x.toml:7:47: source.code.seeds: seed "00000" is all zero, and an LFSR never leaves that state; set at least one 1
      7 | code = { family = "gold", degree = 5, seeds = ["00000", "11111"] }
        |                                               ^^^^^^^^^^^^^^^^^^
    "#
    );
}

#[test]
fn a_seed_of_the_wrong_length() {
    insta::assert_snapshot!(
        refusal("degree = 5 }", r#"degree = 5, seeds = ["1111", "11111"] }"#),
        @r#"
    scenes/x.toml:7:47: source.code.seeds: seed "1111" is not 5 binary digits, first chip first, as "11111" is
      7 | code = { family = "gold", degree = 5, seeds = ["1111", "11111"] }
        |                                               ^^^^^^^^^^^^^^^^^
    "#
    );
}

#[test]
fn an_interleaving_depth_out_of_range() {
    insta::assert_snapshot!(
        refusal("degree = 5 }", "degree = 5, interleave = 9 }"),
        @r#"
    scenes/x.toml:7:52: source.code.interleave: 9 is outside 0 to 8; write for example 1
      7 | code = { family = "gold", degree = 5, interleave = 9 }
        |                                                    ^
    "#
    );
}

#[test]
fn chips_that_are_all_alike() {
    insta::assert_snapshot!(
        refusal(r#"{ family = "gold", degree = 5 }"#, r#"{ family = "chips", chips = "1111" }"#),
        @r#"
    scenes/x.toml:7:36: source.code.chips: all chips of this code are 1: it carries no time; use a code with both 0 and 1
      7 | code = { family = "chips", chips = "1111" }
        |                                    ^^^^^^
    "#
    );
}

#[test]
fn chips_that_come_again() {
    insta::assert_snapshot!(
        refusal(r#"{ family = "gold", degree = 5 }"#, r#"{ family = "chips", chips = "010010" }"#),
        @r#"
    scenes/x.toml:7:36: source.code.chips: this code repeats after 3 of its 6 chips, and two distances would look alike; give it once, as 3 chips
      7 | code = { family = "chips", chips = "010010" }
        |                                    ^^^^^^^^
    "#
    );
}

#[test]
fn chips_that_are_not_binary() {
    insta::assert_snapshot!(
        refusal(r#"{ family = "gold", degree = 5 }"#, r#"{ family = "chips", chips = "0120" }"#),
        @r#"
    scenes/x.toml:7:36: source.code.chips: chips may hold only the digits 0 and 1, as "0110" does, and at least one
      7 | code = { family = "chips", chips = "0120" }
        |                                    ^^^^^^
    "#
    );
}

#[test]
fn a_string_where_a_table_is_needed() {
    insta::assert_snapshot!(
        refusal(r#"{ family = "gold", degree = 5 }"#, r#""gold""#),
        @r#"
    scenes/x.toml:7:8: source.code: "gold" is a string, but a table is needed; write for example { family = "gold", degree = 11 }
      7 | code = "gold"
        |        ^^^^^^
    "#
    );
}
