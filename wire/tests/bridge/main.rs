//! The bridge of hdl/bridge/ in Verilator, both directions, with clocks that have nothing to do with each other:
//! results that go in against what the host's decoder reads off the line, requests against what an AXI4-Lite
//! slave sees. `bench.cpp` is the other end of every wire; it checks AXI's rules, and hears and
//! speaks by a clock of its own.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::process::Command;

use goldtof_wire::{
    Answer, Content, Decoder, Event, Frame, Identity, Layout, REQUEST_IDENTITY, REQUEST_READ,
    REQUEST_TEXT, REQUEST_WRITE, Request, Tally, encode,
};
use tempfile::TempDir;

mod counting;
#[path = "../noise/mod.rs"]
mod noise;
mod sums;

use noise::Noise;

/// Runs a tool, which has to succeed.
fn run(folder: &Path, tool: &str, arguments: &[&str]) -> String {
    let output = Command::new(tool)
        .args(arguments)
        .current_dir(folder)
        .output()
        .unwrap_or_else(|error| panic!("{tool} is needed for this test: {error}"));
    let said = [output.stdout, output.stderr].concat();
    let said = String::from_utf8_lossy(&said).into_owned();
    assert!(output.status.success(), "{tool} {arguments:?} failed:\n{said}");
    said
}

/// Sources of the bridge with one of its memories.
fn sources(memory: &str) -> Vec<String> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../hdl/bridge");
    let list = fs::read_to_string(folder.join("bridge.f")).expect("the list is there");
    let names = list.lines().map(str::to_owned).chain([format!("{memory}/bridge_memory.v")]);
    names.map(|name| folder.join(name).display().to_string()).collect()
}

/// A bridge with these parameters.
#[derive(Debug, Clone, Copy)]
struct Bridge {
    top: &'static str,
    memory: &'static str,
    tdata_bits: u32,
    layout: Layout,
    /// Bits from one count to the next.
    stride: u32,
    more_first_bit: u32,
    back_pressure: bool,
    clocks_per_bit: u64,
    address_bits: u32,
    frame_results: u32,
    /// Periods in ps.
    clk_ps: u64,
    uart_clk_ps: u64,
    /// The scene's text in it.
    text: &'static str,
    /// Scans that are added up before it; `layout` is that of the sums, all else of one scan.
    sums: Option<Summed>,
}

/// Parameters of `result_accumulator`.
#[derive(Debug, Clone, Copy)]
struct Summed {
    scans: u32,
    scans_bits: u8,
    results: u32,
    results_bits: u32,
}

impl Summed {
    /// Bits of a result of one scan.
    fn of_one(self, sum: Layout) -> Layout {
        let less = |bits: u8| bits.saturating_sub(self.scans_bits);
        Layout { count_bits: less(sum.count_bits), more_bits: less(sum.more_bits), ..sum }
    }
}

/// Counts of 17 bits in 24, at 125 MHz and 16 clocks of 48 MHz.
const BRIDGE: Bridge = Bridge {
    top: "uart_bridge_axil",
    memory: "inferred",
    tdata_bits: 24,
    layout: Layout { count_bits: 17, counts: 1, more_bits: 0 },
    stride: 24,
    more_first_bit: 0,
    back_pressure: false,
    clocks_per_bit: 16,
    address_bits: 10,
    frame_results: 255,
    clk_ps: 8000,
    uart_clk_ps: 20_834,
    text: "",
    sums: None,
};

/// A result as it is offered, and after how many clocks.
#[derive(Debug, Clone, Copy)]
struct Offer {
    wait: u32,
    tdata: u128,
    last: bool,
}

/// What came of a run.
struct Outcome {
    line: Vec<u8>,
    /// What the bench says of each transfer.
    transfers: Vec<String>,
    /// From the end of the first byte to that of the last one.
    busy_ps: u64,
    stalled_clocks: u64,
    /// Bytes without a stop bit.
    broken_bytes: u64,
}

