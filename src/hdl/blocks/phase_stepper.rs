//! The reference, delayed by a phase that grows with every group of steps.

use crate::hdl::front::prelude::*;

/// Delays the reference: whole chips by holding its generator, the rest by
/// lane.
#[derive(Debug, Clone, LogicBlock)]
pub struct PhaseStepper {
    /// Clock.
    pub i_clk: Input<bool>,
    /// Synchronous reset.
    pub i_rst: Input<bool>,
    /// Next chip of the reference.
    pub i_chip: Input<bool>,
    /// The next clock is the last of a group of steps.
    pub i_step_ends: Optional<Input<bool>>,
    /// Last clock of a group of steps.
    pub i_step_end: Input<bool>,
    /// First clock of a scan comes next.
    pub i_start: Optional<Input<bool>>,
    /// The reference generator goes on.
    pub o_advance: Output<bool>,
    /// Reference of each sample, one word for each step of the group.
    pub o_reference: Vec<Output<Word>>,
    about: About,
    chips_load: Constant,
    delayed_load: Optional<Constant>,
    chips: Register<Word>,
    delayed: Optional<Register<Word>>,
    wraps: Optional<Register<bool>>,
    saved: Optional<Register<Word>>,
    replays: Optional<Register<Word>>,
    longer: Optional<Wiring>,
    present: Wiring,
    previous: Optional<Wiring>,
    takes_previous: Optional<Wiring>,
    window: Register<Word>,
    taps: Vec<Wiring>,
    wrap: Optional<Local<bool>>,
    hold: Optional<Local<bool>>,
    chip: Optional<Local<bool>>,
    _chips: usize,
    _lanes: usize,
    _parallel: usize,
    _step_samples: usize,
    _step_chips: usize,
    _replayed: usize,
    _advances_at_step_end: usize,
}

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
    lanes: u32,
    parallel: u32,
    first_delay: u32,
}

impl PhaseGeometry {
    /// For `lanes` samples per chip and `parallel` steps per group; a scan's
    /// first step delays by `first_delay` samples, f = k mod S, beside whole
    /// chips.
    pub fn new(lanes: u32, parallel: u32, first_delay: u32) -> PhaseGeometry {
        PhaseGeometry {
            lanes,
            parallel,
            first_delay,
        }
    }

    /// Samples by which the delay grows beside the whole chips.
    fn samples(self) -> u32 {
        self.parallel % self.lanes
    }

    /// Whole chips by which the delay grows at least.
    fn chips(self) -> u32 {
        self.parallel / self.lanes
    }

    /// Whole chips by which it grows at most.
    fn most_chips(self) -> u32 {
        self.parallel.div_ceil(self.lanes)
    }

    /// Samples of the reference that a group's lanes need.
    fn window(self) -> u32 {
        self.lanes + self.parallel - 1
    }

    /// Chips that sample `sample` of the window lies back when no lane takes
    /// the previous chip, and its place within its chip.
    fn tap(self, sample: u32) -> (u32, u32) {
        let offset = i64::from(sample) - i64::from(self.parallel) + 1;
        let lanes = i64::from(self.lanes);
        (
            -offset.div_euclid(lanes) as u32,
            offset.rem_euclid(lanes) as u32,
        )
    }

    /// Reference chips that are kept: those of the window, and those to which
    /// the reference goes back when the delay grows.
    pub fn kept_chips(self) -> u32 {
        let oldest = (0..self.window()).map(|sample| {
            let (back, place) = self.tap(sample);
            back + u32::from(self.may_be_delayed(place))
        });
        oldest.max().unwrap_or(0) + self.most_chips()
    }

    /// Whether a sample at `place` of its chip ever takes the chip before.
    fn may_be_delayed(self, place: u32) -> bool {
        if self.samples() > 0 {
            place + 1 < self.lanes
        } else {
            place < self.first_delay
        }
    }
}

