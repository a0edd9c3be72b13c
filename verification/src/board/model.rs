//! A board's model: what it is made of, and a run of it.

use std::fmt::Write as _;
use std::fs;
use std::ops::RangeInclusive;
use std::process::{Command, Stdio};

use goldtof_wire::{CRC_BYTES, Identity, Layout, Pace, RESULTS_HEADER_BYTES, Scans};

use super::script::{BoardScript, Offer};
use crate::cosim::build::{self, BoardUnit, Built};
use crate::cosim::cache::{cache_dir, write};
use crate::cosim::error::{CosimError, When};
use crate::cosim::own::{self, OwnRtl};
use crate::cosim::source::{SourceFile, sources_of};
use crate::deliver::Emission;
use crate::deliver::board::{BENCH, BoardProject, CORE_BENCH};
use crate::programs;
use crate::sensor::Sensor;
use crate::sensor::interface::Interface;
use crate::sensor::port::PortRole;
use crate::wire::{Packing, ScanSums, Sent};

/// Files of a project that are not the board's own: they go with the simulation.
const CELLS: &str = "cells.v";
const TOP: &str = "simulated_board";
const HEADER: &str = "simulated_board.h";
/// Most results of a scan that is sent whole: they take the line's time.
pub(super) const MOST_PLACES: u64 = 1 << 14;
/// Most clocks of scans whose sums are there to be lost.
const MOST_CLOCKS_OF_LOSSES: u64 = 1 << 20;
/// Two losses of so many results go round the number of those that are lost.
pub(super) const HALF_ROUND: usize = 40_000;
/// `ADDRESS_BITS` of the bridge's FIFO (hdl/bridge).
const FIFO_ADDRESS_BITS: u32 = 10;

/// What is known of a board by its scene.
#[derive(Debug, Clone)]
pub struct Facts {
    /// Its name.
    pub board: String,
    /// How results of the core lie in its stream.
    pub packing: Packing,
    /// Results on the line.
    pub layout: Layout,
    /// Scans that are added up.
    pub sums: Option<ScanSums>,
    /// What the device says of itself.
    pub identity: Identity,
    /// The scene's text, if the device holds it.
    pub text: String,
    /// Whether the core has AXI4-Lite registers.
    pub has_registers: bool,
    /// Whether it flags a saturated count.
    pub has_saturated: bool,
    /// Results that the FIFO holds, log2.
    pub fifo_address_bits: u32,
    /// Chips in a bit of the line.
    pub chips_per_bit: f64,
    /// Periods of the line's clock in a bit.
    pub clocks_per_bit: u32,
    /// Lengths of a host's bits that the board has to receive, in bits of the line's nominal rate.
    pub host_bits: RangeInclusive<f64>,
    /// Results of a scan.
    pub results_of_scan: u64,
}

/// The project of an emission, which has one.
fn project_of(emission: &Emission) -> Result<&BoardProject, CosimError> {
    let missing =
        || CosimError::Option { option: "--board", reason: "no board is named".to_owned() };
    emission.board.as_ref().ok_or_else(missing)
}

impl Facts {
    /// Of an emission with a board.
    ///
    /// # Errors
    /// When it has none.
    pub fn of(sensor: &Sensor, emission: &Emission) -> Result<Facts, CosimError> {
        let project = project_of(emission)?;
        let interface = sensor.interface();
        let one = Interface { accumulate: 1, ..interface.clone() };
        // The plan has checked that there is a result that the line carries.
        let impossible = || CosimError::Option {
            option: "--board",
            reason: "the bridge has no such results".to_owned(),
        };
        let packing = Packing::of(&one, Sent::Results).ok_or_else(impossible)?;
        let sums = project.bench.sums;
        let has = |role| emission.ports.iter().any(|port| port.role == role);
        let identity = project.bench.identity.ok_or_else(impossible)?;
        Ok(Facts {
            board: project.name.clone(),
            packing,
            layout: sums.map_or(packing.layout, |sums| sums.sum),
            sums,
            identity,
            text: project.bench.text.clone(),
            has_registers: has(PortRole::WriteAddress),
            has_saturated: has(PortRole::Saturated),
            fifo_address_bits: sums.map_or(FIFO_ADDRESS_BITS, |sums| sums.fifo_address_bits),
            chips_per_bit: 1e12 / (project.chip_period_ps * f64::from(project.baud_hz)),
            clocks_per_bit: project.uart.clocks_per_bit,
            host_bits: project.uart.host_bits(project.baud_hz),
            results_of_scan: identity.results_of_scan(),
        })
    }
}

impl Facts {
    /// Whether results are dropped that the line is too slow for, and a run shows that.
    pub(super) fn loses(&self) -> bool {
        !self.packing.waits && self.sums.is_none_or(|sums| self.loses_sums(&sums))
    }

    /// Whether sums that come at once fill the FIFO so soon that hardly any of it has left by then.
    pub(super) fn loses_sums(&self, sums: &ScanSums) -> bool {
        let depth = 1 << self.fifo_address_bits;
        let clocks = u64::from(sums.scans) * (depth + 3 * sums.results);
        clocks <= MOST_CLOCKS_OF_LOSSES && 4.0 * clocks as f64 <= self.chips_of_results(depth)
    }

