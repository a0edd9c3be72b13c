//! A detector's largest count in a scan, and its phase step.

use super::{CountQueue, MaximumPiece};
use crate::hdl::front::prelude::*;
use crate::model::peak::PeakPlan;

/// Running argmax of one detector's counts (eq. 15), kept from a scan's end to
/// the next.
#[derive(Debug, Clone, LogicBlock)]
pub struct RunningMaximum {
    /// Clock.
    pub i_clk: Input<bool>,
    /// Synchronous reset.
    pub i_rst: Input<bool>,
    /// Counts of the group's steps.
    pub i_count: Vec<Input<Word>>,
    /// They are to be queued, piece by piece, the highest in bit 0.
    pub i_load: Optional<Input<Word>>,
    /// A count is compared, highest piece first.
    pub i_take: Input<bool>,
    /// It is the scan's first.
    pub i_first: Input<bool>,
    /// Phase step of the count whose lowest piece is compared.
    pub i_step: Input<Word>,
    /// The scan's last count has been compared.
    pub i_done: Input<bool>,
    /// Phase step of the last scan's peak.
    pub o_step: Output<Word>,
    /// Its count.
    pub o_count: Output<Word>,
    about: About,
    piece_of_count: Vec<Wiring>,
    queue: Vec<CountQueue>,
    piece: Vec<MaximumPiece>,
    largest: Wiring,
    best_step: Register<Word>,
    step: Register<Word>,
    count: Register<Word>,
    _parallel: usize,
    _pieces: usize,
    _top_bits: usize,
    _piece_bits: usize,
}

impl RunningMaximum {
    /// For the counts of one detector.
    pub fn new(plan: &PeakPlan) -> RunningMaximum {
        let PeakPlan {
            step_bits,
            count_bits,
            pieces,
            parallel,
            has_queue,
            ..
        } = *plan;
        let slice = |piece| {
            let bits = plan.piece_bits(piece) as usize;
            Wiring::new(bits, (0..bits).collect(), "bits of a count")
        };
        let queues = if has_queue { pieces } else { 0 };
        RunningMaximum {
            i_clk: Input::bit("one count per cycle"),
            i_rst: Input::bit("synchronous, active high"),
            i_count: (0..parallel)
                .map(|step| Input::word(count_bits, count_about(step, parallel)))
                .collect(),
            i_load: Optional::new(
                has_queue,
                Input::word(
                    pieces,
                    "counts are there; a bit for each piece, the highest first",
                ),
            ),
            i_take: Input::bit("a count's highest bits are compared"),
            i_first: Input::bit("it is the scan's first"),
            i_step: Input::word(step_bits, "phase step of the count whose lowest bits are"),
            i_done: Input::bit("the scan's last count has been compared"),
            o_step: Output::word(step_bits, "phase step of the last scan's peak"),
            o_count: Output::word(count_bits, "its count, signed"),
            about: about(plan),
            piece_of_count: (0..pieces)
                .flat_map(|piece| (0..parallel).map(move |_| piece))
                .map(slice)
                .collect(),
            queue: (0..queues)
                .map(|piece| CountQueue::new(plan.piece_bits(piece), parallel))
                .collect(),
            piece: (0..pieces)
                .map(|piece| {
                    MaximumPiece::new(plan.piece_bits(piece), piece == 0, piece + 1 == pieces)
                })
                .collect(),
            largest: Wiring::new(
                count_bits as usize,
                (0..count_bits as usize).collect(),
                "largest count so far",
            ),
            best_step: Register::word(step_bits, 0, "phase step of the largest count so far"),
            step: Register::word(step_bits, 0, "phase step of the last scan's peak"),
            count: Register::word(count_bits, 0, "count of the last scan's peak"),
            _parallel: parallel as usize,
            _pieces: pieces as usize,
            _top_bits: plan.piece_bits(0) as usize,
            _piece_bits: plan.piece_bits(pieces - 1) as usize,
        }
    }
}

fn count_about(step: u32, parallel: u32) -> String {
    match parallel {
        1 => "count of a phase step, signed".to_owned(),
        _ => format!("count of step {step} of the group, signed"),
    }
}

fn about(plan: &PeakPlan) -> About {
    let mut about = About::new(
        "running_maximum",
        "a detector's largest count in a scan, and its phase step",
    )
    .note("The first of equal counts is the peak (eq. 15). It stands until the next scan's.");
    if plan.parallel > 1 {
        about = about.note("The counts of a group wait in queues, to be compared one per clock.");
    }
    about.fact(
        "Latency",
        format!(
            "{} clocks from a scan's last i_take to o_step and o_count",
            plan.pieces + 1
        ),
    )
}

impl Logic for RunningMaximum {
    #[hdl_gen]
    fn update(&mut self) {
        dff_setup!(self, i_clk, best_step, step, count);
        for size in self._piece_bits..(self._piece_bits + 1) {
            for lowest in (self._pieces - 1)..self._pieces {
                for parallel in self._parallel..(self._parallel + 1) {
                    for p in 0..self._parallel {
                        for b in 0..self._top_bits {
                            self.piece_of_count[p].i[b].next =
                                self.i_count[p].val().get_bit(size * lowest + b);
                        }
                        for k in 1..self._pieces {
                            for b in 0..self._piece_bits {
                                self.piece_of_count[k * parallel + p].i[b].next =
                                    self.i_count[p].val().get_bit(size * lowest - size * k + b);
                            }
                        }
                    }
                    for k in 0..(self.queue.len()) {
                        self.queue[k].i_clk.next = self.i_clk.val();
                        self.queue[k].i_rst.next = self.i_rst.val();
                        self.queue[k].i_load.next = self.i_load[0].val().get_bit(k);
                        for p in 0..self._parallel {
                            self.queue[k].i_count[p].next =
                                self.piece_of_count[k * parallel + p].o.val();
                        }
                        self.piece[k].i_piece.next = self.queue[k].o_count.val();
                    }
                    for k in (self.queue.len())..self._pieces {
                        self.piece[k].i_piece.next = self.piece_of_count[k].o.val();
                    }
                }
                for b in 0..self._top_bits {
                    self.largest.i[size * lowest + b].next = self.piece[0].o_piece.val().get_bit(b);
                }
                for k in 1..self._pieces {
                    for b in 0..self._piece_bits {
                        self.largest.i[size * lowest - size * k + b].next =
                            self.piece[k].o_piece.val().get_bit(b);
                    }
                }
                if self.piece[lowest].o_greater.val() {
                    self.best_step.d.next = self.i_step.val();
                }
            }
        }
        for k in 0..self._pieces {
            self.piece[k].i_clk.next = self.i_clk.val();
            self.piece[k].i_rst.next = self.i_rst.val();
        }
        self.piece[0].i_take[0].next = self.i_take.val();
        self.piece[0].i_first[0].next = self.i_first.val();
        for k in 1..self._pieces {
            self.piece[k].i_greater[0].next = self.piece[k - 1].o_greater.val();
            self.piece[k].i_equal[0].next = self.piece[k - 1].o_equal[0].val();
        }
        if self.i_done.val() {
            self.step.d.next = self.best_step.q.val();
            self.count.d.next = self.largest.o.val();
        }
        self.o_step.next = self.step.q.val();
        self.o_count.next = self.count.q.val();
    }
}