impl PhaseStepper {
    /// `looks_ahead` if `i_step_ends` is there; `realigns` adds the start of
    /// later scans.
    pub fn new(
        geometry: PhaseGeometry,
        start: ReferenceStart,
        looks_ahead: bool,
        realigns: bool,
    ) -> PhaseStepper {
        let (lanes, parallel) = (geometry.lanes, geometry.parallel);
        let (samples, chips) = (geometry.samples(), geometry.chips());
        let grows_by_samples = samples > 0;
        let kept = geometry.kept_chips();
        let window = geometry.window();
        let replayed = geometry.most_chips() - 1;
        let mask_width = lanes.saturating_sub(1).max(1);
        let mask = (1 << geometry.first_delay) - 1;
        let reload = "after reset and at a scan's start";
        let by_samples = |part| Optional::new(grows_by_samples, part);
        let replays =
            |about: &str| Optional::new(replayed > 0, Register::word(replayed.max(1), 0, about));
        let taps: Vec<(u32, u32)> = (0..window).map(|sample| geometry.tap(sample)).collect();
        // Where the delay stays within a chip, which lanes take the previous
        // chip is known beforehand.
        let one_more = |place: u32| u32::from(geometry.may_be_delayed(place));
        let fixed = |place: u32| if grows_by_samples { 0 } else { one_more(place) };
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
        PhaseStepper {
            i_clk: Input::bit("one chip per cycle"),
            i_rst: Input::bit("synchronous, active high"),
            i_chip: Input::bit("next chip of the reference"),
            i_step_ends: Optional::new(
                looks_ahead && grows_by_samples,
                Input::bit("the next clock is the last of a phase step"),
            ),
            i_step_end: Input::bit("last clock of a phase step"),
            i_start: Optional::new(realigns, Input::bit("a scan begins with the next clock")),
            o_advance: Output::bit("the reference generator goes on to its next chip"),
            o_reference: (0..parallel)
                .map(|step| Output::word(lanes, reference_about(step, parallel)))
                .collect(),
            about: describe(geometry),
            chips_load: Constant::new(start.chips, kept, format!("Reference chips {reload}")),
            delayed_load: by_samples_constant(grows_by_samples, mask, mask_width, reload),
            chips: Register::word(
                kept,
                start.chips,
                "reference chips, the present one in bit 0, those before it above",
            )
            .reset_to("chips_load"),
            delayed: by_samples(
                Register::word(mask_width, mask, "lanes that take the previous chip")
                    .reset_to("delayed_load$0"),
            ),
            wraps: Optional::new(
                looks_ahead && grows_by_samples,
                Register::bit(
                    false,
                    "this clock ends a step, and the next delays by a chip more",
                ),
            ),
            saved: replays("chips that the reference went back by, the next one on top"),
            replays: replays("which of them are still to come again"),
            longer: Optional::new(
                grows_by_samples,
                Wiring::new(
                    mask_width as usize + 1,
                    longer.collect(),
                    "delayed lanes of the next step",
                ),
            ),
            present: Wiring::new(kept as usize, present.collect(), "chip of a sample"),
            previous: Optional::new(
                grows_by_samples,
                Wiring::new(
                    kept as usize,
                    previous.collect(),
                    "chip of a sample that is delayed",
                ),
            ),
            takes_previous: Optional::new(
                grows_by_samples,
                Wiring::new(lanes as usize, places.collect(), "samples that are delayed"),
            ),
            window: Register::word(window, 0, "reference of each sample"),
            taps: if parallel > 1 {
                let wiring = || {
                    Wiring::new(
                        lanes as usize,
                        (0..lanes as usize).collect(),
                        "samples of a step",
                    )
                };
                (0..parallel).map(|_| wiring()).collect()
            } else {
                Vec::new()
            },
            wrap: Optional::new(
                grows_by_samples,
                Local::bit("the next step delays by a whole chip more"),
            ),
            hold: Optional::new(replayed > 0, Local::bit("the reference generator waits")),
            chip: Optional::new(replayed > 0, Local::bit("chip that comes next")),
            _chips: kept as usize,
            _lanes: lanes as usize,
            _parallel: parallel as usize,
            _step_samples: samples as usize,
            _step_chips: chips as usize,
            _replayed: replayed as usize,
            _advances_at_step_end: usize::from(chips == 0),
        }
    }
}

fn by_samples_constant(present: bool, mask: u128, width: u32, reload: &str) -> Optional<Constant> {
    Optional::new(
        present,
        Constant::new(mask, width, format!("Delayed lanes {reload}")),
    )
}

fn reference_about(step: u32, parallel: u32) -> String {
    match parallel {
        1 => "reference of each sample, bit 0 earliest".to_owned(),
        _ => format!("reference of each sample for step {step} of the group, bit 0 earliest"),
    }
}

fn describe(geometry: PhaseGeometry) -> About {
    let title = match geometry.parallel {
        1 => "the reference, delayed by one more sample with every phase step".to_owned(),
        parallel => format!(
            "the reference for {parallel} phase steps at once, delayed by {parallel} more samples \
             with every group"
        ),
    };
    let mut about = About::new("phase_stepper", &title);
    if geometry.lanes > 1 {
        about = about.note(
            "Lanes below the delay take the previous chip, the others the present one; whole \
             chips of delay come from holding the reference's generator.",
        );
    }
    if geometry.samples() > 0 {
        about = about.note(
            "The mask of delayed lanes is a thermometer, so that no lane needs a comparator. \
             When it is full, the next step holds the reference for one chip more.",
        );
    }
    if geometry.most_chips() > 1 {
        about = about.note(
            "When the delay grows by several chips, the reference goes back by all but one of \
             them; those come again from a register while the generator waits.",
        );
    }
    about
        .fact("Latency", "1 clock from the chips to o_reference")
        .fact("Rate", "one chip per clock")
}