    /// Whether so many results are lost that their number goes round.
    pub(super) fn loses_a_round(&self) -> bool {
        let is_soon = |sums: ScanSums| {
            let lost = 2 * HALF_ROUND as u64;
            sums.results <= lost / 16 && u64::from(sums.scans) * lost <= MOST_CLOCKS_OF_LOSSES
        };
        self.loses() && self.sums.is_none_or(is_soon)
    }

    /// Bytes of a frame of so many results.
    pub(super) fn frame_bytes(&self, results: u64) -> usize {
        RESULTS_HEADER_BYTES + self.layout.payload_bytes(results as usize) + CRC_BYTES
    }

    /// Bits of results on a line that is full of them.
    pub(super) fn bits_of_results(&self, results: u64) -> f64 {
        // Of a scan that takes a second.
        let scans = Scans { layout: self.layout, results, period_s: 1.0 };
        // The rate is that of the line.
        scans.line_bits(Pace { baud: 0, clocks_per_bit: self.clocks_per_bit })
    }

    /// The same in chips.
    pub(super) fn chips_of_results(&self, results: u64) -> f64 {
        self.bits_of_results(results) * self.chips_per_bit
    }

    /// Samples of all detectors whose hits the board counts.
    pub(super) fn places_of_hits(&self) -> usize {
        let Identity { counts_samples, detectors, samples_per_chip, .. } = self.identity;
        if counts_samples { usize::from(detectors) * usize::from(samples_per_chip) } else { 0 }
    }
}

/// A board's model, built.
pub(super) struct BoardModel {
    built: Built,
}

/// Builds the board, with its core or with what stands in the core's place, and gives what was ignored of the
/// user's Verilog.
pub(super) fn build(
    sensor: &Sensor,
    emission: &Emission,
    own: &OwnRtl,
    is_bench: bool,
) -> Result<(BoardModel, Vec<String>), CosimError> {
    let project = project_of(emission)?;
    let cache = cache_dir()?;
    let defines = defines(sensor, emission, is_bench);
    let models = [CELLS, "simulated_board.v"];
    let mut ours: Vec<SourceFile> = sources_of(&project.files);
    ours.retain(|file| models.contains(&&*file.name));
    if is_bench {
        ours.push(SourceFile {
            name: "core_bench.sv".to_owned(),
            text: CORE_BENCH.to_owned(),
            origin: None,
        });
    }
    let (sources, remarks) = if own.is_given() {
        let mut others = vec![TOP, "cells"];
        others.extend(is_bench.then_some(crate::cosim::TOP));
        own::read_board(own, TOP, &ours, &others, &defines)?
    } else {
        let mut sources = ours;
        sources.extend(sources_of(&project.files).into_iter().filter(|file| {
            !models.contains(&&*file.name) && (file.is_compiled() || file.name.ends_with(".vh"))
        }));
        let core = sources_of(&emission.files).into_iter();
        sources.extend(core.filter(|file| !(is_bench && file.name == "sensor_top.v")));
        (sources, Vec::new())
    };
    let mut flags = project.bench.numbers.clone();
    if is_bench {
        let tdata_bits = sensor.interface().tdata_bits;
        flags.extend(["-DCORE_BENCH".to_owned(), format!("-DTDATA_BITS={tdata_bits}")]);
    }
    let header = project.files.iter().find(|file| file.name == HEADER);
    let unit = BoardUnit {
        top: TOP,
        sources: &sources,
        defines: &defines,
        flags: &flags,
        testbench: BENCH,
        header: (HEADER, header.map_or("", |file| &file.text)),
    };
    Ok((BoardModel { built: build::build_board(&unit, &cache)? }, remarks))
}

/// Macros: widths of the core's ports, and which it has.
fn defines(sensor: &Sensor, emission: &Emission, is_bench: bool) -> Vec<String> {
    let mut defines = vec!["SIMULATED_BENCH".to_owned()];
    if !is_bench {
        return defines;
    }
    let interface = sensor.interface();
    let samples = interface.lanes() as usize * interface.reference_codes.len();
    defines.push(format!("CORE_LASERS={}", interface.source_codes.len()));
    defines.push(format!("CORE_SAMPLES={samples}"));
    defines.push(format!("CORE_TDATA_BITS={}", interface.tdata_bits));
    for (role, name) in [
        (PortRole::Saturated, "CORE_HAS_SATURATED"),
        (PortRole::PeakValid, "CORE_HAS_PEAK"),
        (PortRole::WriteAddress, "CORE_HAS_REGISTERS"),
    ] {
        let is_there = emission.ports.iter().any(|port| port.role == role);
        defines.extend(is_there.then(|| name.to_owned()));
    }
    defines
}

