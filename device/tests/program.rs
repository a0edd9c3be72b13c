//! The program at a pseudo-terminal, at whose other end a device is simulated.

use std::fs::{self, File, OpenOptions};
use std::io::{Read, Write};
use std::path::Path;
use std::process::{Command, Output};
use std::thread;

use goldtof_system::digest::sha256;
use goldtof_wire::{
    Content, Identity, Layout, REQUEST_BYTES, REQUEST_HITS, REQUEST_IDENTITY, Request,
    ResultsFrame, encode,
};
use parquet::file::reader::{FileReader as _, SerializedFileReader};
use parquet::record::Field;
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{Winsize, tcsetwinsize};

const SCENE: &str = "# a scene\n";

fn identity() -> Identity {
    Identity {
        content: Content::Counts,
        layout: Layout { count_bits: 17, counts: 1, more_bits: 16 },
        detectors: 1,
        samples_per_chip: 8,
        chip_period_fs: 8_000_000,
        first_step: 0,
        steps: 248,
        code_chips: 31,
        parallel: 1,
        accumulate: 1,
        text_blocks: 0,
        counts_samples: false,
        scene: hash(SCENE),
    }
}

/// The first bytes of a scene's digest.
fn hash(scene: &str) -> [u8; 8] {
    let digits = sha256(scene);
    std::array::from_fn(|k| {
        u8::from_str_radix(&digits[2 * k..2 * k + 2], 16).expect("they are digits")
    })
}

/// A pseudo-terminal: the device's end, and the name of the host's.
fn line() -> (File, String) {
    let far = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC)
        .expect("a pseudo-terminal");
    grantpt(&far).expect("it can be granted");
    unlockpt(&far).expect("it can be unlocked");
    let name = ptsname(&far, Vec::new()).expect("it has a name");
    (File::from(far), name.into_string().expect("it is text"))
}

/// Result `index` of scan `scan`: count and total.
fn result(scan: u32, index: u32) -> u128 {
    u128::from(scan * 1000 + index) | u128::from(2 * index) << 17
}

/// Sends so many scans of [`result`], of which the third frame of each is torn; and is unplugged.
fn device(far: File, scans: u32) {
    send(far, &identity(), scans, true, result);
}

/// Answers who it is, then sends scans in frames of 62 results; and is unplugged.
fn send(
    mut far: File,
    identity: &Identity,
    scans: u32,
    is_torn: bool,
    result: impl Fn(u32, u32) -> u128,
) {
    let mut request = [0; REQUEST_BYTES];
    // The terminal is the host's from its first request on.
    far.read_exact(&mut request).expect("a request");
    let asked = Request { kind: REQUEST_IDENTITY, tag: request[2], address: 0 };
    assert_eq!(encode::request(asked, 0), request);
    let mut sequence = 0_u8;
    far.write_all(&encode::identity(asked, identity, sequence)).expect("it goes");
    for scan in 0..scans {
        for first in (0..248).step_by(62) {
            sequence = sequence.wrapping_add(1);
            let results = (first..first + 62).map(|index| result(scan, index)).collect();
            let frame = ResultsFrame {
                index: first,
                last: first == 186,
                results,
                ..ResultsFrame::default()
            };
            let mut bytes = encode::results(&frame, sequence, identity.layout);
            if is_torn && first == 124 {
                bytes.drain(40..50);
            }
            far.write_all(&bytes).expect("it goes");
        }
    }
    // What is not read when the terminal goes is lost, as it is with an adapter's cable.
    thread::sleep(std::time::Duration::from_millis(500));
}

fn program(folder: &Path, port: &str, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_goldtof-device"))
        .args(arguments)
        .args(["--port", port])
        .current_dir(folder)
        .output()
        .expect("the program is there")
}

