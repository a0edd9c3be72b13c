//! Samples of a reference's delay.

use super::phase_geometry::PhaseGeometry;
use crate::hdl::front::prelude::*;

/// Takes each sample of the reference from the chip that the delay gives it.
#[derive(Debug, Clone, LogicBlock)]
pub struct LaneDelay {
    /// Clock.
    pub i_clk: Input<bool>,
    /// Synchronous reset.
    pub i_rst: Input<bool>,
    /// The reference's present chip in bit 0, those before it above.
    pub i_chips: Input<Word>,
    /// The next clock is the last of a group of steps.
    pub i_step_ends: Optional<Input<bool>>,
    /// Last clock of a group of steps.
    pub i_step_end: Optional<Input<bool>>,
    /// First clock of a scan comes next.
    pub i_start: Optional<Input<bool>>,
    /// Last clock of a group after which the delay grows by a chip more.
    pub o_wrap: Optional<Output<bool>>,
    /// Reference of each sample; step p of a group of P takes it from bit
    /// P - 1 - p on.
    pub o_window: Output<Word>,
    about: About,
    delayed_load: Optional<Constant>,
    delayed: Optional<Register<Word>>,
    wraps: Optional<Register<bool>>,
    longer: Optional<Wiring>,
    present: Wiring,
    previous: Optional<Wiring>,
    takes_previous: Optional<Wiring>,
    window: Register<Word>,
    wrap: Optional<Local<bool>>,
    _chips: usize,
    _lanes: usize,
    _step_samples: usize,
}

impl LaneDelay {
    /// `looks_ahead` if `i_step_ends` is there; `realigns` adds the start of
    /// later scans.
    pub fn new(geometry: PhaseGeometry, looks_ahead: bool, realigns: bool) -> LaneDelay {
        let lanes = geometry.lanes;
        let samples = geometry.samples();
        let grows = geometry.grows_by_samples();
        let chips = geometry.window_chips() as usize;
        let window = geometry.window();
        let mask_width = lanes.saturating_sub(1).max(1);
        let mask = (1 << geometry.first_delay) - 1;
        let taps: Vec<(u32, u32)> = (0..window).map(|sample| geometry.tap(sample)).collect();
        // Where the delay stays within a chip, which lanes take the previous
        // chip is known beforehand.
        let one_more = |place: u32| u32::from(geometry.may_be_delayed(place));
        let fixed = |place: u32| if grows { 0 } else { one_more(place) };
        let present = taps
            .iter()
            .map(|&(back, place)| (back + fixed(place)) as usize);
        let previous = taps
            .iter()
            .map(|&(back, place)| (back + one_more(place)) as usize);
        let places = taps.iter().map(|&(_, place)| place as usize);
        // The mask with `samples` more lanes: ones come in from an input that
        // follows its own bits.
        let longer = (0..mask_width).map(|lane| match lane.checked_sub(samples) {
            Some(from) => from as usize,
            None => mask_width as usize,
        });
        LaneDelay {
            i_clk: Input::bit("one chip per cycle"),
            i_rst: Input::bit("synchronous, active high"),
            i_chips: Input::word(chips as u32, "reference chips, the present one in bit 0"),
            i_step_ends: Optional::new(
                looks_ahead && grows,
                Input::bit("the next clock is the last of a phase step"),
            ),
            i_step_end: Optional::new(grows, Input::bit("last clock of a phase step")),
            i_start: Optional::new(
                realigns && grows,
                Input::bit("a scan begins with the next clock"),
            ),
            o_wrap: Optional::new(
                grows,
                Output::bit("last clock of a step after which the delay grows by a chip more"),
            ),
            o_window: Output::word(window, window_about(geometry.parallel)),
            about: describe(geometry),
            delayed_load: Optional::new(
                grows,
                Constant::new(
                    mask,
                    mask_width,
                    "Delayed lanes after reset and at a scan's start",
                ),
            ),
            delayed: Optional::new(
                grows,
                Register::word(mask_width, mask, "lanes that take the previous chip")
                    .reset_to("delayed_load$0"),
            ),
            wraps: Optional::new(
                looks_ahead && grows,
                Register::bit(
                    false,
                    "this clock ends a step, and the next delays by a chip more",
                ),
            ),
            longer: Optional::new(
                grows,
                Wiring::new(
                    mask_width as usize + 1,
                    longer.collect(),
                    "delayed lanes of the next step",
                ),
            ),
            present: Wiring::new(chips, present.collect(), "chip of a sample"),
            previous: Optional::new(
                grows,
                Wiring::new(
                    chips,
                    previous.collect(),
                    "chip of a sample that is delayed",
                ),
            ),
            takes_previous: Optional::new(
                grows,
                Wiring::new(lanes as usize, places.collect(), "samples that are delayed"),
            ),
            window: Register::word(window, 0, "reference of each sample"),
            wrap: Optional::new(
                grows,
                Local::bit("the next step delays by a whole chip more"),
            ),
            _chips: chips,
            _lanes: lanes as usize,
            _step_samples: samples as usize,
        }
    }
}

