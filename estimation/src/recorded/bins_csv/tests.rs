use std::path::Path;

use super::*;
use crate::scene;

fn sensor() -> Sensor {
    let mut scene = scene::load(Path::new("scenes/quick.toml")).unwrap();
    scene.hardware.architecture = scene::Architecture::Histogram;
    Sensor::new(&scene)
}

/// A right file: every bin counts its number modulo 3.
fn file(bins: u64) -> String {
    let rows = (0..bins).map(|bin| format!("{bin},{}\n", bin % 3));
    format!("bin,count\n{}", rows.collect::<String>())
}

#[test]
fn bins_come_into_their_places_in_whatever_form_the_file_has() {
    let sensor = sensor();
    let plan = sensor.interface().histogram.unwrap();
    let file = file(plan.bins());
    let right = parse(&file, &sensor).unwrap();
    let expected: Vec<u64> = (0..plan.bins()).map(|bin| bin % 3).collect();
    assert_eq!(right[0].histogram.bins(), expected);
    assert_eq!(right[0].histogram.periods(), plan.periods);
    let name = &sensor.scene().detectors[0].name;
    let swapped: String =
        (0..plan.bins()).rev().map(|bin| format!("{name}, {} ,\"{bin}\"\r\n", bin % 3)).collect();
    for text in [
        format!("\u{feff}{file}"),
        file.replace('\n', "\r\n"),
        format!("detector,count,bin\r\n{swapped}"),
    ] {
        assert!(has_bins(&text));
        assert_eq!(parse(&text, &sensor).as_ref(), Ok(&right));
    }
}

#[test]
fn what_is_wrong_is_said_with_its_line() {
    let sensor = sensor();
    let plan = sensor.interface().histogram.unwrap();
    let (bins, periods) = (plan.bins(), plan.periods);
    let wrong = |text: &str| parse(text, &sensor).expect_err("it is wrong");
    let right = file(bins);
    for (text, line, says) in [
        ("bin,counts\n".to_owned(), 1, "no column of bins is called \"counts\""),
        ("bin\n".to_owned(), 1, "has no column count"),
        ("bin,count,bin\n".to_owned(), 1, "two columns"),
        ("bin,count\n".to_owned(), 1, "has no bins"),
        (format!("{right}{bins},0\n"), bins + 2, "has no bin"),
        (format!("{right}-1,0\n"), bins + 2, "has no bin -1"),
        (format!("{right}3,0\n"), bins + 2, "stands on line 5 already"),
        (format!("bin,count\n0,{}\n", periods + 1), 2, "code periods of scan.integration"),
        ("bin,count\n0,-1\n".to_owned(), 2, "bin 0 counts -1"),
        ("bin,count\n0,1.5\n".to_owned(), 2, "write a whole number"),
        ("bin,count\n0\n".to_owned(), 2, "fields here"),
        (right.replace("\n7,1\n", "\n"), bins, "the first is 7"),
        ("bin,count,detector\n0,0,nobody\n".to_owned(), 2, "no detector \"nobody\""),
    ] {
        let (at, problem) = wrong(&text);
        assert!(at == line && problem.contains(says), "{at}: {problem}");
    }
    assert!(!has_bins("phase_step,count\nbin,1\n") && !has_bins(""));
    let of_steps = Sensor::new(&scene::load(Path::new("scenes/quick.toml")).unwrap());
    let (line, problem) = parse(&right, &of_steps).expect_err("it correlates");
    assert!(line == 1 && problem.contains("architecture = \"histogram\""));
}