#[test]
fn an_unplugged_device_leaves_every_count_that_came_and_every_loss() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    fs::write(folder.path().join("scene.toml"), SCENE).expect("it can be written");
    let (far, port) = line();
    let simulated = thread::spawn(move || device(far, 20));
    let arguments = ["record", "--scene", "scene.toml", "--out", "counts.csv"];
    let output = program(folder.path(), &port, &arguments);
    simulated.join().expect("the device is content");
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{said}{errors}");
    assert!(
        errors.starts_with("error: the device is gone (unplugged, or its line was closed): "),
        "{errors}"
    );
    assert!(said.contains("lost 20 frames, 1240 results; dropped 0; torn 20, doubled 0"), "{said}");
    assert!(said.ends_with("3720 results in counts.csv\n"), "{said}");

    let csv = fs::read_to_string(folder.path().join("counts.csv")).expect("it is there");
    let mut lines = csv.lines();
    assert_eq!(lines.next(), Some("time_s,scan,detector,phase_step,count,total_count"));
    for scan in 0..20 {
        for index in (0..124).chain(186..248) {
            let line = lines.next().expect("a line");
            let (_, fields) = line.split_once(',').expect("fields");
            assert_eq!(fields, format!("{scan},0,{index},{},{}", scan * 1000 + index, 2 * index));
        }
    }
    assert_eq!(lines.next(), None);
    let losses =
        fs::read_to_string(folder.path().join("counts.csv.losses.csv")).expect("it is there");
    assert_eq!(losses.lines().count(), 21);
    assert!(losses.lines().skip(1).all(|line| line.ends_with(",1,62,0")), "{losses}");

    // What is there is not written over.
    let (far, port) = line();
    let simulated = thread::spawn(move || device(far, 0));
    let output = program(folder.path(), &port, &arguments);
    simulated.join().expect("the device is content");
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(
        errors.contains("counts.csv") && errors.contains("; name another file, or remove it"),
        "{errors}"
    );
}

/// A device of two detectors with four samples each. With each read a sample of place p has 10 p + 1 hits more,
/// and counts go round in the second one.
fn counts_samples(mut far: File, identity: &Identity, reads: u32) {
    let mut request = [0; REQUEST_BYTES];
    far.read_exact(&mut request).expect("a request");
    let asked = Request { kind: REQUEST_IDENTITY, tag: request[2], address: 0 };
    far.write_all(&encode::identity(asked, identity, 0)).expect("it goes");
    for read in 0..reads {
        far.read_exact(&mut request).expect("a request");
        let asked = Request { kind: REQUEST_HITS, tag: request[2], address: 0 };
        assert_eq!(encode::request(asked, 0), request);
        let mut block = [0; 32];
        for (place, bytes) in (0..8).zip(block.chunks_mut(4)) {
            let count = (u32::MAX - 15).wrapping_add(read * (10 * place + 1));
            bytes.copy_from_slice(&count.to_le_bytes());
        }
        far.write_all(&encode::block(asked, &block, read as u8 + 1)).expect("it goes");
    }
    // What is not read when the terminal goes is lost.
    thread::sleep(std::time::Duration::from_millis(500));
}

#[test]
fn hits_by_sample_of_several_detectors_and_recordings() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut scene =
        fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../scenes/quick.toml"))
            .expect("it is there");
    scene += "\n[[detector]]\nname = \"far\"\nreference = \"laser\"\n";
    fs::write(folder.path().join("scene.toml"), &scene).expect("it can be written");
    let identity = Identity {
        detectors: 2,
        samples_per_chip: 4,
        counts_samples: true,
        scene: hash(&scene),
        ..identity()
    };
    let run = |extra: &[&str], reads| {
        let (far, port) = line();
        let simulated = thread::spawn(move || counts_samples(far, &identity, reads));
        let arguments = ["samples", "--out", "dark.csv", "--seconds", "0.2", "--runs", "2"];
        let output = program(folder.path(), &port, &[&arguments, extra].concat());
        let _ = simulated.join();
        output
    };
    // Names of detectors are in the scene alone.
    let errors = run(&[], 0).stderr;
    let errors = String::from_utf8_lossy(&errors);
    assert_eq!(
        errors,
        "error: the device has 2 detectors, whose names are in its scene: name it by --scene\n"
    );
    let output = run(&["--scene", "scene.toml"], 3);
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(said.ends_with("576 hits in dark.csv\n"), "{said}{output:?}");
    let mut expected = "detector,run,sample,count\n".to_owned();
    for run in 0..2 {
        for place in 0..8 {
            let detector = if place < 4 { "spad" } else { "far" };
            expected += &format!("{detector},{run},{},{}\n", place % 4, 10 * place + 1);
        }
    }
    let csv = fs::read_to_string(folder.path().join("dark.csv")).expect("it is there");
    assert_eq!(csv, expected);
}