/// What stands beside the port of the reference.
pub(super) fn window_about(parallel: u32) -> &'static str {
    match parallel {
        1 => "reference of each sample, bit 0 earliest",
        _ => "reference of each sample, bit 0 earliest; the last step's samples are the lowest",
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
    about
        .fact("Latency", "1 clock from i_chips to o_window")
        .fact("Rate", "one chip per clock")
}

impl Logic for LaneDelay {
    #[hdl_gen]
    fn update(&mut self) {
        dff_setup!(self, i_clk, window);
        for c in 0..self._chips {
            self.present.i[c].next = self.i_chips.val().get_bit(c);
        }
        for _by_chips in self.delayed.count()..1 {
            self.window.d.next = self.present.o.val();
        }
        for _by_samples in 0..self.delayed.count() {
            dff_setup!(self, i_clk, delayed[0]);
            for c in 0..self._chips {
                self.previous[0].i[c].next = self.i_chips.val().get_bit(c);
            }
            for l in 0..(self._lanes - 1) {
                self.takes_previous[0].i[l].next = self.delayed[0].q.val().get_bit(l);
                self.longer[0].i[l].next = self.delayed[0].q.val().get_bit(l);
            }
            for top in (self._lanes - 1)..self._lanes {
                self.takes_previous[0].i[top].next = false;
                self.longer[0].i[top].next = true;
            }
            self.window.d.next = (self.takes_previous[0].o.val() & self.previous[0].o.val())
                | (!self.takes_previous[0].o.val() & self.present.o.val());
            for full in (self._lanes - 1 - self._step_samples)..(self._lanes - self._step_samples) {
                for _ahead in 0..self.wraps.count() {
                    dff_setup!(self, i_clk, wraps[0]);
                    self.wraps[0].d.next =
                        self.i_step_ends[0].val() & self.delayed[0].q.val().get_bit(full);
                    self.wrap[0].next = self.wraps[0].q.val();
                }
                for _at_once in self.wraps.count()..1 {
                    self.wrap[0].next =
                        self.i_step_end[0].val() & self.delayed[0].q.val().get_bit(full);
                }
            }
            for shorter in
                (self._lanes - self._step_samples)..(self._lanes - self._step_samples + 1)
            {
                if self.wrap[0].val() {
                    self.delayed[0].d.next = self.delayed[0].q.val() >> shorter;
                } else if self.i_step_end[0].val() {
                    self.delayed[0].d.next = self.longer[0].o.val();
                }
            }
            for _realigns in 0..self.i_start.count() {
                if self.i_start[0].val() {
                    self.delayed[0].d.next = self.delayed_load[0].val();
                }
            }
            self.o_wrap[0].next = self.wrap[0].val();
        }

        self.o_window.next = self.window.q.val();
    }
}