/// A bridge, built.
struct Model {
    bridge: Bridge,
    folder: TempDir,
}

impl Bridge {
    fn identity(&self) -> Identity {
        Identity {
            content: Content::Counts,
            layout: self.layout,
            detectors: 1,
            samples_per_chip: 8,
            chip_period_fs: 8_000_000,
            first_step: 3,
            steps: 16_376,
            code_chips: 2047,
            parallel: 1,
            accumulate: 1,
            text_blocks: self.text.len().div_ceil(32) as u8,
            counts_samples: false,
            scene: *b"\x01\x23\x45\x67\x89\xab\xcd\xef",
        }
    }

    fn parameters(&self) -> Vec<(&'static str, String)> {
        let identity = self.identity().to_verilog();
        if let Some(sums) = self.sums {
            let one = sums.of_one(self.layout);
            let numbers = [
                ("TDATA_BITS", self.tdata_bits),
                ("COUNT_BITS", one.count_bits.into()),
                ("MORE_FIRST_BIT", self.more_first_bit),
                ("MORE_BITS", one.more_bits.into()),
                ("SCANS", sums.scans),
                ("SCANS_BITS", sums.scans_bits.into()),
                ("RESULTS", sums.results),
                ("RESULTS_BITS", sums.results_bits),
                ("CLOCKS_PER_BIT", self.clocks_per_bit as u32),
                ("ADDRESS_BITS", self.address_bits),
                ("FRAME_RESULTS", self.frame_results),
            ];
            let numbers = numbers.map(|(name, value)| (name, value.to_string()));
            return numbers.into_iter().chain([("IDENTITY", identity)]).collect();
        }
        let numbers = [
            ("TDATA_BITS", self.tdata_bits),
            ("COUNT_BITS", self.layout.count_bits.into()),
            ("COUNTS", self.layout.counts.into()),
            ("COUNT_STRIDE", self.stride),
            ("MORE_FIRST_BIT", self.more_first_bit),
            ("MORE_BITS", self.layout.more_bits.into()),
            ("BACK_PRESSURE", self.back_pressure.into()),
            ("CLOCKS_PER_BIT", self.clocks_per_bit as u32),
            ("ADDRESS_BITS", self.address_bits),
            ("FRAME_RESULTS", self.frame_results),
        ];
        let numbers = numbers.map(|(name, value)| (name, value.to_string()));
        let text = encode::text_parameter(self.text).map(|(blocks, words)| {
            // Verilator takes a number, and no concatenation.
            let digits: String = words.iter().map(|word| &word["256'h".len()..]).collect();
            let text = format!("{}'h{digits}", 256 * u32::from(blocks));
            [("TEXT_BLOCKS", blocks.to_string()), ("TEXT", text)]
        });
        let all = numbers.into_iter().chain([("IDENTITY", identity)]);
        all.chain(text.into_iter().flatten()).collect()
    }

    /// Builds the model. A wrapper sets the parameters, so that what is built has the same name always.
    fn build(self) -> Model {
        self.build_with(None)
    }