#[test]
fn another_scenes_device_is_refused() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    fs::write(folder.path().join("other.toml"), "# another scene\n").expect("it can be written");
    let (far, port) = line();
    let simulated = thread::spawn(move || device(far, 0));
    let output = program(folder.path(), &port, &["identify", "--scene", "other.toml"]);
    simulated.join().expect("the device is content");
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1));
    assert!(
        errors.starts_with("error: the device was built from another scene: its hash begins with "),
        "{errors}"
    );
}

#[test]
fn wrong_addresses_and_ports_are_refused_in_words() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let output = program(folder.path(), "no-such-port", &["identify"]);
    assert!(String::from_utf8_lossy(&output.stderr).starts_with("error: no-such-port: "));
    let output = program(folder.path(), "p", &["read", "16x"]);
    assert!(String::from_utf8_lossy(&output.stderr).contains("write a number up to 0xffffffff"));
    // Polynomial 5,4,3,2,1,0 is x^5 + ... + 1, which divides x^6 - 1: a period of 6.
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/scenes/taps.toml");
    let write = ["write", "0x24", "0x3ff", "--scene", scene];
    let errors = program(folder.path(), "no-such-port", &write).stderr;
    let errors = String::from_utf8_lossy(&errors).into_owned();
    assert!(
        errors.starts_with(
            "error: TAPS of SEED_0 would be 0x1f, which is not a primitive polynomial of degree 5: "
        ),
        "{errors}"
    );
    let forced = program(folder.path(), "no-such-port", &[&write[..], &["--force"]].concat());
    assert!(String::from_utf8_lossy(&forced.stderr).starts_with("error: no-such-port: "));
}

/// A screen that is 110 columns wide and 34 lines high: the end that shows, and the program's.
fn screen() -> (File, File) {
    let (far, name) = line();
    let size = Winsize { ws_row: 34, ws_col: 110, ws_xpixel: 0, ws_ypixel: 0 };
    tcsetwinsize(&far, size).expect("it has a size");
    (far, OpenOptions::new().read(true).write(true).open(name).expect("it opens"))
}

/// A terminal's screen, of what a program sends there: text, moves of the cursor (`CSI row;column H`), all else
/// left out.
struct Shown {
    rows: Vec<Vec<char>>,
    at: (usize, usize),
    /// What has come of a sequence, from behind ESC on.
    sequence: Option<String>,
    bytes: Vec<u8>,
}

impl Shown {
    fn new() -> Shown {
        Shown { rows: vec![vec![' '; 110]; 34], at: (0, 0), sequence: None, bytes: Vec::new() }
    }

    fn take(&mut self, bytes: &[u8]) {
        self.bytes.extend(bytes);
        let whole = match str::from_utf8(&self.bytes) {
            Ok(text) => text.len(),
            Err(error) => error.valid_up_to(),
        };
        let rest = self.bytes.split_off(whole);
        let text = String::from_utf8(std::mem::replace(&mut self.bytes, rest)).expect("checked");
        text.chars().for_each(|letter| self.letter(letter));
    }

    fn letter(&mut self, letter: char) {
        match (&mut self.sequence, letter) {
            (Some(sequence), letter) if letter.is_ascii_alphabetic() => {
                if letter == 'H' {
                    let numbers = sequence.trim_start_matches('[').split(';');
                    let mut numbers =
                        numbers.map(|number| number.parse::<usize>().unwrap_or(1) - 1);
                    self.at = (numbers.next().unwrap_or(0), numbers.next().unwrap_or(0));
                }
                self.sequence = None;
            }
            (Some(sequence), letter) => sequence.push(letter),
            (None, '\u{1b}') => self.sequence = Some(String::new()),
            (None, '\r') => self.at.1 = 0,
            (None, '\n') => self.at.0 += 1,
            (None, letter) => {
                let (row, column) = self.at;
                if let Some(cell) = self.rows.get_mut(row).and_then(|row| row.get_mut(column)) {
                    *cell = letter;
                }
                self.at.1 += 1;
            }
        }
    }

    fn text(&self) -> String {
        self.rows.iter().map(|row| row.iter().collect::<String>() + "\n").collect()
    }
}

/// What a screen shows once it has these words.
fn shown(screen: &mut File, words: &str) -> String {
    let (mut shown, mut piece) = (Shown::new(), [0; 4096]);
    while !shown.text().contains(words) {
        let count =
            screen.read(&mut piece).unwrap_or_else(|error| panic!("{error}:\n{}", shown.text()));
        shown.take(&piece[..count]);
    }
    shown.text()
}

