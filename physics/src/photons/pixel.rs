//! Several SPADs behind one input: a macropixel.
//!
//! Each cell is a detector of its own, with as large a share of the light, and dead time,
//! afterpulses, dark counts and jitter that are its alone; only crosstalk ties cells together. A
//! registered detection makes the cell's own pulse, of the detector's pulse width, and the level of
//! the input follows from how many cells' pulses there are at a time: what is counted, and sampled,
//! are that level's rising edges. Where each cell has an input, its own pulses are sampled. Pulses of the group of steps before do not reach into a group.

use std::collections::VecDeque;

use rand::RngExt as _;

use super::avalanches::Avalanches;
use super::detector::{DetectorCells, DetectorModel};
use super::random::{RandomStream, StreamKey, StreamRng};
use super::registration::{Detection, Registration};
use super::reorder::ReorderBuffer;
use super::time::ChipTime;

/// Pulses of a pixel's level in one group of phase steps, in order.
#[derive(Debug, Clone)]
pub struct PixelPulses<'m> {
    cells: Vec<Cell<'m>>,
    /// Which avalanches fire other cells, and which of them.
    talk: StreamRng,
    registered: ReorderBuffer<usize>,
    line: InputLevel<'m, ChipTime>,
    /// Where pulses would end, in order, as all are equally long: those that another one prolongs, too.
    ends: VecDeque<(ChipTime, usize)>,
    /// When the level rises and falls.
    pulses: VecDeque<(ChipTime, ChipTime)>,
    end: ChipTime,
}

#[derive(Debug, Clone)]
struct Cell<'m> {
    detector: Avalanches<'m>,
    registration: Registration<'m>,
}

impl<'m> PixelPulses<'m> {
    pub fn new(
        model: &'m DetectorModel,
        pixel: &'m DetectorCells,
        key: StreamKey,
    ) -> PixelPulses<'m> {
        let cells = pixel.cells.iter().map(|cell| {
            let key = cell.key(key.seed, key.repetition, key.group);
            let mut detector = Avalanches::new(cell, &key, model.warm_up_chips);
            if pixel.crosstalk.is_some() {
                detector.listen();
            }
            Cell { detector, registration: Registration::new(cell, &key) }
        });
        let chips = i64::try_from(model.timing.scan.integration_chips).unwrap_or(i64::MAX);
        PixelPulses {
            cells: cells.collect(),
            talk: key.stream(RandomStream::Crosstalk),
            registered: ReorderBuffer::default(),
            line: InputLevel::new(pixel),
            ends: VecDeque::new(),
            pulses: VecDeque::new(),
            end: ChipTime::at_chip(chips),
        }
    }

    /// The next pulse at any input: of a cell, where each has its own, or of the level.
    pub fn next_at_input(&mut self) -> Option<(Detection, f64, usize)> {
        let pixel = self.line.pixel;
        if pixel.inputs() == 1 {
            return self.next().map(|(detection, width_chips)| (detection, width_chips, 0));
        }
        let (time, cell) = self.next_registered()?;
        Some((detection(time), pixel.pulse_width_chips, cell))
    }

    /// When and where the next avalanche is registered; none after the group's end.
    fn next_registered(&mut self) -> Option<(ChipTime, usize)> {
        loop {
            let (cell, first) = self.next_avalanche();
            let horizon = self.cells[cell].detector.registered_from(first);
            if let Some(registered) = self.registered.pop_before(horizon) {
                return Some(registered).filter(|(time, _)| *time < self.end);
            }
            if horizon >= self.end {
                return None;
            }
            let (avalanche, _) = self.cells[cell].detector.fire(self.end);
            let time = self.cells[cell].registration.register(avalanche);
            // What is registered before the group's start belongs to the one before.
            if time.chip >= 0 {
                self.registered.insert(time, cell);
            }
            self.cause(cell, avalanche);
        }
    }

    /// The cell that fires next, and when.
    fn next_avalanche(&self) -> (usize, ChipTime) {
        let mut first = (0, ChipTime::NEVER);
        for (number, cell) in self.cells.iter().enumerate() {
            let next = cell.detector.next_arrival();
            if next < first.1 {
                first = (number, next);
            }
        }
        first
    }

    /// What an avalanche makes of other cells: one of them, each as likely, may fire.
    fn cause(&mut self, from: usize, avalanche: ChipTime) {
        let Some((probability, delay_chips)) = self.line.pixel.crosstalk else { return };
        if self.talk.random::<f64>() < probability {
            let others = self.cells.len() - 1;
            let to = (from + 1 + self.talk.random_range(0..others)) % self.cells.len();
            self.cells[to].detector.hear(avalanche.after(delay_chips));
        }
    }

    /// A detection of a cell, no earlier than the one before it.
    fn pulse(&mut self, time: ChipTime, cell: usize) {
        self.pass(time);
        let until = time.after(self.line.pixel.pulse_width_chips);
        if self.line.pixel.law.edges() > 1 {
            self.pulses.push_back((time, until));
            return;
        }
        self.ends.push_back((until, cell));
        self.pulses.extend(self.line.begin(time, until, cell));
    }

    /// All pulses that end until a time end.
    fn pass(&mut self, time: ChipTime) {
        while let Some((until, cell)) = self.ends.pop_front_if(|(until, _)| *until <= time) {
            self.pulses.extend(self.line.end(until, cell));
        }
    }
}