    /// The same with another text of the accumulator.
    fn build_with(self, accumulator: Option<&str>) -> Model {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let bench = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/bridge/bench.cpp");
        let mut arguments: Vec<String> = [
            "--cc",
            "--exe",
            "--build",
            "--prefix",
            "Vbridge",
            "--x-initial",
            "unique",
            "--x-assign",
            "unique",
            "--top-module",
            self.top,
            "--Mdir",
            "model",
            "-o",
            "bench",
            "-Wno-fatal",
            "-Wno-WIDTH",
            "-CFLAGS",
        ]
        .map(str::to_owned)
        .into();
        arguments
            .push(if self.top == "uart_bridge_axil" { "-O1 -DAXIL" } else { "-O1" }.to_owned());
        arguments.extend(self.parameters().iter().map(|(name, value)| format!("-G{name}={value}")));
        arguments.extend(sources(self.memory));
        if !self.text.is_empty() {
            let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../hdl/bridge/scene_text.v");
            arguments.push(file.display().to_string());
        }
        if self.sums.is_some() {
            let source = |name: &str| Path::new(env!("CARGO_MANIFEST_DIR")).join(name);
            arguments.push(source("tests/bridge/summing_bridge.v").display().to_string());
            let mut file = source("../hdl/bridge/result_accumulator.v");
            if let Some(text) = accumulator {
                file = folder.path().join("result_accumulator.v");
                fs::write(&file, text).expect("it can be written");
            }
            arguments.push(file.display().to_string());
        }
        if self.memory == "ecp5" {
            let model = Path::new(env!("CARGO_MANIFEST_DIR")).join("../hdl/models/DP16KD.v");
            arguments.push(model.display().to_string());
        }
        arguments.push(bench.display().to_string());
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        run(folder.path(), "verilator", &arguments);
        Model { bridge: self, folder }
    }

    /// The bits of `s_axis_tdata` that the host gets, packed.
    fn packed(&self, tdata: u128) -> u128 {
        let field = |first: u32, bits: u8| tdata >> first & ((1 << bits) - 1);
        let Layout { count_bits, counts, more_bits } = self.layout;
        let counts_of = (0..counts).map(|k| {
            field(u32::from(k) * self.stride, count_bits) << (u32::from(k) * u32::from(count_bits))
        });
        let packed: u128 = counts_of.sum();
        if more_bits == 0 {
            return packed;
        }
        packed
            | field(self.more_first_bit, more_bits) << (u32::from(counts) * u32::from(count_bits))
    }

    /// Results of scans of `scan` results, with up to `wait` clocks before each.
    fn offers(&self, count: usize, scan: usize, wait: u64, noise: &mut Noise) -> Vec<Offer> {
        let mask = if self.tdata_bits == 128 { u128::MAX } else { (1 << self.tdata_bits) - 1 };
        let offer = |number: usize| {
            let random = (u128::from(noise.next()) << 64) | u128::from(noise.next());
            // Now and then bytes that look like a frame's beginning.
            let tdata = if noise.below(5) == 0 {
                0xa543_a543_a543_a543_a543_a543_a543_a543
            } else {
                random
            };
            Offer {
                wait: noise.below(wait + 1) as u32,
                tdata: tdata & mask,
                last: (number + 1).is_multiple_of(scan),
            }
        };
        (0..count).map(offer).collect()
    }
}

impl Model {
    /// Runs it. `rates` are the host's clocks for what it sends and reads, 1 for the device's.
    fn run(&self, offers: &[Offer], host: &str, rates: (f64, f64), seed: u32) -> Outcome {
        let folder = self.folder.path();
        let mut results = String::new();
        for offer in offers {
            let words =
                (0..self.bridge.tdata_bits.div_ceil(32)).map(|k| (offer.tdata >> (32 * k)) as u32);
            let words: String = words.map(|word| format!(" {word:x}")).collect();
            let _ = writeln!(results, "{}{words} {}", offer.wait, u8::from(offer.last));
        }
        fs::write(folder.join("results.txt"), results).expect("it can be written");
        fs::write(folder.join("host.txt"), host).expect("it can be written");
        let bit_ps = (self.bridge.clocks_per_bit * self.bridge.uart_clk_ps) as f64;
        let arguments = [
            self.bridge.clk_ps,
            self.bridge.uart_clk_ps,
            (bit_ps * rates.0) as u64,
            (bit_ps * rates.1) as u64,
            seed.into(),
        ];
        let output = Command::new(folder.join("model/bench"))
            .args(arguments.map(|number| number.to_string()))
            .current_dir(folder)
            .output()
            .expect("the bench is there");
        let said = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(output.status.success(), "{said}");
        let numbers: Vec<u64> =
            said.split_whitespace().map(|number| number.parse().expect(&said)).collect();
        let transfers = fs::read_to_string(folder.join("axi.txt")).unwrap_or_default();
        Outcome {
            line: fs::read(folder.join("line.bin")).expect("it is there"),
            transfers: transfers.lines().map(str::to_owned).collect(),
            busy_ps: numbers[0],
            stalled_clocks: numbers[1],
            broken_bytes: numbers[2],
        }
    }