/// What came of a run.
#[derive(Debug, Default)]
pub(super) struct BoardOutcome {
    /// Bytes of the line, parted by the resets.
    pub lines: Vec<Vec<u8>>,
    /// Results that the core had been rid of at each reset, and at the end.
    pub taken: Vec<usize>,
    /// Transfers at the core's registers, parted by the resets.
    pub transfers: Vec<Vec<String>>,
    /// Hits by sample at the core up to each change of the light, and to the end.
    pub hits: Vec<Vec<u64>>,
    /// Length of a chip, as the PLL makes it.
    pub chip_fs: u64,
    /// Chips.
    pub chips: u64,
    /// Bits of time from the first byte's end to the last one's.
    pub busy_bits: f64,
    /// Clocks that a result waited.
    pub stalled: u64,
    /// Bytes without a stop bit.
    pub broken: u64,
    /// The sample at the pins that is the first one behind the reset.
    pub first: Option<i64>,
    /// What the bench itself found.
    pub fault: Option<String>,
}

impl BoardModel {
    /// Runs a script.
    pub(super) fn run(&self, script: &BoardScript, seed: u64) -> Result<BoardOutcome, CosimError> {
        let folder = tempfile::tempdir().map_err(CosimError::memory(&self.built.path))?;
        let path = |name: &str| folder.path().join(name);
        write(&path("host.txt"), &script.host)?;
        write(&path("results.txt"), &offered(&script.offers))?;
        if let Some(photons) = &script.photons {
            let bytes: Vec<u8> = photons.iter().flat_map(|pulse| pulse.to_bytes()).collect();
            let file = path("photons.bin");
            fs::write(&file, bytes).map_err(CosimError::cache(&file))?;
        }
        let mut command = Command::new(self.built.image.path());
        command
            .arg(seed.to_string())
            .args([script.rates.0, script.rates.1].map(|rate| rate.to_string()))
            .arg(script.chips.to_string())
            .arg(script.first.to_string())
            .current_dir(folder.path());
        let finished = programs::run(&mut command, Stdio::piped(), programs::time_limit())
            .map_err(|source| CosimError::Load { path: self.built.path.clone(), source })?;
        let mut outcome = BoardOutcome::default();
        let written = |name: &str| {
            let file = path(name);
            fs::read(&file).map_err(CosimError::cache(&file))
        };
        let text = |name: &str| -> Result<String, CosimError> {
            Ok(String::from_utf8_lossy(&written(name)?).into_owned())
        };
        let said = text("report.txt")?;
        let fault = said.lines().find_map(|line| line.strip_prefix("fault "));
        // A board whose numbers contradict one another ends before the first clock.
        let fault = fault.or_else(|| finished.stderr.strip_prefix("simulated_board: "));
        match (finished.status.and_then(|status| status.code()), fault) {
            (Some(0), None) => {}
            (Some(1), Some(fault)) => {
                outcome.fault = Some(fault.trim().to_owned());
                return Ok(outcome);
            }
            _ => {
                let reason = format!("{}{}", finished.stdout, finished.stderr);
                return Err(CosimError::Halted { when: When::Start, reason });
            }
        }
        let line = written("line.bin")?;
        let (mut ends, mut transfers) = (Vec::new(), Vec::new());
        for line in said.lines() {
            let mut words = line.split(' ');
            let key = words.next().unwrap_or_default();
            let numbers: Vec<f64> = words.filter_map(|word| word.parse().ok()).collect();
            match (key, &numbers[..]) {
                ("reset", &[bytes, taken, before]) => {
                    ends.push(bytes as usize);
                    outcome.taken.push(taken as usize);
                    transfers.push(before as usize);
                }
                ("chip_fs", &[chip]) => outcome.chip_fs = chip as u64,
                ("chips", &[chips]) => outcome.chips = chips as u64,
                ("broken", &[broken]) => outcome.broken = broken as u64,
                ("busy_bits", &[bits]) => outcome.busy_bits = bits,
                ("stalled", &[clocks]) => outcome.stalled = clocks as u64,
                ("first", &[first]) => outcome.first = Some(first as i64),
                ("hits", hits) => {
                    outcome.hits.push(hits.iter().map(|&hits| hits as u64).collect());
                }
                _ => {}
            }
        }
        outcome.taken.push(script.offers.len());
        ends.push(line.len());
        outcome.lines = parted(&line, &ends);
        // What is in the core's place writes it.
        let told = if script.is_whole() { String::new() } else { text("axi.txt")? };
        let told: Vec<String> = told.lines().map(str::to_owned).collect();
        transfers.push(told.len());
        outcome.transfers = parted(&told, &transfers);
        Ok(outcome)
    }
}

/// What comes up to each of these ends, from the one before on.
fn parted<T: Clone>(all: &[T], ends: &[usize]) -> Vec<Vec<T>> {
    let begins = [0].iter().chain(ends);
    begins.zip(ends).map(|(&begin, &end)| all[begin..end].to_vec()).collect()
}

/// Results as the bench reads them.
fn offered(offers: &[Offer]) -> String {
    let mut text = String::new();
    for offer in offers {
        let words =
            offer.tdata.iter().fold(String::new(), |text, word| text + &format!(" {word:x}"));
        let _ = writeln!(text, "{}{words} {}", offer.wait, u8::from(offer.last));
    }
    text
}
