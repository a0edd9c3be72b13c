//! What is done to a board in a run, and what has to come of it.

use goldtof_wire::{BLOCK_BYTES, Frame, Request};

/// A result as the core offers it.
#[derive(Debug, Clone)]
pub(super) struct Offer {
    /// Clocks before it is offered.
    pub wait: u64,
    /// The stream's word, its lowest 32 bits first.
    pub tdata: Vec<u32>,
    /// It is the last one of its scan.
    pub last: bool,
}

/// A pulse at a detector's pin, as the simulated board reads it.
#[derive(Debug, Clone, Copy)]
pub(super) struct PinPulse {
    /// Its first sample.
    pub first: u64,
    /// How many it has.
    pub samples: u32,
    /// The detector.
    pub detector: u32,
}

impl PinPulse {
    pub(super) fn to_bytes(self) -> [u8; 16] {
        let mut bytes = [0; 16];
        bytes[..8].copy_from_slice(&self.first.to_le_bytes());
        bytes[8..12].copy_from_slice(&self.samples.to_le_bytes());
        bytes[12..].copy_from_slice(&self.detector.to_le_bytes());
        bytes
    }
}

/// An answer that is expected.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum ExpectedAnswer {
    /// This one.
    Frame(Frame),
    /// A write's, with this response: its data mean nothing.
    Written(Request, u8),
    /// Hits by sample: a block from this word on.
    Hits(Request, usize, Moment),
}

/// Hits by sample in an answer.
pub(super) const HITS_OF_BLOCK: usize = BLOCK_BYTES / 4;

/// When hits by sample are read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Moment {
    /// Before any light.
    Before,
    /// Behind light at random: what came is counted.
    BehindLight,
    /// In light that is the same for every sample: all have counted for the same time.
    InLight,
    /// Behind that: nothing was counted while the host read.
    BehindIt,
}

/// From one reset to the next.
#[derive(Debug, Clone, Default)]
pub(super) struct Era {
    /// Answers, in order.
    pub answers: Vec<ExpectedAnswer>,
    /// Transfers at the core's registers.
    pub transfers: Vec<String>,
    /// The last of either may be missing: the next reset may have cut it.
    pub is_cut: bool,
    /// Results may be lost, but not among so many at first.
    pub may_lose_behind: Option<usize>,
}

/// What is done to a board in a run, and what has to come of it.
#[derive(Debug, Clone, Default)]
pub(super) struct BoardScript {
    /// Lines for the bench.
    pub host: String,
    /// What the core offers, or what the board's own core is to send first.
    pub offers: Vec<Offer>,
    /// Light for the board's own core.
    pub photons: Option<Vec<PinPulse>>,
    /// Length of the host's bits when it sends and reads.
    pub rates: (f64, f64),
    /// The fewest chips of a run of the board's own core; the most of any other.
    pub chips: u64,
    /// The sample that is the first of the light.
    pub first: i64,
    /// What has to come up to the first reset, from there to the next one, and so on.
    pub eras: Vec<Era>,
    /// The core's flags, one after another.
    pub flags: Vec<u8>,
    /// Scans by their first results up to the first reset, and whether they have to come, or to be lost.
    pub scans: Vec<(usize, bool)>,
    /// The line has to be full all the time.
    pub keeps_line_full: bool,
    /// Situations that the host makes.
    pub points: Vec<String>,
    /// Bits that it takes so far, or nearly so; and those that it takes at most.
    pub bits: f64,
    pub most_bits: f64,
}

impl BoardScript {
    /// Whether it is for the board's own core.
    pub(super) fn is_whole(&self) -> bool {
        self.photons.is_some()
    }
}