    fn bit_ps(&self) -> u64 {
        self.bridge.clocks_per_bit * self.bridge.uart_clk_ps
    }
}

impl Outcome {
    /// What the host's decoder makes of the line.
    fn events(&self, layout: Layout) -> (Vec<Event>, Tally) {
        let mut decoder = Decoder::new(Some(layout));
        decoder.push(&self.line);
        let events = std::iter::from_fn(|| decoder.next_event()).collect();
        (events, decoder.tally())
    }

    /// Share of the time from the first byte to the last in which the line carried bytes.
    fn share_of_line(&self, model: &Model) -> f64 {
        (self.line.len() as u64 - 1) as f64 * 10.0 * model.bit_ps() as f64 / self.busy_ps as f64
    }
}

/// Results of the frames, and where each is in its scan.
fn results(events: &[Event]) -> Vec<(u64, u128)> {
    let frames = events.iter().filter_map(|event| match event {
        Event::Frame(Frame::Results(frame)) => Some(frame),
        _ => None,
    });
    frames
        .flat_map(|frame| {
            let places = u64::from(frame.index)..;
            places.zip(frame.results.iter().copied()).collect::<Vec<_>>()
        })
        .collect()
}

/// A request as the bench speaks it.
fn spoken(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |text, byte| text + &format!("byte {byte:02x}\n"))
}

/// Bridges with other widths, clocks and memories.
fn bridges() -> Vec<Bridge> {
    vec![
        BRIDGE,
        // The core slower than the line's clock; a DP16KD.
        Bridge {
            memory: "ecp5",
            clk_ps: 40_000,
            uart_clk_ps: 10_006,
            clocks_per_bit: 33,
            ..BRIDGE
        },
        // The fewest clocks in a bit, the smallest FIFO; counts and totals, of bits that are no whole bytes.
        Bridge {
            tdata_bits: 40,
            layout: Layout { count_bits: 18, counts: 1, more_bits: 16 },
            more_first_bit: 24,
            clocks_per_bit: 4,
            uart_clk_ps: 83_334,
            address_bits: 5,
            frame_results: 16,
            ..BRIDGE
        },
        // Rows of a histogram: eight bins of 3 bits in bytes.
        Bridge {
            memory: "ecp5",
            tdata_bits: 64,
            layout: Layout { count_bits: 3, counts: 8, more_bits: 0 },
            stride: 8,
            back_pressure: true,
            address_bits: 11,
            ..BRIDGE
        },
        // Both on one clock, results of one bit.
        Bridge {
            tdata_bits: 8,
            layout: Layout { count_bits: 1, counts: 1, more_bits: 0 },
            clk_ps: 20_834,
            clocks_per_bit: 8,
            ..BRIDGE
        },
    ]
}

