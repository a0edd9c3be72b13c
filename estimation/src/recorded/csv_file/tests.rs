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

/// The file of these bytes; line 0 where it is not text.
fn read(bytes: &[u8]) -> Result<CountsFile, Wrong> {
    let decoded = decoded(bytes.to_vec()).map_err(|error| (0, error.to_string()))?;
    CountsFile::of("lab.csv", decoded)
}

/// What it has of a sensor.
fn recorded(bytes: &[u8], sensor: &Sensor) -> Result<RecordedCounts, Wrong> {
    read(bytes)?.recorded(sensor).map_err(|error| match error {
        CountsError::Invalid { line, problem, .. } => (line, problem),
        CountsError::Unreadable { source, .. } => panic!("it was read: {source}"),
    })
}

fn scans(text: &str, sensor: &Sensor) -> Vec<RecordedScan> {
    match recorded(text.as_bytes(), sensor) {
        Ok(RecordedCounts::Scans(scans)) => scans,
        other => panic!("{other:?}"),
    }
}

fn wrong(text: &str) -> Wrong {
    recorded(text.as_bytes(), &quick()).expect_err("it is wrong")
}

fn utf16(text: &str, bytes_of: fn(u16) -> [u8; 2]) -> Vec<u8> {
    format!("\u{feff}{text}").encode_utf16().flat_map(bytes_of).collect()
}

#[test]
fn counts_come_into_their_places_in_whatever_form_the_file_has() {
    let scene = quick();
    let right = scans(&file(), &scene);
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
        assert_eq!(scans(&text, &scene), right);
    }
}

/// As spreadsheets write it in other countries, and programs that know no whole numbers.
#[test]
fn encodings_delimiters_and_decimal_signs_are_found_in_the_file() {
    let sensor = quick();
    let right = RecordedCounts::Scans(scans(&file(), &sensor));
    let semicolons = file().replace(',', ";");
    let decimals = |sign: char| {
        let rows = (0..248).map(|k| format!("{k}{sign}0;{k}{sign}00\r\n"));
        format!("phase_step;count\r\n{}", rows.collect::<String>())
    };
    let tabs = file().replace(',', "\t");
    for text in [
        semicolons.clone(),
        tabs.clone(),
        format!("sep=;\r\n{}", semicolons.replace('\n', "\r\n")),
        format!("\"sep=;\"\n{semicolons}"),
        format!("SEP=\t\n{tabs}"),
        format!("{semicolons};\n;\n"),
        format!("# oscilloscope 3\n\n{}", file()),
        decimals(','),
        decimals('.'),
        file().replace('\n', "\r"),
        file().replace("\n17,17\n", "\n1.7e1,+17\n"),
    ] {
        assert_eq!(recorded(text.as_bytes(), &sensor).as_ref(), Ok(&right), "{text}");
        for bytes_of in [u16::to_le_bytes, u16::to_be_bytes] {
            assert_eq!(recorded(&utf16(&text, bytes_of), &sensor).as_ref(), Ok(&right));
        }
    }
    // Distances of 0.149896229 m for each ns, with a decimal comma.
    let of_row = |row: &str| {
        let text = format!("phase_step;distance_m;count\n{row}\n");
        recorded(text.as_bytes(), &sensor).unwrap_err().1
    };
    let offset_m = calibration_offset_ps(&sensor, DetectorIndex(0), CountingTier::Sampled);
    let at_m = 0.149_896_229 * (8.0 - offset_m * 1e-3);
    let told = of_row(&format!("8;{at_m:.6};-14").replace('.', ","));
    assert!(told.contains("247 of the scan's 248 phase steps"), "{told}");
    assert!(of_row("8;1,19;-14").contains("another scene"));
}

#[test]
fn how_a_file_was_understood_is_told() {
    let text = "sep=;\r\n\r\nphase_step;distance_m;counts\r\n7;1,5;3\r\n9;1,5;3\r\n;;\r\n";
    let file = read(&utf16(text, u16::to_le_bytes)).unwrap();
    let expected = "lab.csv is understood as
  encoding      UTF-16LE, with a byte order mark
  delimiter     semicolon, named on line 1
  decimal sign  ,
  heading       line 3
  column 1      phase_step  phase step, from 0 on in a code period
  column 2      distance_m  distance that the phase step stands for, in metres; checked
  column 3      counts      not known
  rows          2, phase steps 7 to 9
";
    assert_eq!(file.to_string(), expected);
}

#[test]
fn what_is_no_text_in_columns_is_refused_by_its_name() {
    let sensor = quick();
    let spaces = file().replace(',', " ");
    let of = |bytes: &[u8]| recorded(bytes, &sensor).unwrap_err();
    for (bytes, line, says) in [
        (spaces.into_bytes(), 1, "\"phase_step count\" has neither comma, semicolon nor tab"),
        (b"# by hand\nphase_step|count\n".to_vec(), 2, "neither comma"),
        (b"sep=|\nphase_step|count\n".to_vec(), 1, "\"sep=|\": only a comma"),
        (utf16(&file(), u16::to_le_bytes)[2..].to_vec(), 0, "UTF-16 without a byte order mark"),
        (utf16(&file(), u16::to_le_bytes)[..9].to_vec(), 0, "its text is not"),
        (b"phase_step,count,detector\n0,0,Ger\xe4t\n".to_vec(), 0, "byte 33"),
        (b"phase_step;count;distance_m\n0;1,0;1.5\n".to_vec(), 2, "with decimal commas"),
        (b"phase_step,distance_m,count\n0,\"1,5\",0\n".to_vec(), 2, "with a comma"),
        (b"phase_step;count\n0;12.000\n".to_vec(), 2, "which is 12 or 12000"),
        (b"phase_step;count\n0;-1,000\n".to_vec(), 2, "which is 1 or 1000"),
        (b"phase_step;count\n0;1,234\n".to_vec(), 2, "count is \"1,234\"; write a whole number"),
    ] {
        let (at, problem) = of(&bytes);
        assert!(at == line && problem.contains(says), "{at}: {problem}");
    }
}

