//! What the Verilog sends: the beats of its result stream that the receiver took.

pub use super::sent_count::SentCount;
use super::sent_frames::{FrameReader, Misplaced};
use crate::reference::blocks::Records;
use crate::scan::{Group, Grouping};
use crate::scene::DetectorIndex;
use crate::sensor::interface::{Counting, Interface};
use crate::sensor::layout::{Field, Layout, Record};
use crate::sensor::port::PortRole;

/// Reads the result stream of a run, record by record.
///
/// Beats have no address: the order tells whose they are. So it reads from the
/// first reset to the next, and no further than the order holds: not behind a lost
/// result (`o_overrun`), nor behind a beat whose `m_axis_tlast` is not as a scan of
/// this length has it.
#[derive(Debug)]
pub struct SentReader {
    results: Results,
    valid: Bit,
    last: Bit,
    overrun: Bit,
    reset: Bit,
    ready: Bit,
    words: (usize, usize),
    detectors: u64,
    grouping: Grouping,
    /// Beats taken of the present scan.
    taken: u64,
    scan: u64,
    /// The beat on offer before the next clock: its data, and whether it is the last.
    offered: Option<([u64; 2], bool)>,
    state: State,
}

/// What a beat holds.
#[derive(Debug)]
enum Results {
    /// A step's signed count, and the total above it.
    Counts { data: Field, signed_bits: u32, total_bits: Option<u32> },
    /// A row of a histogram.
    Rows(FrameReader),
}

/// Place of a port of one bit in a record.
#[derive(Debug, Clone, Copy)]
struct Bit {
    word: usize,
    mask: u64,
}

impl Bit {
    fn of(record: &Record, port: PortRole) -> Bit {
        let field = record.field(port);
        Bit { word: field.word, mask: 1 << field.shift }
    }

    fn is_high(self, record: &[u64]) -> bool {
        record[self.word] & self.mask != 0
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum State {
    InFirstReset,
    Reading,
    /// What comes belongs to no known step.
    Lost,
}

impl SentReader {
    /// A reader of a run that begins in reset.
    pub fn new(interface: &Interface, layout: &Layout) -> SentReader {
        let (inputs, outputs) = (&layout.inputs, &layout.outputs);
        let data = outputs.field(PortRole::Data).clone();
        SentReader {
            results: match &interface.counting {
                Counting::Correlator(correlator) => Results::Counts {
                    data,
                    signed_bits: correlator.signed_data_bits(),
                    total_bits: correlator
                        .total
                        .map(|total| interface.tdata_bits - total.first_bit),
                },
                Counting::Histogram(plan) => Results::Rows(FrameReader::new(interface, plan, data)),
            },
            valid: Bit::of(outputs, PortRole::Valid),
            last: Bit::of(outputs, PortRole::Last),
            overrun: Bit::of(outputs, PortRole::Overrun),
            reset: Bit::of(inputs, PortRole::Reset),
            ready: Bit::of(inputs, PortRole::Ready),
            words: (inputs.words, outputs.words),
            detectors: interface.reference_codes.len() as u64,
            grouping: interface.grouping(),
            taken: 0,
            scan: 0,
            offered: None,
            state: State::InFirstReset,
        }
    }

    /// Reads the records of the next clocks; `on_sent` gets every beat that was
    /// taken in them.
    pub fn read(&mut self, records: &Records, on_sent: &mut dyn FnMut(SentCount)) {
        let inputs = records.inputs.chunks_exact(self.words.0);
        for (input, output) in inputs.zip(records.got.values.chunks_exact(self.words.1)) {
            if self.state == State::Lost {
                return;
            }
            // What is offered before a clock's edge is taken at it.
            let offered = self.offered.take();
            if self.reset.is_high(input) {
                if self.state == State::Reading {
                    self.state = State::Lost;
                }
                continue;
            }
            self.state = State::Reading;
            if let Some(offered) = offered.filter(|_| self.ready.is_high(input)) {
                self.take(offered, on_sent);
            }
            if self.overrun.is_high(output) {
                self.state = State::Lost;
            } else if self.valid.is_high(output) {
                self.offered = Some(self.beat(output));
            }
        }
    }

    fn beat(&self, output: &[u64]) -> ([u64; 2], bool) {
        let data = match &self.results {
            Results::Counts { data, signed_bits, total_bits } => [
                data.bits(output, 0, *signed_bits),
                total_bits.map_or(0, |bits| data.bits(output, *signed_bits, bits)),
            ],
            Results::Rows(frames) => frames.row(output),
        };
        (data, self.last.is_high(output))
    }

    /// The beat in its place; nothing if it is not where a scan ends, or is and does
    /// not say so.
    fn take(&mut self, (data, last): ([u64; 2], bool), on_sent: &mut dyn FnMut(SentCount)) {
        let counts = match &mut self.results {
            Results::Counts { signed_bits, total_bits, .. } => {
                let unused = 64 - *signed_bits;
                let signed = (data[0] << unused).cast_signed() >> unused;
                (signed, total_bits.map(|_| data[1]))
            }
            Results::Rows(frames) => {
                match frames.take(data, last) {
                    Err(Misplaced) => self.state = State::Lost,
                    Ok(None) => {}
                    Ok(Some(counts)) => {
                        let scan = self.scan;
                        let of_scan = counts.map(|sent| SentCount { scan, ..sent });
                        of_scan.for_each(on_sent);
                        self.scan += 1;
                    }
                }
                return;
            }
        };
        let per_group = self.detectors * self.grouping.parallel;
        let group = Group(self.taken / per_group);
        let steps = self.grouping.steps_of(group).len() as u64;
        let in_group = self.taken % per_group;
        let sent = SentCount {
            scan: self.scan,
            detector: DetectorIndex((in_group / steps) as usize),
            step: self.grouping.step_of(group, in_group % steps).0,
            signed: counts.0,
            total: counts.1,
            bin: None,
        };
        self.taken += 1;
        let ends = self.taken == self.detectors * self.grouping.steps;
        if ends {
            self.taken = 0;
            self.scan += 1;
        }
        if ends == last {
            on_sent(sent);
        } else {
            self.state = State::Lost;
        }
    }
}