#[test]
fn every_result_comes_through_and_every_request_is_answered() {
    for (number, bridge) in bridges().into_iter().enumerate() {
        let model = bridge.build();
        let mut noise = Noise(number as u64 + 1);
        let bit_clocks = model.bit_ps() / bridge.clk_ps;
        // A little less than the line carries.
        let wait = bit_clocks * (bridge.layout.result_bits() as u64 + 10) * 4;
        let offers = bridge.offers(1000, 450, wait, &mut noise);
        let mut host = String::from("bits 300\n");
        let (mut expected, mut transfers) = (Vec::new(), Vec::new());
        let mut words = std::collections::BTreeMap::new();
        for tag in 0..60_u8 {
            let address = if noise.below(8) == 0 { 0x800 } else { 4 * noise.below(4) as u16 };
            let kind = [REQUEST_READ, REQUEST_WRITE, REQUEST_IDENTITY][noise.below(3) as usize];
            let request = Request { kind, tag, address };
            let data = noise.below(1 << 32) as u32;
            let bytes = encode::request(request, data);
            match noise.below(6) {
                // Torn, and dropped after silence.
                0 => host += &spoken(&bytes[..1 + noise.below(12) as usize]),
                // A bit that is another one.
                1 => {
                    let mut wrong = bytes;
                    wrong[1 + noise.below(12) as usize] ^= 1 << noise.below(8);
                    host += &spoken(&wrong);
                }
                // A byte without its stop bit in the middle.
                2 => {
                    host +=
                        &format!("{}low 12\nbits 3\n{}", spoken(&bytes[..6]), spoken(&bytes[6..]))
                }
                _ => {
                    host += &spoken(&bytes);
                    let status = if address == 0x800 { 2 } else { 0 };
                    match kind {
                        REQUEST_IDENTITY => {
                            expected.push(Frame::Identity(request, Ok(bridge.identity())))
                        }
                        REQUEST_WRITE => {
                            transfers.push(format!("W {address:x} {data:x} {status:x}"));
                            if status == 0 {
                                words.insert(address, data);
                            }
                            expected.push(Frame::Answer(Answer { request, status, data: 0 }));
                        }
                        _ => {
                            let data = words
                                .get(&address)
                                .copied()
                                .unwrap_or(0xdead_0000 + u32::from(address));
                            transfers.push(format!("R {address:x} {data:x} {status:x}"));
                            expected.push(Frame::Answer(Answer { request, status, data }));
                        }
                    }
                }
            }
            // A whole frame may be on the line first.
            let _ = writeln!(
                host,
                "bits {}",
                300 + 10 * (14 + 16 + bridge.layout.payload_bytes(bridge.frame_results as usize))
            );
        }
        // The two clocks differ by up to 2 %.
        for (rates, seed) in [((0.98, 1.02), 1), ((1.02, 0.98), 2)] {
            let outcome = model.run(&offers, &host, rates, seed);
            let (events, tally) = outcome.events(bridge.layout);
            assert_eq!(
                (outcome.broken_bytes, tally.torn, tally.stray_bytes, tally.doubled),
                (0, 0, 0, 0),
                "bridge {number}"
            );
            assert!(!events.iter().any(|event| matches!(event, Event::Lost(_))), "bridge {number}");
            let came = results(&events);
            let went: Vec<_> = offers
                .iter()
                .enumerate()
                .map(|(k, offer)| (k as u64 % 450, bridge.packed(offer.tdata)))
                .collect();
            assert_eq!(came, went, "bridge {number}");
            let lasts = events
                .iter()
                .filter(|event| matches!(event, Event::Frame(Frame::Results(f)) if f.last));
            assert_eq!(lasts.count(), 2);
            let mut answers: Vec<Frame> = events
                .into_iter()
                .filter_map(|event| match event {
                    Event::Frame(Frame::Results(_)) | Event::Lost(_) => None,
                    Event::Frame(frame) => Some(frame),
                })
                .collect();
            for answer in &mut answers {
                if let Frame::Answer(answer) = answer
                    && answer.request.kind == REQUEST_WRITE
                {
                    answer.data = 0;
                }
            }
            assert_eq!(answers, expected, "bridge {number}");
            assert_eq!(outcome.transfers, transfers, "bridge {number}");
        }
    }
}

