//! Samples of a reference's delay.
//!
//! | port | |
//! |---|---|
//! | `i_chips` | chips of the window |
//! | `i_pre_last_chip`, `i_last_chip`, `i_start` | from the scan controller |
//! | `o_window`, `o_wrap` | reference of each sample; the delay grows by a chip more |
//!
//! Latency 1 clock from `i_chips` to `o_window`. The mask of delayed lanes is a thermometer, so
//! that no lane compares its number with the delay.
//!
//! Cost (ECP5, docs/resources.md): 9 LUTs, 16 flip-flops; none with S = 1.

use super::phase_geometry::PhaseGeometry;
use crate::rtl::front::prelude::*;

/// Takes each sample of the reference from the chip that the delay gives it.
#[block(About::new(
        "lane_delay",
        "the reference of each sample, from the chip that the delay gives it",
    )
.note_if(geometry.grows_by_samples(), "Lanes below the delay take the previous chip, the others the present one. The mask \
             of delayed lanes is a thermometer, so that no lane needs a comparator. When it is \
             full, the next step delays by one chip more.").fact("Latency", "1 clock from i_chips to o_window"))]
pub struct LaneDelay {
    geometry: PhaseGeometry,
    looks_ahead: bool,
    realigns: bool,
    #[set(geometry.lanes as usize)]
    lanes: usize,
    #[set(geometry.window_chips() as usize)]
    chips: usize,
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
    /// last chip of a step; the next delays by a chip more
    #[when(grows)]
    pub o_wrap: Optional<Output<bool>>,
    /// Reference of each sample; step p of a group of P takes it from bit
    /// P - 1 - p on.
    #[about(window_about(geometry.parallel))]
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
    #[sources(longer(geometry, mask_width), mask_width + 1)]
    longer: Optional<Wiring>,
    /// chip of each sample
    #[sources(present(geometry), chips)]
    present: Wiring,
    /// chip of each sample that is delayed
    #[when(grows)]
    #[sources(previous(geometry), chips)]
    previous: Optional<Wiring>,
    #[when(grows)]
    #[sources(taps(geometry).map(|(_, place)| place as usize).collect(), lanes)]
    takes_previous: Optional<Wiring>,
    /// reference of each sample
    #[width(geometry.window())]
    window: Register<Word>,
    /// the next step delays by a whole chip more
    #[when(grows)]
    wrap: Optional<Local<bool>>,
}

/// The mask with more lanes: ones come in from an input that follows its own bits.
fn longer(geometry: PhaseGeometry, mask_width: usize) -> Vec<usize> {
    let from = |lane: usize| lane.checked_sub(geometry.samples() as usize);
    (0..mask_width).map(|lane| from(lane).unwrap_or(mask_width)).collect()
}

fn taps(geometry: PhaseGeometry) -> impl Iterator<Item = (u32, u32)> {
    (0..geometry.window()).map(move |sample| geometry.tap(sample))
}

/// Chip of each sample when no lane is delayed. Where the delay stays within a chip, which lanes
/// take the previous chip is known beforehand.
fn present(geometry: PhaseGeometry) -> Vec<usize> {
    match geometry.grows_by_samples() {
        true => taps(geometry).map(|(back, _)| back as usize).collect(),
        false => previous(geometry),
    }
}

/// The same when all are that ever are.
fn previous(geometry: PhaseGeometry) -> Vec<usize> {
    let one_more = |place| u32::from(geometry.may_be_delayed(place));
    taps(geometry).map(|(back, place)| (back + one_more(place)) as usize).collect()
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
        for c in 0..self.chips {
            self.present.i[c].next = self.i_chips.val().get_bit(c);
        }
        if self.grows {
            self.choose();
            self.grow();
            self.o_wrap.next = self.wrap.val();
        } else {
            self.window.d.next = self.present.o.val();
        }
        self.o_window.next = self.window.q.val();
    }

    /// Each lane's chip: the present one, or the one before it.
    fn choose(&mut self) {
        for c in 0..self.chips {
            self.previous.i[c].next = self.i_chips.val().get_bit(c);
        }
        let top = self.lanes - 1;
        for l in 0..top {
            self.takes_previous.i[l].next = self.delayed.q.val().get_bit(l);
            self.longer.i[l].next = self.delayed.q.val().get_bit(l);
        }
        self.takes_previous.i[top].next = false;
        self.longer.i[top].next = true;
        self.window.d.next = (self.takes_previous.o.val() & self.previous.o.val())
            | (!self.takes_previous.o.val() & self.present.o.val());
    }

    /// The mask of delayed lanes from step to step.
    fn grow(&mut self) {
        let full = self.lanes - 1 - self.step_samples;
        if self.wraps.is_present() {
            self.wraps.d.next = self.i_pre_last_chip.val() & self.delayed.q.val().get_bit(full);
            self.wrap.next = self.wraps.q.val();
        } else {
            self.wrap.next = self.i_last_chip.val() & self.delayed.q.val().get_bit(full);
        }
        if self.wrap.val() {
            self.delayed.d.next = self.delayed.q.val() >> (self.lanes - self.step_samples);
        } else if self.i_last_chip.val() {
            self.delayed.d.next = self.longer.o.val();
        }
        if self.i_start.is_present() {
            if self.i_start.val() {
                self.delayed.d.next = self.delayed_load.val();
            }
        }
    }
}