/// A line, what stands there, what is written in its place, and what is said of it.
const MISTAKES: [(u64, &str, &str, &str); 15] = [
    (1, "phase_step,count", "phase_step,counts", "no column is called \"counts\""),
    (1, "phase_step,count", "phase_step,phase_step", "two columns are called"),
    (1, "phase_step,count", "phase_step,total_count", "has no column count"),
    (5, "\n3,3\n", "\n3,3,3\n", "3 fields here, the heading has 2"),
    (5, "\n3,3\n", "\n3\n", "1 fields here, the heading has 2"),
    (5, "\n3,3\n", "\n3,3.5\n", "count is \"3.5\"; write a whole number"),
    (5, "\n3,3\n", "\n3,\n", "count is \"\""),
    (7, "\n3,3\n", "\n\n# gap\n3,\n", "count is \"\""),
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
        let mistaken = text.replacen(from, to, 1);
        for text in [&mistaken, &mistaken.replace('\n', "\r\n"), &mistaken.replace('\n', "\r")] {
            let (found, problem) = wrong(text);
            assert!(problem.contains(told), "{told}: {problem}");
            assert_eq!(found, line, "{problem}");
        }
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

/// A file of two detectors with these counts of every phase step; of a sensor that has both.
fn of_two(counts: [fn(u64) -> u64; 2]) -> (Sensor, String) {
    let mut scene = scene::load(Path::new("../scenes/quick.toml")).unwrap();
    let mut other = scene.detectors.first().unwrap().clone();
    "apd".clone_into(&mut other.name);
    scene.detectors.push(other);
    let rows = |name: &str, count: fn(u64) -> u64| -> String {
        (0..248).map(|k| format!("{k},{},{name}\n", count(k))).collect()
    };
    let rows = [rows("spad", counts[0]), rows("apd", counts[1])].concat();
    (Sensor::new(&scene), format!("phase_step,count,detector\n{rows}"))
}

#[test]
fn the_counts_of_one_detector_are_not_taken_for_those_of_two() {
    let said = |counts| {
        let (sensor, text) = of_two(counts);
        recorded(text.as_bytes(), &sensor)
    };
    let (line, problem) = said([|k| k, |k| k]).expect_err("they are copies");
    assert_eq!(line, 497);
    assert!(problem.contains("\"spad\" and \"apd\""), "{problem}");
    // One number that differs, darkness, counters at a limit, a hit here and there.
    let few = |k: u64| u64::from(k.is_multiple_of(9));
    let clamped = |k: u64| if k < 40 { 9 } else { 0 };
    for counts in
        [[|k| k, |k| k + k / 247], [|_| 0, |_| 0], [|_| 9, |_| 9], [few, few], [clamped, clamped]]
    {
        let RecordedCounts::Scans(scans) = said(counts).unwrap() else { panic!("these are steps") };
        assert_eq!(scans.len(), 2);
    }
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
    let of = |text: &str| recorded(text.as_bytes(), &sensor).unwrap();
    let RecordedCounts::Histograms(right) = of(&file) else { panic!("these are bins") };
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
        assert_eq!(of(&text), RecordedCounts::Histograms(right.clone()));
    }
}

#[test]
fn what_is_wrong_with_bins_is_said_with_its_line() {
    let sensor = histogram_sensor();
    let plan = sensor.interface().histogram().unwrap();
    let (bins, periods) = (plan.bins(), plan.periods);
    let wrong = |text: &str| recorded(text.as_bytes(), &sensor).expect_err("it is wrong");
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
    assert!(wrong("phase_step,count\nbin,1\n").1.contains("phase_step is \"bin\""));
    let of_steps = Sensor::new(&scene::load(Path::new("../scenes/quick.toml")).unwrap());
    let (line, problem) = recorded(right.as_bytes(), &of_steps).expect_err("it correlates");
    assert!(line == 1 && problem.contains("architecture = \"histogram\""));
}

/// Counts of one scan are not taken for the sums of several.
#[test]
fn counts_of_other_chips_than_the_scenes_are_refused() {
    let rows: String = (0..248).map(|k| format!("{k},{k},2511\n")).collect();
    let text = format!("phase_step,count,integration_chips\n{rows}");
    let with = |scans: u32| {
        quick().with(|scene| {
            scene.hardware.accumulate = scans;
            scene.scan.integration_chips = 2511;
        })
    };
    assert_eq!(scans(&text, &with(1)), scans(&file(), &quick()));
    let (line, problem) = recorded(text.as_bytes(), &with(4).summed()).expect_err("one scan");
    assert_eq!(line, 2);
    assert!(problem.contains("is of 2511 chips, and a step of this scene has 10044"), "{problem}");
    assert!(problem.contains("'scan.integration=20088 ns'"), "{problem}");
}