#[test]
fn what_the_line_is_too_slow_for_is_dropped_scan_by_scan_and_counted_and_the_line_stays_full() {
    for (number, (bridge, scan)) in
        [(BRIDGE, 3000), (Bridge { memory: "ecp5", ..BRIDGE }, 300), (bridges()[2], 77)]
            .into_iter()
            .enumerate()
    {
        let model = bridge.build();
        let mut noise = Noise(77 + number as u64);
        // Twice as fast as the line.
        let bit_clocks = model.bit_ps() / bridge.clk_ps;
        let wait = bit_clocks * bridge.layout.result_bits() as u64;
        let mut offers = bridge.offers(12_000 / scan * scan, scan, wait, &mut noise);
        // A loss is told with the result that comes next: the last scan comes late, and leaves time.
        for offer in offers.iter_mut().rev().take(scan) {
            offer.wait = 4 * wait as u32;
        }
        let last = offers.len() - scan;
        offers[last].wait = (wait << bridge.address_bits) as u32 * 2;
        let outcome = model.run(&offers, "", (1.0, 1.0), 5);
        assert_eq!(outcome.stalled_clocks, 0, "bridge {number}: the core waits");
        let (events, tally) = outcome.events(bridge.layout);
        assert_eq!(
            (tally.torn, tally.stray_bytes, tally.lost_frames, tally.lost_results),
            (0, 0, 0, 0)
        );
        assert_eq!(tally.results + tally.dropped, offers.len() as u64, "bridge {number}");
        assert!(tally.dropped > 3000, "bridge {number}: {tally:?}");

        // Each result is that of its place, and what is missing is what was told.
        let mut at = 0;
        for event in &events {
            match event {
                Event::Lost(loss) => {
                    assert_eq!((loss.frames, loss.results), (0, Some(0)));
                    at += loss.dropped as usize;
                    assert_eq!(at % scan, 0, "a scan that was dropped ends at its end");
                }
                Event::Frame(Frame::Results(frame)) => {
                    assert_eq!(frame.index as usize, at % scan);
                    for result in &frame.results {
                        assert_eq!(
                            *result,
                            bridge.packed(offers[at].tdata),
                            "bridge {number}, result {at}"
                        );
                        at += 1;
                    }
                    assert_eq!(frame.last, at % scan == 0);
                }
                Event::Frame(other) => panic!("{other:?}"),
            }
        }
        assert_eq!(at, offers.len());
    }
}

#[test]
fn a_source_that_waits_keeps_the_line_full_and_loses_nothing() {
    for (number, bridge) in
        [Bridge { back_pressure: true, ..BRIDGE }, bridges()[3]].into_iter().enumerate()
    {
        let model = bridge.build();
        let offers = bridge.offers(8000, 2047, 0, &mut Noise(99));
        let outcome = model.run(&offers, "", (1.0, 1.0), 7);
        let (events, tally) = outcome.events(bridge.layout);
        assert!(!events.iter().any(|event| matches!(event, Event::Lost(_))), "bridge {number}");
        let went: Vec<_> = offers
            .iter()
            .enumerate()
            .map(|(k, offer)| (k as u64 % 2047, bridge.packed(offer.tdata)))
            .collect();
        assert_eq!(results(&events), went, "bridge {number}");
        assert_eq!((tally.dropped, tally.torn), (0, 0));
        assert!(outcome.stalled_clocks > 100_000, "bridge {number}: nothing had to wait");
        let share = outcome.share_of_line(&model);
        println!("bridge {number}: {:.2} % of the line", 100.0 * share);
        assert!(share > 0.985, "bridge {number}: {share}");
    }
}

