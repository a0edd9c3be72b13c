//! Samples of a reference's delay.
//!
//! Cost (ECP5, docs/resources.md): 9 LUTs, 16 flip-flops; none with S = 1.

use super::phase_geometry::PhaseGeometry;
use crate::rtl::front::prelude::*;

#[block(lane_delay)]
/// the reference of each sample, from the chip that the delay gives it
#[when(grows)]
/// Lanes below the delay take the previous chip, the others the present one. The mask of delayed lanes is a
/// thermometer, so that no lane needs a comparator. When it is full, the next step delays by one chip more.
///
/// - Latency: 1 clock from i_chips to o_window
pub struct LaneDelay {
    geometry: PhaseGeometry,
    looks_ahead: bool,
    realigns: bool,
    /// Whether a scan's first delay comes from outside.
    is_set: bool,
    #[set(geometry.lanes as usize)]
    lanes: usize,
    #[set(geometry.window_chips() as usize)]
    chips: usize,
    #[set(geometry.window() as usize)]
    window_bits: usize,
    #[set(geometry.grows_by_samples())]
    grows: bool,
    #[set(geometry.samples() as usize)]
    step_samples: usize,
    #[set(lanes.saturating_sub(1).max(1))]
    mask_width: usize,
    #[set((1 << geometry.first_delay) - 1)]
    first_mask: u128,
    /// reference chips, the present one in bit 0
    #[width(chips)]
    pub i_chips: Input<Word>,
    /// the present chip is the last but one of a phase step
    #[when(looks_ahead && grows)]
    pub i_pre_last_chip: Optional<Input<bool>>,
    /// last chip of a phase step
    #[when(grows)]
    pub i_last_chip: Optional<Input<bool>>,
    /// a scan begins with the next clock
    #[when(realigns && grows)]
    pub i_start: Optional<Input<bool>>,
    /// lanes that take the previous chip in a scan's first step
    #[when(is_set && grows)]
    #[width(mask_width)]
    pub i_delayed: Optional<Input<Word>>,
    /// last chip of a step; the next delays by a chip more
    #[when(grows)]
    pub o_wrap: Optional<Output<bool>>,
    /// {window_about(geometry.parallel)}
    #[width(geometry.window())]
    pub o_window: Output<Word>,
    /// after reset and at a scan's start
    #[when(grows)]
    #[width(mask_width)]
    #[value(first_mask)]
    delayed_load: Optional<Constant>,
    /// lanes that take the previous chip
    #[when(grows)]
    #[width(mask_width)]
    #[reset(first_mask, delayed_load)]
    delayed: Optional<Register<Word>>,
    /// this chip is a step's last, and the next delays by a chip more
    #[when(looks_ahead && grows)]
    wraps: Optional<Register<bool>>,
    /// those of the next step
    #[when(grows)]
    #[width(mask_width)]
    longer: Optional<Local<Word>>,
    /// chip of each sample
    #[width(window_bits)]
    present: Local<Word>,
    /// chip of each sample that is delayed
    #[when(grows)]
    #[width(window_bits)]
    previous: Optional<Local<Word>>,
    #[when(grows)]
    #[width(window_bits)]
    takes_previous: Optional<Local<Word>>,
    /// reference of each sample
    #[width(geometry.window())]
    window: Register<Word>,
    /// the next step delays by a whole chip more
    #[when(grows)]
    wrap: Optional<Local<bool>>,
}

/// What stands beside the port of the reference.
pub(super) fn window_about(parallel: u32) -> &'static str {
    match parallel {
        1 => "reference of each sample, bit 0 earliest",
        _ => "reference of each sample, bit 0 earliest; the last step's lowest",
    }
}

#[kernel]
impl Logic for LaneDelay {
    fn update(&mut self) {
        // Where the delay stays within a chip, which lanes take the previous chip is known
        // beforehand.
        self.present.next = gather(self.window_bits, |sample| {
            self.i_chips.val().get_bit(self.geometry.chip(sample, !self.grows))
        });
        if self.grows {
            self.choose();
            self.grow();
            self.o_wrap.next = self.wrap.val();
        } else {
            self.window.next = self.present.val();
        }
        self.o_window.next = self.window.val();
    }

    /// Each lane's chip: the present one, or the one before it.
    fn choose(&mut self) {
        self.previous.next = gather(self.window_bits, |sample| {
            self.i_chips.val().get_bit(self.geometry.chip(sample, true))
        });
        self.takes_previous.next = gather(self.window_bits, |sample| {
            if self.geometry.place(sample) + 1 < self.lanes {
                self.delayed.val().get_bit(self.geometry.place(sample))
            } else {
                false
            }
        });
        self.window.next = (self.takes_previous.val() & self.previous.val())
            | (!self.takes_previous.val() & self.present.val());
    }

    /// The mask of delayed lanes from step to step.
    fn grow(&mut self) {
        let full = self.lanes - 1 - self.step_samples;
        self.longer.next = gather(self.mask_width, |lane| {
            if lane < self.step_samples {
                true
            } else {
                self.delayed.val().get_bit(lane - self.step_samples)
            }
        });
        if self.wraps.is_present() {
            self.wraps.next = self.i_pre_last_chip.val() & self.delayed.val().get_bit(full);
            self.wrap.next = self.wraps.val();
        } else {
            self.wrap.next = self.i_last_chip.val() & self.delayed.val().get_bit(full);
        }
        if self.wrap.val() {
            self.delayed.next = self.delayed.val() >> (self.lanes - self.step_samples);
        } else if self.i_last_chip.val() {
            self.delayed.next = self.longer.val();
        }
        if self.i_start.is_present() && self.i_start.val() {
            if self.i_delayed.is_present() {
                self.delayed.next = self.i_delayed.val();
            } else {
                self.delayed.next = self.delayed_load.val();
            }
        }
    }
}
