//! Boards in simulation: the emitted top with models of the vendors' cells, photons at its pins, and a
//! host at its UART. What the host reads is what `goldtof run` counts.

use std::fs::{self, File, OpenOptions};
use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::os::unix::fs::OpenOptionsExt as _;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use goldtof_wire::{
    Decoder, Event, Frame, Identity, Layout, REQUEST_HITS, REQUEST_IDENTITY, REQUEST_READ,
    REQUEST_TEXT, REQUEST_WRITE, Request, encode,
};
use rustix::fs::OFlags;

use crate::hdl_support::{PLAIN_MAKE, goldtof};

/// A board's project, built for simulation, and what `goldtof run` counts of its scene.
struct Built {
    folder: tempfile::TempDir,
    manifest: serde_json::Value,
    /// Counts of the first scan, in the order of the steps.
    counts: Vec<i64>,
}

impl Built {
    /// Of the scene `quick` with other samples per chip and chip period.
    fn new(board: &str, settings: &[&str]) -> Built {
        Built::of("scenes/quick.toml", board, settings)
    }

    /// Of a scene like it.
    fn of(scene: &str, board: &str, settings: &[&str]) -> Built {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let out = folder.path().display().to_string();
        let project = folder.path().join("board");
        let mut arguments = vec!["emit", scene, "--board", board, "--out", &out];
        let settings: Vec<&str> = settings.iter().flat_map(|set| ["--set", *set]).collect();
        arguments.extend(&settings);
        did(&goldtof(&arguments));
        let scene = project.join("scene.toml").display().to_string();
        let photons = project.join("photons.bin").display().to_string();
        did(&goldtof(&[&["pulses", &scene, "--out", &photons][..], &samples(&settings)].concat()));
        let counted = folder.path().join("counted").display().to_string();
        did(&goldtof(&[&["run", &scene, "--out", &counted][..], &samples(&settings)].concat()));
        let made = Command::new("make")
            .args(["simulated_board", "OPTIMIZE=-O1"])
            .current_dir(&project)
            .env("MAKEFLAGS", PLAIN_MAKE)
            .output()
            .expect("make starts");
        did(&made);
        let manifest =
            fs::read(folder.path().join("manifest.json")).expect("the manifest is there");
        Built {
            manifest: serde_json::from_slice(&manifest).expect("it is JSON"),
            counts: counts(&folder.path().join("counted/counts.csv")),
            folder,
        }
    }

    fn project(&self) -> PathBuf {
        self.folder.path().join("board")
    }

    /// Starts the board with these options, and opens its line.
    fn start(&self, options: &[&str]) -> Running {
        let mut board = Command::new(self.project().join("simulated_board"))
            .args(["--photons", "photons.bin"])
            .args(options)
            .current_dir(self.project())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the board starts");
        let mut name = String::new();
        let stdout = board.stdout.take().expect("it is piped");
        BufReader::new(stdout).read_line(&mut name).expect("it names its terminal");
        let line = OpenOptions::new()
            .read(true)
            .write(true)
            .custom_flags(OFlags::NOCTTY.bits() as i32)
            .open(name.trim())
            .expect("the terminal can be opened");
        let layout = self.layout();
        Running { board, line, layout, decoder: Decoder::new(Some(layout)) }
    }

    /// The host reads what `goldtof run` counts, whose scene has the chip period that the PLL makes.
    fn is_read_as_run_counts(&self) {
        let mut running = self.start(&[]);
        let read = running.first_scan(self.counts.len());
        let said = running.stop();
        let identity = read.identity.expect("it was read");
        self.check_identity(&identity);
        // The file has one detector after another.
        let expected = (0..self.counts.len() as u64).map(|result| {
            let (detector, step) = identity.place(result);
            Some(self.counts[(detector * u64::from(identity.steps) + step) as usize])
        });
        assert_eq!((read.counts, read.lost_frames), (expected.collect(), 0), "{said}");
        // The chip period that the cells' dividers make.
        let chip_ns: f64 = said
            .strip_prefix("chip of ")
            .and_then(|rest| rest.split_once(" ns"))
            .and_then(|(number, _)| number.parse().ok())
            .unwrap_or_else(|| panic!("{said}"));
        let manifest_ps = self.manifest["board"]["chip_period_ps"].as_f64().expect("a number");
        assert!((chip_ns - manifest_ps / 1e3).abs() < 1e-6, "{chip_ns} ns, {manifest_ps} ps");
    }
    /// Bits of its results.
    fn layout(&self) -> Layout {
        let count_bits = self.manifest["parameters"]["count_bits"].as_u64().expect("a number");
        Layout { count_bits: count_bits as u8, counts: 1, more_bits: 0 }
    }