#[test]
fn a_reset_of_one_clock_begins_anew_on_both_sides() {
    for bridge in [BRIDGE, bridges()[1]] {
        let model = bridge.build();
        let bit_clocks = model.bit_ps() / bridge.clk_ps;
        let offers = bridge.offers(600, 100, 60 * bit_clocks, &mut Noise(5));
        let identify = encode::request(Request { kind: REQUEST_IDENTITY, tag: 9, address: 0 }, 0);
        // In the middle of a frame, and of a request.
        let host = format!(
            "bits 6000\nflags 3\nbits 3000\n{}reset\nbits 2000\nflags 0\n{}bits 3000\n",
            spoken(&identify[..7]),
            spoken(&identify)
        );
        let outcome = model.run(&offers, &host, (1.0, 1.0), 3);
        let (events, tally) = outcome.events(bridge.layout);
        assert_eq!(tally.stray_bytes.min(1), tally.torn.min(1), "{tally:?}");
        let frames: Vec<_> = events
            .iter()
            .filter_map(|event| match event {
                Event::Frame(Frame::Results(frame)) => Some(frame),
                _ => None,
            })
            .collect();
        // What was in the bridge is gone, and so is the bridge's memory of it.
        let anew = frames
            .iter()
            .rposition(|frame| frame.index == 0 && frame.lost == 0)
            .expect("there is one");
        assert!(anew > 0);
        assert!(frames.iter().any(|frame| frame.overrun && frame.saturated));
        assert!(frames.iter().all(|frame| frame.overrun == frame.saturated));
        assert!(!frames.last().expect("there are some").overrun);
        // What came at the end are the last results that went in.
        let came: Vec<u128> = frames.last().expect("there are some").results.clone();
        let went: Vec<u128> = offers
            .iter()
            .rev()
            .take(came.len())
            .rev()
            .map(|offer| bridge.packed(offer.tdata))
            .collect();
        assert_eq!(came, went);
        let identities =
            events.iter().filter(|event| matches!(event, Event::Frame(Frame::Identity(_, Ok(_)))));
        assert_eq!(identities.count(), 1);
    }
}

#[test]
fn a_bridge_without_registers_says_what_it_is_whatever_it_is_asked() {
    let bridge = Bridge { top: "uart_bridge", ..BRIDGE };
    let model = bridge.build();
    let mut host = String::new();
    let mut expected = Vec::new();
    for (tag, kind) in [REQUEST_IDENTITY, REQUEST_READ, REQUEST_WRITE].into_iter().enumerate() {
        let request = Request { kind, tag: tag as u8, address: 0x104 };
        let _ = writeln!(host, "{}bits 800", spoken(&encode::request(request, 12)));
        expected.push(Event::Frame(Frame::Identity(request, Ok(bridge.identity()))));
    }
    assert_eq!(model.run(&[], &host, (1.0, 1.0), 1).events(bridge.layout).0, expected);
}

#[test]
fn bridges_are_clean_under_three_tools_and_refuse_parameters_by_name() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for bridge in bridges() {
        for top in ["uart_bridge", "uart_bridge_axil"] {
            for memory in ["inferred", "ecp5"] {
                let mut files = sources(memory);
                if memory == "ecp5" {
                    files.push(format!("{}/../hdl/models/DP16KD.v", env!("CARGO_MANIFEST_DIR")));
                }
                let set = |prefix: &str| -> Vec<String> {
                    bridge
                        .parameters()
                        .iter()
                        .map(|(name, value)| format!("{prefix}{name}={value}"))
                        .collect()
                };
                let lint = ["--lint-only", "-Wall", "--top-module", top].map(str::to_owned);
                let arguments = [&lint[..], &set("-G"), &files].concat();
                let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
                assert_eq!(run(folder.path(), "verilator", &arguments), "", "{bridge:?}");
                let lint = ["-Wall", "-g2005", "-s", top, "-o", "lint.vvp"].map(str::to_owned);
                // Icarus takes no wide number on its command line.
                let numbers = set(&format!("-P{top}."))
                    .into_iter()
                    .filter(|set| !set.contains('\''))
                    .collect::<Vec<_>>();
                let arguments = [&lint[..], &numbers, &files].concat();
                let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
                assert_eq!(run(folder.path(), "iverilog", &arguments), "", "{bridge:?}");
            }
            let read = format!(
                "read_verilog {}; hierarchy -check -top {top}; proc; check -assert; select -assert-none t:$dlatch",
                sources("inferred").join(" ")
            );
            assert_eq!(run(folder.path(), "yosys", &["-q", "-p", &read]), "");
        }
    }
    for (parameter, what) in [
        ("COUNT_BITS=25", "counts_and_MORE_BITS_within_TDATA_BITS"),
        ("COUNTS=2", "counts_and_MORE_BITS_within_TDATA_BITS"),
        ("MORE_BITS=25", "counts_and_MORE_BITS_within_TDATA_BITS"),
        ("BACK_PRESSURE=2", "BACK_PRESSURE_of_0_or_1"),
        ("CLOCKS_PER_BIT=3", "CLOCKS_PER_BIT_of_4_to_65535"),
        ("ADDRESS_BITS=4", "ADDRESS_BITS_of_5_to_14"),
        ("FRAME_RESULTS=0", "FRAME_RESULTS_of_1_to_255_and_half_of_the_FIFO"),
        ("ADDRESS_BITS=8", "FRAME_RESULTS_of_1_to_255_and_half_of_the_FIFO"),
    ] {
        let files = sources("inferred");
        let set = format!("-Puart_bridge.{parameter}");
        let mut arguments = vec!["-g2005", "-s", "uart_bridge", &set, "-o", "stop.vvp"];
        arguments.extend(files.iter().map(String::as_str));
        let output = Command::new("iverilog")
            .args(&arguments)
            .current_dir(folder.path())
            .output()
            .expect("it starts");
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(
            !output.status.success() && said.contains(&format!("uart_bridge_needs_{what}")),
            "{parameter}: {said}"
        );
    }
}

