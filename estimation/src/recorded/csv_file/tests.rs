use super::*;
use crate::scene;

fn quick() -> Sensor {
    Sensor::new(&scene::load(Path::new("../scenes/quick.toml")).unwrap())
}

/// A right file: 248 phase steps, whose counts are their numbers.
fn file() -> String {
    let rows = (0..248).map(|k| format!("{k},{k}\n"));
    format!("phase_step,count\n{}", rows.collect::<String>())
}

fn wrong(text: &str) -> Wrong {
    scans(text, &quick()).expect_err("it is wrong")
}

#[test]
fn counts_come_into_their_places_in_whatever_form_the_file_has() {
    let scene = quick();
    let right = scans(&file(), &scene).unwrap();
    assert_eq!(right.len(), 1);
    assert!(!right[0].has_totals);
    let signed: Vec<i64> = right[0].counts.iter().map(|count| count.signed).collect();
    assert_eq!(signed, (0..248).collect::<Vec<i64>>());
    // Line ends of Windows, a byte order mark, spaces, rows and columns in another
    // order, quotation marks, no line end at the end.
    let mut rows: Vec<&str> = file().leak().lines().skip(1).collect();
    rows.reverse();
    let reversed = format!("phase_step,count\n{}", rows.join("\n"));
    let swapped: String = (0..248).map(|k| format!("\"{k}\" , spad, {k}\r\n")).collect();
    for text in [
        file().replace('\n', "\r\n"),
        format!("\u{feff}{}", file()),
        reversed,
        format!("count,detector,phase_step\r\n{swapped}"),
    ] {
        assert_eq!(scans(&text, &scene).unwrap(), right);
    }
}

/// A line, what stands there, what is written in its place, and what is said of it.
const MISTAKES: [(u64, &str, &str, &str); 14] = [
    (1, "phase_step,count", "phase_step,counts", "no column is called \"counts\""),
    (1, "phase_step,count", "phase_step,phase_step", "two columns are called"),
    (1, "phase_step,count", "phase_step,total_count", "has no column count"),
    (5, "\n3,3\n", "\n3,3,3\n", "3 fields here, the heading has 2"),
    (5, "\n3,3\n", "\n3\n", "1 fields here, the heading has 2"),
    (5, "\n3,3\n", "\n3,3.5\n", "count is \"3.5\"; write a whole number"),
    (5, "\n3,3\n", "\n3,\n", "count is \"\""),
    (5, "\n3,3\n", "\n3,nan\n", "count is \"nan\""),
    (5, "\n3,3\n", "\n2,3\n", "phase step 2 of detector \"spad\" stands on line 4 already"),
    (5, "\n3,3\n", "\n248,3\n", "the scene's scan has no phase step 248"),
    (5, "\n3,3\n", "\n-1,3\n", "no phase step -1"),
    (5, "\n3,3\n", "\n3,10002\n", "at most 10001 detections"),
    (5, "\n3,3\n", "\n3,-99999999999999999999999999\n", "at most 10001 detections"),
    (248, "\n3,3\n", "\n", "1 of the scan's 248 phase steps of detector \"spad\" missing"),
];

#[test]
fn a_mistake_is_told_with_its_line_and_what_would_be_right() {
    for (line, from, to, told) in MISTAKES {
        let text = file();
        assert!(text.contains(from));
        let (found, problem) = wrong(&text.replacen(from, to, 1));
        assert!(problem.contains(told), "{told}: {problem}");
        assert_eq!(found, line, "{problem}");
    }
    assert_eq!(wrong("").0, 1);
    assert!(wrong("phase_step,count\n").1.contains("no counts"));
    let huge = format!("phase_step,count\n3,{}\n", "9".repeat(1000));
    assert!(wrong(&huge).1.len() < 200);
}

#[test]
fn counts_of_another_scene_are_told_by_their_own_columns() {
    let with = |heading: &str, row: &str| wrong(&format!("{heading}\n{row}\n")).1;
    let told = with("measurement,phase_step,count", "4,3,0");
    assert!(told.contains("another scene"), "{told}");
    let told = with("phase_step,distance_m,count", "8,99.0,0");
    assert!(told.contains("another scene"), "{told}");
    let told = with("phase_step,count,detector", "8,0,apd");
    assert!(told.contains("it has \"spad\""), "{told}");
}

#[test]
fn totals_and_counts_must_be_possible_together() {
    let with = |row: &str| wrong(&format!("phase_step,count,total_count\n{row}\n")).1;
    assert!(with("0,5,3").contains("it is 5 to 10001"));
    assert!(with("0,5,-7").contains("it is 5 to"));
    assert!(with("0,5,8").contains("do not belong together"));
    assert!(with("0,5,10003").contains("it is 5 to 10001"));
}

fn histogram_sensor() -> Sensor {
    let mut scene = scene::load(Path::new("../scenes/quick.toml")).unwrap();
    scene.hardware.architecture = scene::Architecture::Histogram;
    Sensor::new(&scene)
}

/// A right file: every bin counts its number modulo 3.
fn bins_file(bins: u64) -> String {
    let rows = (0..bins).map(|bin| format!("{bin},{}\n", bin % 3));
    format!("bin,count\n{}", rows.collect::<String>())
}

#[test]
fn bins_come_into_their_places_in_whatever_form_the_file_has() {
    let sensor = histogram_sensor();
    let plan = sensor.interface().histogram().unwrap();
    let file = bins_file(plan.bins());
    let right = histograms(&file, &sensor).unwrap();
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
        assert_eq!(histograms(&text, &sensor).as_ref(), Ok(&right));
    }
}

#[test]
fn what_is_wrong_with_bins_is_said_with_its_line() {
    let sensor = histogram_sensor();
    let plan = sensor.interface().histogram().unwrap();
    let (bins, periods) = (plan.bins(), plan.periods);
    let wrong = |text: &str| histograms(text, &sensor).expect_err("it is wrong");
    let right = bins_file(bins);
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
    let of_steps = Sensor::new(&scene::load(Path::new("../scenes/quick.toml")).unwrap());
    let (line, problem) = histograms(&right, &of_steps).expect_err("it correlates");
    assert!(line == 1 && problem.contains("architecture = \"histogram\""));
}