impl Logic for PhaseStepper {
    #[hdl_gen]
    fn update(&mut self) {
        dff_setup!(self, i_clk, chips, window);
        for c in 0..self._chips {
            self.present.i[c].next = self.chips.q.val().get_bit(c);
        }
        for _by_chips in self.delayed.count()..1 {
            self.window.d.next = self.present.o.val();
        }
        for _by_samples in 0..self.delayed.count() {
            dff_setup!(self, i_clk, delayed[0]);
            for c in 0..self._chips {
                self.previous[0].i[c].next = self.chips.q.val().get_bit(c);
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
                        self.i_step_end.val() & self.delayed[0].q.val().get_bit(full);
                }
            }
            for shorter in
                (self._lanes - self._step_samples)..(self._lanes - self._step_samples + 1)
            {
                if self.wrap[0].val() {
                    self.delayed[0].d.next = self.delayed[0].q.val() >> shorter;
                } else if self.i_step_end.val() {
                    self.delayed[0].d.next = self.longer[0].o.val();
                }
            }
        }

        for _within_a_chip in 0..self._advances_at_step_end {
            self.o_advance.next = !self.wrap[0].val();
            if !self.wrap[0].val() {
                self.chips.d.next =
                    (self.chips.q.val() << 1) | bit_cast(self.i_chip.val(), self._chips);
            }
        }
        for _whole_chips in self._advances_at_step_end..1 {
            for _one_chip in self.saved.count()..1 {
                self.o_advance.next = !self.i_step_end.val();
            }
            for _replays in 0..self.saved.count() {
                dff_setup!(self, i_clk, saved[0], replays[0]);
                for top in (self._replayed.saturating_sub(1))..self._replayed {
                    self.hold[0].next =
                        self.i_step_end.val() | self.replays[0].q.val().get_bit(top);
                    if self.replays[0].q.val().get_bit(top) {
                        self.chip[0].next = self.saved[0].q.val().get_bit(top);
                    } else {
                        self.chip[0].next = self.i_chip.val();
                    }
                }
                self.o_advance.next = !self.hold[0].val();
                self.saved[0].d.next = self.saved[0].q.val() << 1;
                self.replays[0].d.next = self.replays[0].q.val() << 1;
            }
            for back in self._step_chips..(self._step_chips + 1) {
                if self.i_step_end.val() {
                    self.chips.d.next = self.chips.q.val() >> (back - 1);
                    for _replays in 0..self.saved.count() {
                        for _by_samples in 0..self.delayed.count() {
                            self.saved[0].d.next =
                                bit_cast(self.chips.q.val(), self._replayed) << 1;
                            self.replays[0].d.next = !bit_cast(false, self._replayed) << 1;
                        }
                        for _by_chips in self.delayed.count()..1 {
                            self.saved[0].d.next = bit_cast(self.chips.q.val(), self._replayed);
                            self.replays[0].d.next = !bit_cast(false, self._replayed);
                        }
                    }
                } else {
                    for _one_chip in self.saved.count()..1 {
                        self.chips.d.next =
                            (self.chips.q.val() << 1) | bit_cast(self.i_chip.val(), self._chips);
                    }
                    for _replays in 0..self.saved.count() {
                        self.chips.d.next =
                            (self.chips.q.val() << 1) | bit_cast(self.chip[0].val(), self._chips);
                    }
                }
                for _by_samples in 0..self.delayed.count() {
                    if self.wrap[0].val() {
                        self.chips.d.next = self.chips.q.val() >> back;
                        self.saved[0].d.next = bit_cast(self.chips.q.val(), self._replayed);
                        self.replays[0].d.next = !bit_cast(false, self._replayed);
                    }
                }
            }
        }

        for _realigns in 0..self.i_start.count() {
            if self.i_start[0].val() {
                self.chips.d.next = self.chips_load.val();
                for _by_samples in 0..self.delayed.count() {
                    self.delayed[0].d.next = self.delayed_load[0].val();
                }
                for _replays in 0..self.saved.count() {
                    self.replays[0].d.next = 0.into();
                }
            }
        }

        for _one_step in self._parallel..2 {
            self.o_reference[0].next = self.window.q.val();
        }
        for last in (self._parallel - 1)..self._parallel {
            for p in 0..(self.taps.len()) {
                for l in 0..self._lanes {
                    self.taps[p].i[l].next = self.window.q.val().get_bit(l + last - p);
                }
                self.o_reference[p].next = self.taps[p].o.val();
            }
        }
    }
}
