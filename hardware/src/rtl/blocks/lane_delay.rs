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
#[block(DelayPlan)]
pub struct LaneDelay {
    /// reference chips, the present one in bit 0
    #[width(plan.chips())]
    pub i_chips: Input<Word>,
    /// the present chip is the last but one of a phase step
    #[when(plan.looks_ahead && plan.grows())]
    pub i_pre_last_chip: Optional<Input<bool>>,
    /// last chip of a phase step
    #[when(plan.grows())]
    pub i_last_chip: Optional<Input<bool>>,
    /// a scan begins with the next clock
    #[when(plan.realigns && plan.grows())]
    pub i_start: Optional<Input<bool>>,
    /// last chip of a step; the next delays by a chip more
    #[when(plan.grows())]
    pub o_wrap: Optional<Output<bool>>,
    /// Reference of each sample; step p of a group of P takes it from bit
    /// P - 1 - p on.
    #[about(window_about(plan.geometry.parallel))]
    #[width(plan.geometry.window())]
    pub o_window: Output<Word>,
    #[is(describe(plan.geometry))]
    about: About,
    /// after reset and at a scan's start
    #[when(plan.grows())]
    #[width(plan.mask_width())]
    #[value(plan.first_mask())]
    delayed_load: Optional<Constant>,
    /// lanes that take the previous chip
    #[when(plan.grows())]
    #[width(plan.mask_width())]
    #[reset(plan.first_mask(), delayed_load)]
    delayed: Optional<Register<Word>>,
    /// this chip is a step's last, and the next delays by a chip more
    #[when(plan.looks_ahead && plan.grows())]
    wraps: Optional<Register<bool>>,
    /// those of the next step
    #[when(plan.grows())]
    #[sources(plan.longer(), plan.mask_width() + 1)]
    longer: Optional<Wiring>,
    /// chip of each sample
    #[sources(plan.present(), plan.chips())]
    present: Wiring,
    /// chip of each sample that is delayed
    #[when(plan.grows())]
    #[sources(plan.previous(), plan.chips())]
    previous: Optional<Wiring>,
    #[when(plan.grows())]
    #[sources(plan.places(), plan.lanes())]
    takes_previous: Optional<Wiring>,
    /// reference of each sample
    #[width(plan.geometry.window())]
    window: Register<Word>,
    /// the next step delays by a whole chip more
    #[when(plan.grows())]
    wrap: Optional<Local<bool>>,
    plan: Plan<DelayPlan>,
}

#[derive(Debug, Clone)]
struct DelayPlan {
    geometry: PhaseGeometry,
    looks_ahead: bool,
    realigns: bool,
}

impl DelayPlan {
    fn lanes(&self) -> usize {
        self.geometry.lanes as usize
    }

    fn chips(&self) -> usize {
        self.geometry.window_chips() as usize
    }

    fn grows(&self) -> bool {
        self.geometry.grows_by_samples()
    }

    fn step_samples(&self) -> usize {
        self.geometry.samples() as usize
    }

    fn mask_width(&self) -> usize {
        self.lanes().saturating_sub(1).max(1)
    }

    fn first_mask(&self) -> u128 {
        (1 << self.geometry.first_delay) - 1
    }

    /// The mask with `step_samples` more lanes: ones come in from an input
    /// that follows its own bits.
    fn longer(&self) -> Vec<usize> {
        (0..self.mask_width())
            .map(|lane| lane.checked_sub(self.step_samples()))
            .map(|from| from.unwrap_or(self.mask_width()))
            .collect()
    }

    fn taps(&self) -> impl Iterator<Item = (u32, u32)> {
        let geometry = self.geometry;
        (0..geometry.window()).map(move |sample| geometry.tap(sample))
    }

    /// Chip of each sample when no lane is delayed. Where the delay stays
    /// within a chip, which lanes take the previous chip is known beforehand.
    fn present(&self) -> Vec<usize> {
        let one_more = |place| !self.grows() && self.geometry.may_be_delayed(place);
        self.taps().map(|(back, place)| back as usize + usize::from(one_more(place))).collect()
    }

    fn previous(&self) -> Vec<usize> {
        self.taps()
            .map(|(back, place)| back as usize + usize::from(self.geometry.may_be_delayed(place)))
            .collect()
    }

    fn places(&self) -> Vec<usize> {
        self.taps().map(|(_, place)| place as usize).collect()
    }
}

impl LaneDelay {
    /// `looks_ahead` if `i_pre_last_chip` is there; `realigns` adds the start of
    /// later scans.
    pub fn new(geometry: PhaseGeometry, looks_ahead: bool, realigns: bool) -> LaneDelay {
        LaneDelay::build(&DelayPlan { geometry, looks_ahead, realigns })
    }
}

/// What stands beside the port of the reference.
pub(super) fn window_about(parallel: u32) -> &'static str {
    match parallel {
        1 => "reference of each sample, bit 0 earliest",
        _ => "reference of each sample, bit 0 earliest; the last step's lowest",
    }
}

fn describe(geometry: PhaseGeometry) -> About {
    let mut about = About::new(
        "lane_delay",
        "the reference of each sample, from the chip that the delay gives it",
    );
    if geometry.grows_by_samples() {
        about = about.note(
            "Lanes below the delay take the previous chip, the others the present one. The mask \
             of delayed lanes is a thermometer, so that no lane needs a comparator. When it is \
             full, the next step delays by one chip more.",
        );
    }
    about.fact("Latency", "1 clock from i_chips to o_window")
}

#[kernel]
impl Logic for LaneDelay {
    fn update(&mut self) {
        for c in 0..self.plan.chips() {
            self.present.i[c].next = self.i_chips.val().get_bit(c);
        }
        if self.plan.grows() {
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
        for c in 0..self.plan.chips() {
            self.previous.i[c].next = self.i_chips.val().get_bit(c);
        }
        let top = self.plan.lanes() - 1;
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
        let full = self.plan.lanes() - 1 - self.plan.step_samples();
        if self.wraps.is_present() {
            self.wraps.d.next = self.i_pre_last_chip.val() & self.delayed.q.val().get_bit(full);
            self.wrap.next = self.wraps.q.val();
        } else {
            self.wrap.next = self.i_last_chip.val() & self.delayed.q.val().get_bit(full);
        }
        if self.wrap.val() {
            self.delayed.d.next =
                self.delayed.q.val() >> (self.plan.lanes() - self.plan.step_samples());
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
