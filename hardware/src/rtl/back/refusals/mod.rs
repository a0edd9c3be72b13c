//! Tests: each description without a single meaning is refused with its own
//! fault, and never written.

mod by_hand;

use super::{Fault, Prefix, verilog_of};
use crate::rtl::front::prelude::*;

fn fault_of(block: &dyn Block) -> Fault {
    match verilog_of(block, &Prefix::default(), "a test") {
        Ok(modules) => panic!("written though unsound:\n{}", modules[0].text),
        Err(refusal) => refusal.fault,
    }
}

fn named(signal: &str) -> String {
    signal.to_owned()
}

/// A block with some of everything; each test adds a kernel.
macro_rules! block {
    ($name:ident) => {
        #[derive(LogicBlock)]
        struct $name {
            i_a: Input<Word>,
            i_b: Input<Word>,
            i_go: Input<bool>,
            o_y: Output<Word>,
            about: About,
            middle: Local<Word>,
            limit: Constant,
            count: Register<Word>,
        }

        impl $name {
            fn new(a: u32, b: u32, y: u32) -> Self {
                $name {
                    i_a: Input::word(a, ""),
                    i_b: Input::word(b, ""),
                    i_go: Input::bit(""),
                    o_y: Output::word(y, ""),
                    about: About::new("unsound", "a block of a test"),
                    middle: Local::word(y, ""),
                    limit: Constant::new(5, y, ""),
                    count: Register::word(y, 0, ""),
                }
            }
        }
    };
}

block!(Sound);

impl Logic for Sound {
    #[hdl_gen]
    fn update(&mut self) {
        if self.i_go.val() {
            self.count.d.next = self.count.q.val() + self.limit.val();
        }
        self.middle.next = self.i_a.val() ^ self.i_b.val();
        self.o_y.next = self.middle.val() & self.count.q.val();
    }
}

#[test]
fn the_block_that_the_others_spoil_is_sound() {
    let modules = verilog_of(&Sound::new(4, 4, 4), &Prefix::default(), "a test")
        .expect("nothing is wrong with it");
    assert_eq!(modules.len(), 1);
    assert_eq!(modules[0].name, "unsound");
}

block!(Latch);

impl Logic for Latch {
    #[hdl_gen]
    fn update(&mut self) {
        self.count.d.next = self.i_b.val() + self.limit.val();
        self.middle.next = self.i_a.val();
        if self.i_go.val() {
            self.o_y.next = self.middle.val() ^ self.count.q.val();
        }
    }
}

#[test]
fn a_latch_is_refused() {
    assert_eq!(fault_of(&Latch::new(4, 4, 4)), Fault::Latch { signal: named("o_y") });
}

#[test]
fn unequal_widths_are_refused() {
    assert_eq!(
        fault_of(&Sound::new(4, 3, 4)),
        Fault::WidthMismatch { place: named("operator Xor"), left: 4, right: 3 }
    );
    assert_eq!(
        fault_of(&Sound::new(3, 3, 4)),
        Fault::WidthMismatch { place: named("`middle`"), left: 4, right: 3 }
    );
}

block!(Oversize);

impl Logic for Oversize {
    #[hdl_gen]
    fn update(&mut self) {
        self.count.d.next = self.i_b.val() + self.limit.val();
        self.middle.next = self.i_a.val() + 17;
        if self.i_go.val() {
            self.o_y.next = self.middle.val();
        } else {
            self.o_y.next = self.count.q.val();
        }
    }
}

#[test]
fn an_oversize_literal_is_refused() {
    assert_eq!(fault_of(&Oversize::new(4, 4, 4)), Fault::OversizeLiteral { value: 17, width: 4 });
    assert!(verilog_of(&Oversize::new(5, 5, 5), &Prefix::default(), "a test").is_ok());
}

block!(Undriven);

impl Logic for Undriven {
    #[hdl_gen]
    fn update(&mut self) {
        if self.i_go.val() {
            self.count.d.next = self.i_b.val() + self.limit.val();
        }
        self.o_y.next = self.middle.val() ^ self.i_a.val() ^ self.count.q.val();
    }
}

#[test]
fn an_undriven_signal_is_refused() {
    assert_eq!(fault_of(&Undriven::new(4, 4, 4)), Fault::Undriven { signal: named("middle") });
}

block!(TwoDrivers);

impl Logic for TwoDrivers {
    #[hdl_gen]
    fn update(&mut self) {
        self.count.d.next = self.i_b.val() + self.limit.val();
        self.middle.next = self.i_a.val();
        self.middle.next = self.count.q.val();
        if self.i_go.val() {
            self.o_y.next = self.middle.val();
        } else {
            self.o_y.next = 0.into();
        }
    }
}

