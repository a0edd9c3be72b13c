//! Counts that came at once, one after another.

use crate::hdl::front::prelude::*;

/// Holds the counts of a group, or a piece of each, and gives one per clock.
#[derive(Debug, Clone, LogicBlock)]
pub struct CountQueue {
    /// Clock.
    pub i_clk: Input<bool>,
    /// Synchronous reset.
    pub i_rst: Input<bool>,
    /// Take over the group's counts.
    pub i_load: Input<bool>,
    /// Bits of each count of the group.
    pub i_count: Vec<Input<Word>>,
    /// Bits of the count whose turn it is, from a clock after `i_load` on.
    pub o_count: Output<Word>,
    about: About,
    count: Vec<Register<Word>>,
    _steps: usize,
}

impl CountQueue {
    /// For `bits` bits of the counts of `steps` phase steps.
    pub fn new(bits: u32, steps: u32) -> CountQueue {
        let steps = steps as usize;
        CountQueue {
            i_clk: Input::bit("one count per cycle"),
            i_rst: Input::bit("synchronous, active high"),
            i_load: Input::bit("take over the group's counts"),
            i_count: (0..steps)
                .map(|step| Input::word(bits, format!("count of step {step} of the group")))
                .collect(),
            o_count: Output::word(bits, "the count whose turn it is"),
            about: About::new("count_queue", "the counts of a group, one per clock")
                .fact("Latency", "1 clock from i_load to the first count")
                .fact("Rate", format!("a group every {steps} clocks")),
            count: (0..steps)
                .map(|step| {
                    Register::word(bits, 0, format!("count whose turn is {step} clocks on"))
                })
                .collect(),
            _steps: steps,
        }
    }
}

impl Logic for CountQueue {
    #[hdl_gen]
    fn update(&mut self) {
        for s in 0..self._steps {
            dff_setup!(self, i_clk, count[s]);
        }
        for s in 0..(self._steps - 1) {
            self.count[s].d.next = self.count[s + 1].q.val();
        }
        if self.i_load.val() {
            for s in 0..self._steps {
                self.count[s].d.next = self.i_count[s].val();
            }
        }
        self.o_count.next = self.count[0].q.val();
    }
}