#[test]
fn the_view_has_the_estimators_distance_and_outlives_the_device() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenes/quick.toml");
    let text = fs::read_to_string(scene).expect("it is there");
    fs::write(folder.path().join("scene.toml"), &text).expect("it can be written");
    let layout = Layout { count_bits: 17, counts: 1, more_bits: 0 };
    let quick = Identity { layout, scene: hash(&text), ..identity() };
    // The correlation of a code of 31 chips with itself: a triangle of one chip on either side, and as good as
    // nothing elsewhere.
    let triangle = |_: u32, step: u32| u128::from(30 * 8_u32.saturating_sub(step.abs_diff(21)));
    let (far, port) = line();
    let simulated = thread::spawn(move || send(far, &quick, 20, false, triangle));
    let (mut screen, terminal) = screen();
    let again = || terminal.try_clone().expect("it can be shared");
    let mut program = Command::new(env!("CARGO_BIN_EXE_goldtof-device"))
        .args(["watch", "--scene", "scene.toml", "--out", "counts.csv", "--port", &port])
        .current_dir(folder.path())
        .stdin(again())
        .stdout(again())
        .stderr(again())
        .spawn()
        .expect("the program is there");
    drop(terminal);
    // Step 21 is 21 ns, of which 1.75 are the detector's, and 1 is that of samples: half of it is the wait for the next
    // one. 18.25 ns there and back are 2.736 m; the standard deviation is what `goldtof estimate` says of this scene.
    let text = shown(&mut screen, "gone: waiting for it");
    assert!(text.contains("peak 240 at step 21"), "{text}");
    assert!(text.contains("2.736 m +- 17 mm"), "{text}");
    simulated.join().expect("the device is content");
    screen.write_all(b"q").expect("a key");
    let text = shown(&mut screen, "4960 results in counts.csv");
    assert!(text.contains("20 scans"), "{text}");
    assert!(program.wait().expect("it ends").success());
}

#[test]
fn a_view_without_a_terminal_says_what_to_do() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let output = program(folder.path(), "p", &["watch"]);
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(errors, "error: `watch` needs a terminal; `record` says the same in lines\n");
}

#[test]
fn a_folder_of_parquet_files_has_the_rows_of_the_csv() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    fs::write(folder.path().join("scene.toml"), SCENE).expect("it can be written");
    for out in ["counts.csv", "counts.parquet"] {
        let (far, port) = line();
        let simulated = thread::spawn(move || device(far, 20));
        let output =
            program(folder.path(), &port, &["record", "--scene", "scene.toml", "--out", out]);
        simulated.join().expect("the device is content");
        let said = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(said.ends_with(&format!("3720 results in {out}\n")), "{said}");
        // A device that is gone is told though all of it is written.
        assert_eq!(output.status.code(), Some(1));
    }
    let csv = fs::read_to_string(folder.path().join("counts.csv")).expect("it is there");
    let files = fs::read_dir(folder.path().join("counts.parquet")).expect("it is there");
    let files: Vec<_> = files.map(|file| file.expect("it can be read").file_name()).collect();
    assert_eq!(files, ["000000.parquet"]);
    let file = File::open(folder.path().join("counts.parquet/000000.parquet")).expect("it opens");
    let reader = SerializedFileReader::new(file).expect("it is whole");
    let rows = reader.get_row_iter(None).expect("it has rows");
    let mut lines = csv.lines();
    let heading = lines.next().expect("a heading");
    let (mut before, mut number) = (0.0, 0);
    for (row, line) in rows.zip(lines) {
        let row = row.expect("it can be read");
        let (names, values): (Vec<_>, Vec<_>) = row.get_column_iter().unzip();
        assert_eq!(names.iter().map(|name| name.as_str()).collect::<Vec<_>>().join(","), heading);
        let Field::Double(time_s) = values[0] else { panic!("{row}") };
        // Seconds since 1970 that do not go back, of a year in which this was written or later.
        assert!(*time_s >= before && *time_s > 1.7e9, "{time_s}");
        before = *time_s;
        let numbers: Vec<String> = values[1..].iter().map(|value| value.to_string()).collect();
        assert_eq!(numbers.join(","), line.split_once(',').expect("fields").1);
        number += 1;
    }
    assert_eq!(number, 3720);
}
