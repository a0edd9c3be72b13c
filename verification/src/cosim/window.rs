//! Which clocks of a run are kept for its waveforms.

use std::ops::Range;

use crate::reference::blocks::Records;
use crate::sensor::layout::{Field, Layout};
use crate::sensor::port::PortRole;

/// Clocks that are kept on either side of what is shown.
const CONTEXT_CLOCKS: u64 = 1_000;
/// Clocks that are kept of a run that comes to nothing else.
const FIRST_CLOCKS: u64 = 4 * CONTEXT_CLOCKS;

/// Which clocks to keep.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum Window {
    /// A thousand clocks on either side of the first mismatch, or else of the first
    /// result; the first clocks of a run that has neither.
    #[default]
    Found,
    /// These clocks, as far as the run goes.
    Clocks(Range<u64>),
}

/// Clocks to be shown, and which of them to look at.
#[derive(Debug, Clone)]
pub struct Shown {
    /// Inputs and outputs of both sides.
    pub records: Records,
    /// The clock to look at first.
    pub clock: u64,
}

/// The clocks that have been kept of a run.
pub(super) struct Kept<'a> {
    layout: &'a Layout,
    window: Window,
    valid: &'a Field,
    /// The block before the present one.
    previous: Option<Records>,
    asked: Records,
    first: Records,
    result: Option<Around>,
    mismatch: Option<Around>,
}

/// Clocks on either side of one.
struct Around {
    centre: u64,
    records: Records,
}

impl<'a> Kept<'a> {
    pub(super) fn new(layout: &'a Layout, window: Window) -> Kept<'a> {
        Kept {
            layout,
            window,
            valid: layout.outputs.field(PortRole::Valid),
            previous: None,
            asked: Records::default(),
            first: Records::default(),
            result: None,
            mismatch: None,
        }
    }

    /// Takes the records of the next block, and the clock of the run's first mismatch
    /// if it is in it. Gives others to be filled again.
    pub(super) fn take(&mut self, records: Records, mismatch: Option<u64>) -> Records {
        if let Window::Clocks(clocks) = &self.window {
            append(&mut self.asked, &records, clocks, self.layout);
        }
        append(&mut self.first, &records, &(0..FIRST_CLOCKS), self.layout);
        let result = match self.result {
            None => self.first_result(&records),
            Some(_) => None,
        };
        for (around, found) in [(&mut self.result, result), (&mut self.mismatch, mismatch)] {
            if let Some(centre) = found {
                let mut new = Around { centre, records: Records::default() };
                if let Some(previous) = &self.previous {
                    new.append(previous, self.layout);
                }
                *around = Some(new);
            }
            if let Some(around) = around {
                around.append(&records, self.layout);
            }
        }
        // The block's arrays change places with those of the one before it, so keeping
        // it costs no copy.
        self.previous.replace(records).unwrap_or_default()
    }

    /// The first clock with a result on the reference model's stream.
    fn first_result(&self, records: &Records) -> Option<u64> {
        let mut outputs = records.expected.chunks_exact(self.layout.outputs.words);
        let clock = outputs.position(|outputs| self.valid.low_word(outputs) == 1)?;
        Some(records.first_clock + clock as u64)
    }

    /// What surrounds what was found, and what was asked for, as far as the run went.
    pub(super) fn into_shown(self) -> (Shown, Option<Shown>) {
        let asked = (!self.asked.got.values.is_empty()).then(|| {
            let clocks = self.asked.clocks(self.layout);
            let centres = [&self.mismatch, &self.result].into_iter().flatten();
            let shown = centres.map(|around| around.centre).find(|at| clocks.contains(at));
            Shown { clock: shown.unwrap_or(clocks.start), records: self.asked }
        });
        let found = match self.mismatch.or(self.result) {
            Some(around) => Shown { records: around.records, clock: around.centre },
            None => Shown { records: self.first, clock: 0 },
        };
        (found, asked)
    }
}

impl Around {
    fn append(&mut self, records: &Records, layout: &Layout) {
        let window = self.centre.saturating_sub(CONTEXT_CLOCKS)..self.centre + CONTEXT_CLOCKS;
        append(&mut self.records, records, &window, layout);
    }
}

/// Appends the part of a block that lies in a window of clocks.
fn append(kept: &mut Records, records: &Records, window: &Range<u64>, layout: &Layout) {
    let end = records.clocks(layout).end;
    let from = window.start.clamp(records.first_clock, end);
    let to = window.end.clamp(records.first_clock, end);
    if from >= to {
        return;
    }
    if kept.got.values.is_empty() {
        kept.first_clock = from;
    }
    let part = |words: usize| {
        (from - records.first_clock) as usize * words..(to - records.first_clock) as usize * words
    };
    let outputs = part(layout.outputs.words);
    kept.inputs.extend_from_slice(&records.inputs[part(layout.inputs.words)]);
    kept.expected.extend_from_slice(&records.expected[outputs.clone()]);
    kept.got.append(&records.got, outputs.clone());
    // Of all blocks or of none.
    if !records.low.values.is_empty() {
        kept.low.append(&records.low, outputs);
    }
}
