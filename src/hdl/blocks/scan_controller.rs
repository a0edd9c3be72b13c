//! Counts chips and phase steps.

use crate::hdl::front::prelude::*;

/// Says when a phase step, and when a scan, ends.
#[derive(Debug, Clone, LogicBlock)]
pub struct ScanController {
    /// Clock.
    pub i_clk: Input<bool>,
    /// Synchronous reset.
    pub i_rst: Input<bool>,
    /// The next clock begins a code period.
    pub i_epoch: Optional<Input<bool>>,
    /// The present clock belongs to a scan.
    pub o_run: Output<bool>,
    /// Last clock of a phase step.
    pub o_step_end: Output<bool>,
    /// Last clock of a scan.
    pub o_scan_end: Output<bool>,
    /// A scan begins with the next clock.
    pub o_start: Optional<Output<bool>>,
    about: About,
    dwell_reload: Constant,
    steps_reload: Constant,
    run: Register<bool>,
    dwell: Register<Word>,
    steps: Register<Word>,
    dwell_increment: Local<Word>,
    steps_increment: Local<Word>,
    _dwell_bits: usize,
    _steps_bits: usize,
}

impl ScanController {
    /// `dwell_chips` chips per step, `steps` steps per scan; with `realigns`
    /// a scan waits for the code's epoch.
    pub fn new(dwell_chips: u64, steps: u64, realigns: bool) -> ScanController {
        let (dwell_bits, dwell_reload) = carry_counter(dwell_chips);
        let (steps_bits, steps_reload) = carry_counter(steps);
        // Without an epoch to wait for, counting runs on from reset, so reset
        // stands one before the first chip.
        let dwell_reset = dwell_reload - u128::from(!realigns);
        let order = if realigns {
            "A scan begins with a code period; until it does, run is low."
        } else {
            "Scans follow one another without a gap, because a scan over the whole code period \
             ends where it began."
        };
        ScanController {
            i_clk: Input::bit("one chip per cycle"),
            i_rst: Input::bit("synchronous, active high"),
            i_epoch: Optional::new(
                realigns,
                Input::bit("the next clock is the first of a code period"),
            ),
            o_run: Output::bit("the present clock belongs to a scan"),
            o_step_end: Output::bit("last clock of a phase step"),
            o_scan_end: Output::bit("last clock of a scan"),
            o_start: Optional::new(realigns, Output::bit("a scan begins with the next clock")),
            about: About::new(
                "scan_controller",
                "counts chips per phase step and steps per scan",
            )
            .note(
                "Both counters end when their top bit comes up, so that no comparator is \
                     needed, and begin again by adding the reload value instead of 1, so that no \
                     multiplexer stands before the carry chain.",
            )
            .note(order)
            .fact("Dwell", format!("{dwell_chips} chips per phase step"))
            .fact("Scan", format!("{steps} phase steps"))
            .fact("Latency", "0 clocks"),
            dwell_reload: Constant::new(
                dwell_reload,
                dwell_bits + 1,
                "Dwell counter at a step's first chip",
            ),
            steps_reload: Constant::new(
                steps_reload,
                steps_bits + 1,
                "Step counter at a scan's first step",
            ),
            run: Register::bit(false, "the present clock belongs to a scan"),
            dwell: Register::word(
                dwell_bits + 1,
                dwell_reset,
                "chips of the present step; the top bit marks the last",
            ),
            steps: Register::word(
                steps_bits + 1,
                steps_reload,
                "steps of the present scan; the top bit marks the last",
            ),
            dwell_increment: Local::word(dwell_bits + 1, "1, or the reload value"),
            steps_increment: Local::word(steps_bits + 1, "1, or the reload value"),
            _dwell_bits: dwell_bits as usize,
            _steps_bits: steps_bits as usize,
        }
    }
}

/// Width w without the carry, and first value, of a counter that reaches 2^w
/// with the last of `count` counts.
fn carry_counter(count: u64) -> (u32, u128) {
    let increments = count - 1;
    let bits = (64 - increments.leading_zeros()).max(1);
    (bits, (1u128 << bits) - u128::from(increments))
}

impl Logic for ScanController {
    #[hdl_gen]
    fn update(&mut self) {
        dff_setup!(self, i_clk, run, dwell, steps);
        self.o_run.next = self.run.q.val();
        for carry in self._dwell_bits..(self._dwell_bits + 1) {
            for _waits in 0..self.i_epoch.count() {
                self.o_step_end.next = self.run.q.val() & self.dwell.q.val().get_bit(carry);
            }
            for _runs_on in self.i_epoch.count()..1 {
                self.o_step_end.next = self.dwell.q.val().get_bit(carry);
            }
            if self.dwell.q.val().get_bit(carry) {
                self.dwell_increment.next = self.dwell_reload.val();
            } else {
                self.dwell_increment.next = 1.into();
            }
        }
        self.dwell.d.next = bit_cast(
            bit_cast(self.dwell.q.val(), self._dwell_bits),
            self._dwell_bits + 1,
        ) + self.dwell_increment.val();
        for carry in self._steps_bits..(self._steps_bits + 1) {
            self.o_scan_end.next = self.o_step_end.val() & self.steps.q.val().get_bit(carry);
            if self.steps.q.val().get_bit(carry) {
                self.steps_increment.next = self.steps_reload.val();
            } else {
                self.steps_increment.next = 1.into();
            }
        }
        if self.o_step_end.val() {
            self.steps.d.next = bit_cast(
                bit_cast(self.steps.q.val(), self._steps_bits),
                self._steps_bits + 1,
            ) + self.steps_increment.val();
        }
        for _waits in 0..self.i_epoch.count() {
            self.o_start[0].next =
                self.i_epoch[0].val() & (!self.run.q.val() | self.o_scan_end.val());
            if self.o_start[0].val() {
                self.run.d.next = true;
                self.dwell.d.next = self.dwell_reload.val();
                self.steps.d.next = self.steps_reload.val();
            } else if self.o_scan_end.val() {
                self.run.d.next = false;
            }
        }
        for _runs_on in self.i_epoch.count()..1 {
            self.run.d.next = true;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_carry_counter_carries_with_its_last_count() {
        for count in [1, 2, 3, 4, 5, 127, 128, 129, 13_100, u64::MAX] {
            let (bits, first) = carry_counter(count);
            assert!(first >= 1, "reset stands one before it");
            assert_eq!(first + u128::from(count - 1), 1 << bits);
        }
    }
}
