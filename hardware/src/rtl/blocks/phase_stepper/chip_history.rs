//! Whole chips of a reference's delay.
//!
//! The delay grows by letting the generator wait, so that no memory of the code and no second generator is
//! needed, whatever the delay.
//!
//! Cost (ECP5, docs/resources.md): 1 LUT, 2 flip-flops.

use super::phase_geometry::{PhaseGeometry, ReferenceStart};
use crate::rtl::front::prelude::*;

#[block(chip_history)]
/// the reference's last chips, delayed by holding its generator
#[when(geometry.most_chips() > 1)]
/// When the delay grows by several chips, the reference goes back by all but one of them; those come again
/// from a register while the generator waits.
///
/// - Latency: 1 clock from i_chip to o_chips
pub struct ChipHistory {
    geometry: PhaseGeometry,
    start: ReferenceStart,
    realigns: bool,
    #[set(geometry.kept_chips() as usize)]
    kept: usize,
    #[set(geometry.window_chips() as usize)]
    window_chips: usize,
    #[set(geometry.chips() as usize)]
    step_chips: usize,
    #[set(geometry.replayed_chips() as usize)]
    replayed: usize,
    #[set(replayed > 0)]
    has_replays: bool,
    /// next chip of the reference
    pub i_chip: Input<bool>,
    /// last chip of a phase step
    #[when(geometry.chips() > 0)]
    pub i_last_chip: Optional<Input<bool>>,
    /// last chip of a step; the next delays by a chip more
    #[when(geometry.grows_by_samples())]
    pub i_wrap: Optional<Input<bool>>,
    /// a scan begins with the next clock
    #[when(realigns)]
    pub i_start: Optional<Input<bool>>,
    /// the reference generator goes on to its next chip
    pub o_advance: Output<bool>,
    /// reference chips, the present one in bit 0
    #[width(geometry.window_chips())]
    pub o_chips: Output<Word>,
    /// after reset and at a scan's start
    #[width(kept)]
    #[value(start.chips)]
    chips_load: Constant,
    /// reference chips, the present one in bit 0, those before it above
    #[width(kept)]
    #[reset(start.chips, chips_load)]
    chips: Register<Word>,
    /// chips that the reference went back by, the next one on top
    #[when(has_replays)]
    #[width(replayed)]
    saved: Optional<Register<Word>>,
    /// which of them are still to come again
    #[when(has_replays)]
    #[width(replayed)]
    replays: Optional<Register<Word>>,
    #[when(has_replays)]
    hold: Optional<Local<bool>>,
    #[when(has_replays)]
    chip: Optional<Local<bool>>,
}

#[kernel]
impl Logic for ChipHistory {
    fn update(&mut self) {
        if self.i_last_chip.is_present() {
            self.advance();
            self.grow();
        } else {
            self.o_advance.next = !self.i_wrap.val();
            if !self.i_wrap.val() {
                self.chips.next = self.chips.val().shifted_in(self.i_chip.val());
            }
        }
        if self.i_start.is_present() && self.i_start.val() {
            self.chips.next = self.chips_load.val();
            if self.has_replays {
                self.replays.next = 0.into();
            }
        }
        self.o_chips.next = bit_cast(self.chips.val(), self.window_chips);
    }

    /// When the generator goes on, and the chip that comes next.
    fn advance(&mut self) {
        if self.has_replays {
            let top = self.replayed - 1;
            self.hold.next = self.i_last_chip.val() | self.replays.val().get_bit(top);
            if self.replays.val().get_bit(top) {
                self.chip.next = self.saved.val().get_bit(top);
            } else {
                self.chip.next = self.i_chip.val();
            }
            self.o_advance.next = !self.hold.val();
            self.saved.next = self.saved.val() << 1;
            self.replays.next = self.replays.val() << 1;
        } else {
            self.o_advance.next = !self.i_last_chip.val();
        }
    }

    /// The delay grows by whole chips, and by one more when the lanes wrap.
    fn grow(&mut self) {
        let back = self.step_chips;
        if self.i_last_chip.val() {
            if back > 1 {
                self.chips.next = self.chips.val() >> (back - 1);
            }
            if self.has_replays {
                self.save();
            }
        } else if self.has_replays {
            self.chips.next = self.chips.val().shifted_in(self.chip.val());
        } else {
            self.chips.next = self.chips.val().shifted_in(self.i_chip.val());
        }
        if self.i_wrap.is_present() && self.i_wrap.val() {
            self.chips.next = self.chips.val() >> back;
            self.saved.next = bit_cast(self.chips.val(), self.replayed);
            self.replays.next = !bit_cast(false, self.replayed);
        }
    }

    /// The chips by which the reference goes back, to come again.
    fn save(&mut self) {
        if self.i_wrap.is_present() {
            self.saved.next = bit_cast(self.chips.val(), self.replayed) << 1;
            self.replays.next = !bit_cast(false, self.replayed) << 1;
        } else {
            self.saved.next = bit_cast(self.chips.val(), self.replayed);
            self.replays.next = !bit_cast(false, self.replayed);
        }
    }
}