impl Iterator for PixelPulses<'_> {
    /// When the level rises, and for how many chips it is high.
    type Item = (Detection, f64);

    fn next(&mut self) -> Option<(Detection, f64)> {
        while self.pulses.is_empty() {
            match self.next_registered() {
                Some((time, cell)) => self.pulse(time, cell),
                None => {
                    self.pass(ChipTime::NEVER);
                    break;
                }
            }
        }
        let (rise, fall) = self.pulses.pop_front()?;
        let width_chips = (fall.chip - rise.chip) as f64 + (fall.fraction - rise.fraction);
        Some((detection(rise), width_chips))
    }
}

fn detection(time: ChipTime) -> Detection {
    Detection { chip: u64::try_from(time.chip).unwrap_or_default(), fraction: time.fraction }
}

/// The level of the input, over times of some kind.
#[derive(Debug, Clone)]
pub struct InputLevel<'m, T> {
    pixel: &'m DetectorCells,
    /// Until when each cell's pulse is high, of those that are.
    high_until: Vec<Option<T>>,
    high: u32,
    /// When the level rose, while it is high.
    rise: Option<T>,
}

impl<'m, T: Copy + PartialOrd> InputLevel<'m, T> {
    pub fn new(pixel: &'m DetectorCells) -> InputLevel<'m, T> {
        InputLevel { pixel, high_until: vec![None; pixel.cells.len()], high: 0, rise: None }
    }

    /// A detection of a cell, and when its pulse ends: no earlier than what came before it, all of which that ends
    /// until then has ended. One while the cell's pulse is high prolongs that. Gives the level's
    /// rise and fall if it falls.
    #[inline]
    pub fn begin(&mut self, time: T, until: T, cell: usize) -> Option<(T, T)> {
        let is_high = self.high_until[cell].replace(until).is_some();
        if is_high {
            return None;
        }
        self.high += 1;
        self.change(time)
    }

    /// A detection's pulse ends, if none has prolonged it. Gives the level's rise and fall if it falls.
    #[inline]
    pub fn end(&mut self, until: T, cell: usize) -> Option<(T, T)> {
        if self.high_until[cell] != Some(until) {
            return None;
        }
        self.high_until[cell] = None;
        self.high -= 1;
        self.change(until)
    }

    /// Another number of pulses is high from a time on.
    #[inline]
    fn change(&mut self, time: T) -> Option<(T, T)> {
        match (self.rise, self.pixel.law.level(self.high)) {
            (None, true) => {
                self.rise = Some(time);
                None
            }
            // Of a pulse that begins as another ends nothing is seen.
            (Some(_), false) => {
                self.rise.take().filter(|rise| *rise < time).map(|rise| (rise, time))
            }
            _ => None,
        }
    }
}