    /// What the device has to say of itself, by the manifest.
    fn check_identity(&self, identity: &Identity) {
        let parameter = |name: &str| &self.manifest["parameters"][name];
        assert_eq!(u64::from(identity.steps), parameter("phase_steps").as_u64().expect("a number"));
        assert_eq!(
            u64::from(identity.layout.count_bits),
            parameter("count_bits").as_u64().unwrap()
        );
        let chip_period_ps = self.manifest["board"]["chip_period_ps"].as_f64().expect("a number");
        assert_eq!(f64::from(identity.chip_period_fs), (chip_period_ps * 1e3).round());
        let sha256 = self.manifest["scene"]["sha256"].as_str().expect("a text");
        let scene: String = identity.scene.iter().map(|byte| format!("{byte:02x}")).collect();
        assert_eq!(scene, sha256[..16]);
    }
}

/// Settings but those of the chip period, which the board's scene has in its text.
fn samples<'s>(settings: &[&'s str]) -> Vec<&'s str> {
    let pairs = settings.chunks_exact(2);
    pairs.filter(|pair| !pair[1].starts_with("clock.chip_period")).flatten().copied().collect()
}

fn did(output: &std::process::Output) {
    let said = [&output.stdout, &output.stderr].map(|bytes| String::from_utf8_lossy(bytes));
    assert!(output.status.success(), "{}", said.concat());
}

fn counts(path: &Path) -> Vec<i64> {
    let text = fs::read_to_string(path).expect("counts.csv is there");
    let rows = text.lines().skip_while(|line| !line.starts_with("measurement")).skip(1);
    rows.map(|row| row.split(',').nth(3).and_then(|count| count.parse().ok()).expect("a count"))
        .collect()
}

/// A board that runs, and the host's end of its line.
struct Running {
    board: Child,
    line: File,
    layout: Layout,
    decoder: Decoder,
}

impl Running {
    fn ask(&mut self, bytes: &[u8]) {
        self.line.write_all(bytes).expect("the line takes them");
    }

    fn next(&mut self) -> Event {
        loop {
            if let Some(event) = self.decoder.next_event() {
                return event;
            }
            let mut bytes = [0; 4096];
            let count = self.line.read(&mut bytes).expect("the board is there");
            self.decoder.push(&bytes[..count]);
        }
    }

    /// The first results, of which none may be lost.
    fn counts(&mut self, count: usize) -> Vec<i64> {
        let mut counts = Vec::new();
        while counts.len() < count {
            match self.next() {
                Event::Frame(Frame::Results(frame)) => {
                    let results = frame.results.iter();
                    counts.extend(results.map(|result| self.layout.count(*result, 0)));
                }
                other => panic!("{other:?}"),
            }
        }
        counts.truncate(count);
        counts
    }

    /// Reads the first scan, and asks the device what it is until it says so.
    fn first_scan(&mut self, steps: usize) -> Read {
        let request = Request { kind: REQUEST_IDENTITY, tag: 7, address: 0 };
        let mut read = Read { counts: vec![None; steps], lost_frames: 0, identity: None };
        let (mut frames, mut next) = (0, 0);
        let mut is_first = true;
        while is_first || read.identity.is_none() {
            match self.next() {
                Event::Lost(loss) => read.lost_frames += loss.frames,
                Event::Frame(Frame::Results(frame)) => {
                    // A frame never has results of two scans.
                    let first = frame.index as usize;
                    is_first &= first >= next;
                    next = first + frame.results.len();
                    if is_first {
                        for (result, place) in frame.results.iter().zip(first..) {
                            read.counts[place] = Some(self.layout.count(*result, 0));
                        }
                    }
                    is_first &= !frame.last;
                    // The first one may fall into the board's reset, and others may be torn.
                    if frames % 8 == 0 && read.identity.is_none() {
                        let bytes = encode::request(request, 0);
                        self.ask(if frames % 16 == 0 { &bytes } else { &bytes[..6] });
                    }
                    frames += 1;
                }
                Event::Frame(Frame::Identity(asked, identity)) => {
                    assert_eq!(asked, request);
                    read.identity = Some(identity.expect("the device speaks our protocol"));
                }
                Event::Frame(other) => panic!("{other:?} was not asked for"),
            }
        }
        read
    }