/// A text of three blocks and five bytes.
const TEXT: &str = "# A scene of 101 bytes, which are three blocks and five bytes.\n[clock]\nchip_period = \"8 ns\" # of \u{b5}\n\n";

#[test]
fn a_host_reads_the_scenes_text_block_by_block() {
    assert_eq!(TEXT.len().div_ceil(32), 4);
    for bridge in [
        Bridge { text: TEXT, ..BRIDGE },
        Bridge { text: TEXT, top: "uart_bridge_axil", ..bridges()[2] },
    ] {
        let model = bridge.build();
        let bit_clocks = model.bit_ps() / bridge.clk_ps;
        let offers = bridge.offers(300, 100, 60 * bit_clocks, &mut Noise(8));
        let requests: Vec<Request> = [96, 0, 64, 32]
            .into_iter()
            .chain([0])
            .enumerate()
            .map(|(tag, address)| match tag {
                4 => Request { kind: REQUEST_IDENTITY, tag: 4, address },
                _ => Request { kind: REQUEST_TEXT, tag: tag as u8, address },
            })
            .collect();
        let pause = 600 + 10 * (14 + bridge.layout.payload_bytes(bridge.frame_results as usize));
        let mut host = String::from("bits 300\n");
        for request in &requests {
            host += &(spoken(&encode::request(*request, 0)) + &format!("bits {pause}\n"));
        }
        let outcome = model.run(&offers, &host, (1.0, 1.0), 3);
        let (events, tally) = outcome.events(bridge.layout);
        assert_eq!((tally.torn, tally.stray_bytes), (0, 0));
        let answers: Vec<&Frame> = events
            .iter()
            .filter_map(|event| match event {
                Event::Frame(frame) if !matches!(frame, Frame::Results(_)) => Some(frame),
                _ => None,
            })
            .collect();
        let expected: Vec<Frame> = requests
            .iter()
            .map(|&request| match request.kind {
                REQUEST_IDENTITY => Frame::Identity(request, Ok(bridge.identity())),
                _ => {
                    let mut block = [0; 32];
                    let bytes = TEXT.bytes().skip(request.address.into());
                    block.iter_mut().zip(bytes).for_each(|(place, byte)| *place = byte);
                    Frame::Block(request, block)
                }
            })
            .collect();
        assert_eq!(answers, expected.iter().collect::<Vec<_>>());
        assert!(outcome.transfers.is_empty());
    }
}
