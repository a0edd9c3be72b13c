//! `goldtof codes` reports what is known of a code.

use goldtof::code::{CodeSpec, Family, parse_polynomials, parse_seeds, report as report_of};
use serde_json::{Value, json};

fn report(spec: CodeSpec) -> Value {
    serde_json::to_value(report_of(&spec).unwrap()).unwrap()
}

#[test]
fn a_gold_code_of_degree_11_has_the_interfaces_fields() {
    let report = report(CodeSpec { degree: Some(11), ..CodeSpec::new(Family::Gold) });
    assert_eq!(report["length_chips"], 2047);
    assert_eq!(report["polynomials"], json!([[11, 2, 0], [11, 8, 5, 2, 0]]));
    assert_eq!(report["autocorrelation"]["peak"], 2047);
    assert_eq!(report["autocorrelation"]["values"], json!([-65, -1, 63]));
    let chips = report["chips"].as_str().unwrap();
    assert_eq!(chips.len(), 2047);
    let ones = chips.matches('1').count();
    assert_eq!(report["weight_chips"], ones);
    assert_eq!(report["balanced"], ones == 1024);
    assert_eq!(report["gold_set"]["members"], 2049);
    assert_eq!(report["gold_set"]["balanced_members"], 1025);
}

#[test]
fn a_seven_chip_m_sequence_is_the_textbook_one() {
    let report = report(CodeSpec {
        degree: Some(3),
        polynomials: Some(parse_polynomials("3,1,0").unwrap()),
        seeds: Some(parse_seeds("100")),
        ..CodeSpec::new(Family::MSequence)
    });
    // c[t] = c[t-3] XOR c[t-1] from 1, 0, 0.
    assert_eq!(report["chips"], "1001110");
    assert_eq!(report["weight_chips"], 4);
    assert_eq!(report["balanced"], true);
    assert_eq!(report["autocorrelation"]["values"], json!([-1]));
    assert_eq!(report["autocorrelation"]["counts"], json!([6]));
    assert!(report["gold_set"].is_null());
}

#[test]
fn a_square_wave_has_two_chips_and_no_polynomial() {
    let report = report(CodeSpec::new(Family::Square));
    assert_eq!(report["chips"], "10");
    assert_eq!(report["autocorrelation"]["values"], json!([-2]));
    assert_eq!(report["polynomials"], json!([]));
}

#[test]
fn the_text_for_people_names_the_code_and_its_set() {
    let spec = CodeSpec { degree: Some(5), interleave: 1, ..CodeSpec::new(Family::Gold) };
    let text = report_of(&spec).unwrap().to_text();
    insta::assert_snapshot!(
        text,
        @r#"
    gold code of 62 chips, degree 5, index 0, interleaved to depth 1
    polynomial       5,2,0, seed 11111
    polynomial       5,4,3,2,0, seed 11111
    chips            01010101010101011001011001100101100101101010100110011001101001
    weight           31 (balanced)
    autocorrelation  peak 62, elsewhere -30 (2x), -18 (4x), -14 (2x), -6 (12x), -2 (16x), 2 (11x), 10 (4x), 14 (10x)
    Gold set         33 codes, 17 of them balanced; u and v are preferred, their cross-correlation -9 (6x), -1 (15x), 7 (10x) (t = 9)
    "#
    );
}