    /// Asks until there is an answer, whose status has to be OKAY: a request may fall among torn ones.
    fn answer(&mut self, kind: u8, address: u16, data: u32) -> u32 {
        let request = Request { kind, tag: 9, address };
        for _ in 0..16 {
            self.ask(&encode::request(request, data));
            for _ in 0..64 {
                match self.next() {
                    Event::Frame(Frame::Answer(answer)) if answer.request == request => {
                        assert_eq!(answer.status, 0, "{answer:?}");
                        return answer.data;
                    }
                    _ => {}
                }
            }
        }
        panic!("no answer to {request:?}");
    }

    /// So many bytes of the scene's text, with zeros behind them.
    fn scene_text(&mut self, bytes: usize) -> Vec<u8> {
        let mut text = Vec::new();
        while text.len() < bytes {
            let request = Request { kind: REQUEST_TEXT, tag: 5, address: text.len() as u16 };
            self.ask(&encode::request(request, 0));
            // The first request may fall into the board's reset.
            let answer = (0..64).find_map(|_| match self.next() {
                Event::Frame(Frame::Block(asked, block)) if asked == request => Some(block),
                _ => None,
            });
            text.extend(answer.into_iter().flatten());
        }
        assert!(text[bytes..].iter().all(|&byte| byte == 0));
        text.truncate(bytes);
        text
    }

    /// Hits of the first detector by sample of the chip.
    fn hits(&mut self, samples: usize) -> Vec<u64> {
        let request = Request { kind: REQUEST_HITS, tag: 6, address: 0 };
        loop {
            self.ask(&encode::request(request, 0));
            for _ in 0..64 {
                match self.next() {
                    Event::Frame(Frame::Block(asked, block)) if asked == request => {
                        let words = block.chunks(4).take(samples);
                        return words
                            .map(|word| {
                                word.iter().rev().fold(0, |n, &byte| n << 8 | u64::from(byte))
                            })
                            .collect();
                    }
                    _ => {}
                }
            }
        }
    }

    /// Hangs up; what the board said.
    fn stop(mut self) -> String {
        drop(self.line);
        let mut said = String::new();
        let mut stderr = self.board.stderr.take().expect("it is piped");
        stderr.read_to_string(&mut said).expect("text");
        assert!(self.board.wait().expect("it ends").success(), "{said}");
        said
    }
}

/// What a host reads.
struct Read {
    /// The first scan, each result in its place, if it came.
    counts: Vec<Option<i64>>,
    lost_frames: u32,
    identity: Option<Identity>,
}

/// The counts of `goldtof run`, from where the first scan of a design with registers begins; its registers through the
/// bridge; and the scene's text, from the device itself.
#[test]
fn gowin_with_registers_and_the_scenes_text() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let scene = folder.path().join("quick.toml");
    let quick = fs::read_to_string("scenes/quick.toml").expect("it is there");
    let hardware = "\n[hardware]\nregisters = \"axi4-lite\"\nscene_text = true\n";
    fs::write(&scene, quick + hardware).expect("it can be written");
    let built = Built::of(scene.to_str().expect("text"), "tang-nano-9k", &[]);
    built.is_read_as_run_counts();
    let mut running = built.start(&[]);
    let text = fs::read(built.project().join("scene.toml")).expect("it is there");
    assert!(text.len() > 500);
    assert_eq!(running.scene_text(text.len()), text);
    assert_eq!(running.answer(REQUEST_READ, 0x000, 0), 0x676f_6c64);
    running.answer(REQUEST_WRITE, 0x018, 64);
    assert_eq!(running.answer(REQUEST_READ, 0x018, 0), 64);
    // Scans of 64 chips in place of 2,500, once the present one has ended; then none.
    running.answer(REQUEST_WRITE, 0x400, 0);
    running.stop();
}

/// A board that adds up three scans sends what the same board sends one by one, added up.
#[test]
#[ignore = "seconds: boards_checked has sums, of another board"]
fn gowin_with_sums_of_three_scans() {
    // 81 code periods.
    let integration = "scan.integration=20108 ns";
    let single = Built::new("tang-nano-9k", &[integration]);
    let scene = single.project().join("scene.toml").display().to_string();
    let photons = single.project().join("photons.bin").display().to_string();
    did(&goldtof(&["pulses", &scene, "--set", integration, "--scans", "3", "--out", &photons]));
    let mut running = single.start(&[]);
    let one_by_one: Vec<i64> = running.counts(3 * 248);
    running.stop();
    let expected: Vec<i64> =
        (0..248).map(|step| one_by_one.iter().skip(step).step_by(248).sum()).collect();
    assert!(expected.iter().max() > one_by_one[..248].iter().max());

    let summed = Built::new("tang-nano-9k", &[integration, "hardware.accumulate=3"]);
    fs::copy(&photons, summed.project().join("photons.bin")).expect("they can be copied");
    let mut running = summed.start(&[]);
    // Two bits for three of them.
    running.layout.count_bits += 2;
    running.decoder = Decoder::new(Some(running.layout));
    let sums = running.counts(248);
    running.stop();
    assert_eq!(sums, expected);
}

