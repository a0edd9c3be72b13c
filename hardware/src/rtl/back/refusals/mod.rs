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
        #[block(About::new("unsound", "a block of a test"))]
        struct $name {
            a: u32,
            b: u32,
            y: u32,
            #[width(a)]
            i_a: Input<Word>,
            #[width(b)]
            i_b: Input<Word>,
            i_go: Input<bool>,
            #[width(y)]
            o_y: Output<Word>,
            #[width(y)]
            middle: Local<Word>,
            #[width(y)]
            #[value(5)]
            limit: Constant,
            #[width(y)]
            count: Register<Word>,
        }
    };
}

block!(Sound);

#[kernel]
impl Logic for Sound {
    fn update(&mut self) {
        if self.i_go.val() {
            self.count.next = self.count.val() + self.limit.val();
        }
        self.middle.next = self.i_a.val() ^ self.i_b.val();
        self.o_y.next = self.middle.val() & self.count.val();
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

#[kernel]
impl Logic for Latch {
    fn update(&mut self) {
        self.count.next = self.i_b.val() + self.limit.val();
        self.middle.next = self.i_a.val();
        if self.i_go.val() {
            self.o_y.next = self.middle.val() ^ self.count.val();
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

#[kernel]
impl Logic for Oversize {
    fn update(&mut self) {
        self.count.next = self.i_b.val() + self.limit.val();
        self.middle.next = self.i_a.val() + 17;
        if self.i_go.val() {
            self.o_y.next = self.middle.val();
        } else {
            self.o_y.next = self.count.val();
        }
    }
}

#[test]
fn an_oversize_literal_is_refused() {
    assert_eq!(fault_of(&Oversize::new(4, 4, 4)), Fault::OversizeLiteral { value: 17, width: 4 });
    assert!(verilog_of(&Oversize::new(5, 5, 5), &Prefix::default(), "a test").is_ok());
}

block!(Undriven);

#[kernel]
impl Logic for Undriven {
    fn update(&mut self) {
        if self.i_go.val() {
            self.count.next = self.i_b.val() + self.limit.val();
        }
        self.o_y.next = self.middle.val() ^ self.i_a.val() ^ self.count.val();
    }
}

#[test]
fn an_undriven_signal_is_refused() {
    assert_eq!(fault_of(&Undriven::new(4, 4, 4)), Fault::Undriven { signal: named("middle") });
}

block!(TwoDrivers);

#[kernel]
impl Logic for TwoDrivers {
    fn update(&mut self) {
        self.count.next = self.i_b.val() + self.limit.val();
        self.middle.next = self.i_a.val();
        self.middle.next = self.count.val();
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

#[kernel]
impl Logic for DrivesQ {
    fn update(&mut self) {
        self.middle.next = self.i_a.val() ^ self.i_b.val() ^ self.limit.val();
        self.count.q.next = self.middle.val();
        if self.i_go.val() {
            self.o_y.next = self.count.val();
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

#[kernel]
impl Logic for DrivesInput {
    fn update(&mut self) {
        self.count.next = self.i_b.val() + self.limit.val();
        self.middle.next = self.count.val();
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

#[kernel]
impl Logic for Unread {
    fn update(&mut self) {
        self.middle.next = self.i_a.val();
        if self.i_go.val() {
            self.count.next = self.i_b.val() + self.limit.val();
        }
        self.o_y.next = self.count.val();
    }
}

#[test]
fn a_signal_that_nothing_reads_is_refused() {
    assert_eq!(fault_of(&Unread::new(4, 4, 4)), Fault::Unread { signal: named("middle") });
}

block!(Reassigned);

#[kernel]
impl Logic for Reassigned {
    fn update(&mut self) {
        self.count.next = self.i_b.val() + self.limit.val();
        self.middle.next = self.i_a.val();
        self.o_y.next = self.middle.val() ^ self.count.val();
        if self.i_go.val() {
            self.middle.next = self.count.val();
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

#[kernel]
impl Logic for Loops {
    fn update(&mut self) {
        self.count.next = self.i_b.val() + self.limit.val();
        self.o_y.next = self.middle.val() ^ self.count.val() ^ signed_cast(self.i_go.val());
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

#[kernel]
impl Logic for OutOfRange {
    fn update(&mut self) {
        self.count.next = self.i_b.val() + self.limit.val();
        self.middle.next = self.i_a.val() ^ self.count.val();
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
