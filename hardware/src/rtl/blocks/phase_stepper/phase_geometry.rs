//! How a reference is delayed: whole chips, and samples within a chip.

/// Where the reference stands when a scan begins.
#[derive(Debug, Clone, Copy)]
pub struct ReferenceStart {
    /// Reference chips after reset and at a scan's start, the present one in
    /// bit 0, those before it above.
    pub chips: u128,
}

/// How the delay grows from group to group: by `parallel` samples.
#[derive(Debug, Clone, Copy)]
pub struct PhaseGeometry {
    pub(super) lanes: u32,
    pub(super) parallel: u32,
    pub(super) first_delay: u32,
}

impl PhaseGeometry {
    /// For `lanes` samples per chip and `parallel` steps per group; a scan's
    /// first step delays by `first_delay` samples, f = k mod S, beside whole
    /// chips.
    pub fn new(lanes: u32, parallel: u32, first_delay: u32) -> PhaseGeometry {
        PhaseGeometry { lanes, parallel, first_delay }
    }

    /// Samples by which the delay grows beside the whole chips.
    pub(super) fn samples(self) -> u32 {
        self.parallel % self.lanes
    }

    /// Whole chips by which the delay grows at least.
    pub(super) fn chips(self) -> u32 {
        self.parallel / self.lanes
    }

    /// Whole chips by which it grows at most.
    pub(super) fn most_chips(self) -> u32 {
        self.parallel.div_ceil(self.lanes)
    }

    /// Samples of the reference that a group's lanes need.
    pub(super) fn window(self) -> u32 {
        self.lanes + self.parallel - 1
    }

    /// Samples from the first of the present chip to one of the window.
    fn offset(self, sample: usize) -> i64 {
        sample as i64 - i64::from(self.parallel) + 1
    }

    /// Place of a sample of the window within its chip.
    pub(super) fn place(self, sample: usize) -> usize {
        self.offset(sample).rem_euclid(i64::from(self.lanes)) as usize
    }

    /// Chips that a sample of the window lies back: when no lane takes the previous chip, or when
    /// all do that ever are `delayed`.
    pub(super) fn chip(self, sample: usize, delayed: bool) -> usize {
        let back = -self.offset(sample).div_euclid(i64::from(self.lanes)) as usize;
        back + usize::from(delayed && self.may_be_delayed(self.place(sample) as u32))
    }

    /// Reference chips from which the window's samples are taken.
    pub(super) fn window_chips(self) -> u32 {
        let oldest = (0..self.window() as usize).map(|sample| self.chip(sample, true));
        oldest.max().unwrap_or(0) as u32 + 1
    }

    /// Reference chips that are kept: those of the window, and those to which
    /// the reference goes back when the delay grows.
    pub fn kept_chips(self) -> u32 {
        self.window_chips() + self.replayed_chips()
    }

    /// Chips by which the reference goes back at most when the delay grows, for
    /// which they come again: all but the one that holding it brings.
    pub(super) fn replayed_chips(self) -> u32 {
        self.most_chips() - 1
    }

    /// Whether the delay grows by more than whole chips, so that lanes change
    /// between the present and the previous chip.
    pub fn grows_by_samples(self) -> bool {
        self.samples() > 0
    }

    /// Whether a sample at `place` of its chip ever takes the chip before.
    pub(super) fn may_be_delayed(self, place: u32) -> bool {
        if self.samples() > 0 { place + 1 < self.lanes } else { place < self.first_delay }
    }
}