#[test]
fn a_second_driver_is_refused() {
    assert_eq!(
        fault_of(&TwoDrivers::new(4, 4, 4)),
        Fault::MultipleDrivers { signal: named("middle") }
    );
}

block!(DrivesQ);

impl Logic for DrivesQ {
    #[hdl_gen]
    fn update(&mut self) {
        self.middle.next = self.i_a.val() ^ self.i_b.val() ^ self.limit.val();
        self.count.q.next = self.middle.val();
        if self.i_go.val() {
            self.o_y.next = self.count.q.val();
        } else {
            self.o_y.next = 0.into();
        }
    }
}

#[test]
fn driving_a_registers_content_beside_the_register_is_refused() {
    assert_eq!(
        fault_of(&DrivesQ::new(4, 4, 4)),
        Fault::MultipleDrivers { signal: named("count_r") }
    );
}

block!(DrivesInput);

impl Logic for DrivesInput {
    #[hdl_gen]
    fn update(&mut self) {
        self.count.d.next = self.i_b.val() + self.limit.val();
        self.middle.next = self.count.q.val();
        self.i_go.next = false;
        self.i_a.next = self.middle.val();
        self.o_y.next = self.middle.val();
    }
}

#[test]
fn driving_an_own_input_is_refused() {
    assert_eq!(
        fault_of(&DrivesInput::new(4, 4, 4)),
        Fault::OwnInputDriven { signal: named("i_go") }
    );
}

block!(Unread);

impl Logic for Unread {
    #[hdl_gen]
    fn update(&mut self) {
        self.middle.next = self.i_a.val();
        if self.i_go.val() {
            self.count.d.next = self.i_b.val() + self.limit.val();
        }
        self.o_y.next = self.count.q.val();
    }
}

#[test]
fn a_signal_that_nothing_reads_is_refused() {
    assert_eq!(fault_of(&Unread::new(4, 4, 4)), Fault::Unread { signal: named("middle") });
}

block!(Reassigned);

impl Logic for Reassigned {
    #[hdl_gen]
    fn update(&mut self) {
        self.count.d.next = self.i_b.val() + self.limit.val();
        self.middle.next = self.i_a.val();
        self.o_y.next = self.middle.val() ^ self.count.q.val();
        if self.i_go.val() {
            self.middle.next = self.count.q.val();
        }
    }
}

#[test]
fn an_assignment_after_a_read_is_refused() {
    assert_eq!(
        fault_of(&Reassigned::new(4, 4, 4)),
        Fault::AssignedAfterRead { signal: named("middle") }
    );
}

block!(Loops);

impl Logic for Loops {
    #[hdl_gen]
    fn update(&mut self) {
        self.count.d.next = self.i_b.val() + self.limit.val();
        self.o_y.next = self.middle.val() ^ self.count.q.val() ^ signed_cast(self.i_go.val());
        self.middle.next = self.o_y.val() + self.i_a.val();
    }
}

#[test]
fn a_combinational_loop_is_refused() {
    assert_eq!(
        fault_of(&Loops::new(4, 4, 4)),
        Fault::AssignedAfterRead { signal: named("middle") }
    );
}

block!(OutOfRange);

impl Logic for OutOfRange {
    #[hdl_gen]
    fn update(&mut self) {
        self.count.d.next = self.i_b.val() + self.limit.val();
        self.middle.next = self.i_a.val() ^ self.count.q.val();
        if self.i_go.val() & self.middle.val().get_bit(4) {
            self.o_y.next = self.middle.val();
        } else {
            self.o_y.next = 0.into();
        }
    }
}

#[test]
fn a_bit_beyond_the_vector_is_refused() {
    assert_eq!(fault_of(&OutOfRange::new(4, 4, 4)), Fault::OutOfRange { bit: 4, width: 4 });
}

/// A run-time field in an expression, which rust-hdl turns into a name that
/// the Verilog does not have.
#[derive(LogicBlock)]
struct LeaksField {
    i_a: Input<Word>,
    o_y: Output<Word>,
    about: About,
    _shift: usize,
}

impl Logic for LeaksField {
    #[hdl_gen]
    fn update(&mut self) {
        self.o_y.next = self.i_a.val() << self._shift;
    }
}

#[test]
fn a_field_that_is_no_signal_is_refused() {
    let block = LeaksField {
        i_a: Input::word(4, ""),
        o_y: Output::word(4, ""),
        about: About::new("unsound", "a block of a test"),
        _shift: 2,
    };
    assert!(matches!(fault_of(&block), Fault::Unsupported { .. }));
}