/// Of each sample of a chip as many hits as photons.bin has pulses that begin there.
#[test]
fn hits_by_sample_are_those_of_the_photons() {
    let settings: [(&str, usize, &[&str]); 2] = [
        ("tang-nano-9k", 8, &["hardware.sample_counts=true"]),
        (
            "arty-a7",
            4,
            &[
                "clock.samples_per_chip=4",
                "hardware.polarity=low",
                "hardware.sample_counts=true",
                "hardware.registers=axi4-lite",
            ],
        ),
    ];
    for (board, samples, settings) in settings {
        let built = Built::new(board, settings);
        let photons = fs::read(built.project().join("photons.bin")).expect("it is there");
        let mut expected = vec![0; samples];
        let mut until = 0;
        for pulse in photons.chunks_exact(16) {
            let number = |bytes: &[u8]| bytes.iter().rev().fold(0, |n, &b| n << 8 | u64::from(b));
            let (first, length) = (number(&pulse[..8]), number(&pulse[8..12]));
            // Pulses that touch are one.
            if first > until || until == 0 {
                expected[first as usize % samples] += 1;
            }
            until = until.max(first + length);
        }
        assert!(expected.iter().sum::<u64>() > 1000, "{expected:?}");
        let mut running = built.start(&[]);
        // Behind the photons' scan there is no light. Before, counting has stopped for a moment.
        running.counts(2 * built.counts.len());
        let hits = running.hits(samples);
        running.stop();
        assert_eq!(hits, expected, "{board}");
    }
}

/// A sampler with uneven bins, dark counts at its pin, and the widths that `goldtof calibrate` finds of what the board
/// counts: 4 % and more off even ones, each within its interval, which is some 2 % to either side.
#[test]
fn a_boards_dark_counts_give_the_widths_of_the_scene() {
    let widths = [1.1, 0.9, 1.05, 0.95, 1.0, 1.04, 0.86, 1.1];
    let built = Built::new(
        "tang-nano-9k",
        &[
            "hardware.sample_counts=true",
            "detector.sampler={ widths = [1.1, 0.9, 1.05, 0.95, 1.0, 1.04, 0.86, 1.1] }",
            "detector.dark_count_rate=10 Mcps",
            "source.mean_power=0 W",
            "scan.integration=50 us",
        ],
    );
    let mut running = built.start(&[]);
    running.counts(2 * built.counts.len());
    let hits = running.hits(8);
    running.stop();
    let rows = hits.iter().enumerate().map(|(sample, hits)| format!("{sample},{hits}\n"));
    let dark = built.folder.path().join("dark.csv");
    fs::write(&dark, format!("sample,count\n{}", rows.collect::<String>())).expect("it is written");
    let scene = built.project().join("scene.toml").display().to_string();
    let found = goldtof(&["calibrate", &scene, &dark.display().to_string(), "--json"]);
    did(&found);
    let found: serde_json::Value = serde_json::from_slice(&found.stdout).expect("it is JSON");
    let bins = found["samplers"][0]["samples"].as_array().expect("samples");
    assert_eq!(bins.len(), 8, "{found}");
    let sample_ps = built.manifest["board"]["chip_period_ps"].as_f64().expect("a number") / 8.0;
    for (width, bin) in widths.iter().zip(bins) {
        let ends = [0, 1].map(|end| bin["width_ps_ci95"][end].as_f64().expect("a number"));
        let [least, most] = ends.map(|end| end / sample_ps);
        assert!(least < *width && *width < most, "{width}: {least} .. {most}");
        assert!(most - least < 0.045, "{width}: {least} .. {most}");
    }
}

#[test]
fn ecp5_with_two_pins_and_a_line_that_loses_bytes() {
    let built = Built::new("ulx3s-85f", &[]);
    built.is_read_as_run_counts();
    let mut running = built.start(&["--lose", "97"]);
    let read = running.first_scan(built.counts.len());
    running.stop();
    assert!(read.lost_frames > 0, "nothing was lost");
    let came = read.counts.iter().zip(&built.counts).filter(|(count, _)| count.is_some());
    assert!(came.clone().count() > 10, "{:?}", read.counts);
    for (step, (count, expected)) in came.enumerate() {
        assert_eq!(*count, Some(*expected), "step {step}");
    }
}
