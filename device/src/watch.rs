use std::fmt;
use std::time::{Duration, Instant};

use goldtof_wire::{Identity, ResultsFrame, Tally};

use crate::{Largest, ResultOrder};

/// How a measurement goes: the newest scan's largest count, the rate, and what is missing.
#[derive(Debug, Clone)]
pub struct Watch {
    identity: Identity,
    order: ResultOrder,
    began: Instant,
    /// Results since the last report, and when it was; bytes until then.
    results: u64,
    bytes: u64,
    reported: Instant,
    scans: u64,
    /// Of the result that comes next, unless one of this scan is missing.
    next_index: Option<u32>,
    /// Of each detector in this scan so far; phase step and count of the last whole one's.
    largest: Vec<Largest>,
    peak: Option<(u64, i64)>,
    overrun: bool,
    saturated: bool,
}

/// A line for a terminal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Report {
    /// Time since the beginning.
    pub elapsed: Duration,
    /// Scans of which every result came.
    pub scans: u64,
    /// Results per second since the last report.
    pub results_per_s: f64,
    /// Bytes per second since then, of whatever the line carried.
    pub bytes_per_s: f64,
    /// Phase step, count and distance in metres of the last scan's largest count, and a step in metres; none
    /// before a scan was whole, and where nothing stands out.
    pub peak: Option<(u64, i64, f64, f64)>,
    /// Flags of the core.
    pub overrun: bool,
    /// A count was saturated.
    pub saturated: bool,
    /// What came and what did not.
    pub tally: Tally,
}

impl Watch {
    /// Begins now.
    pub fn new(identity: Identity) -> Watch {
        let now = Instant::now();
        Watch {
            identity,
            order: ResultOrder::new(identity),
            began: now,
            results: 0,
            bytes: 0,
            reported: now,
            scans: 0,
            next_index: None,
            largest: Vec::new(),
            peak: None,
            overrun: false,
            saturated: false,
        }
    }

    /// Takes the results of a frame.
    pub fn results(&mut self, frame: &ResultsFrame) {
        if frame.index == 0 {
            self.largest.clear();
            self.next_index = Some(0);
        }
        // What is missing could have had the peak.
        let follows = self.next_index == Some(frame.index);
        self.next_index = follows.then(|| frame.index + frame.results.len() as u32);
        let largest = &mut self.largest;
        self.order.rows(frame, |row| {
            let detector = row.detector as usize;
            largest.resize(largest.len().max(detector + 1), Largest::default());
            largest[detector].take(row.phase_step, row.count);
        });
        self.results += frame.results.len() as u64;
        self.overrun |= frame.overrun;
        self.saturated |= frame.saturated;
        if frame.last && follows {
            self.scans += 1;
            let base = 2 * usize::from(self.identity.samples_per_chip);
            let peaks = largest.iter().filter_map(|largest| largest.peak(base));
            self.peak = peaks.max_by_key(|&(_, count)| count);
        }
    }

    /// How it goes since the last report, if that was `every` ago.
    pub fn report(&mut self, every: Duration, tally: Tally) -> Option<Report> {
        let since = self.reported.elapsed();
        if since < every {
            return None;
        }
        let per_s = |number: u64| number as f64 / since.as_secs_f64().max(1e-9);
        let results_per_s = per_s(std::mem::take(&mut self.results));
        let bytes_per_s = per_s(tally.bytes - std::mem::replace(&mut self.bytes, tally.bytes));
        self.reported = Instant::now();
        let peak = self.peak.map(|(step, count)| {
            let distance_m = |step: u64| self.identity.distance_m(step as f64);
            (step, count, distance_m(step), distance_m(1))
        });
        Some(Report {
            elapsed: self.began.elapsed(),
            scans: self.scans,
            results_per_s,
            bytes_per_s,
            peak,
            overrun: self.overrun,
            saturated: self.saturated,
            tally,
        })
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{:8.1} s  {:6} scans  {:8.0} results/s",
            self.elapsed.as_secs_f64(),
            self.scans,
            self.results_per_s
        )?;
        match self.peak {
            // Anywhere within the step: its standard deviation is that of a uniform number.
            Some((step, count, distance_m, step_m)) => {
                write!(
                    f,
                    "  peak {count} at step {step}: {distance_m:.3} +- {:.3} m",
                    step_m / 12_f64.sqrt()
                )?;
            }
            None if self.scans == 0 => write!(f, "  no whole scan yet")?,
            None => write!(f, "  no peak stands out")?,
        }
        let tally = &self.tally;
        write!(
            f,
            "  lost {} frames, {} results; dropped {}; torn {}, doubled {}",
            tally.lost_frames, tally.lost_results, tally.dropped, tally.torn, tally.doubled
        )?;
        if tally.uncertain > 0 {
            write!(f, "; {} losses of unknown size", tally.uncertain)?;
        }
        let flags = [(self.overrun, "OVERRUN"), (self.saturated, "SATURATED")];
        flags.iter().filter(|(is_set, _)| *is_set).try_for_each(|(_, name)| write!(f, "  {name}"))
    }
}
