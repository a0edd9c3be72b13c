//! Tests: each description without a single meaning is refused with its own
//! fault, and never written.

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

/// A test that such a block of four bits, with a kernel, is refused for one reason.
macro_rules! refused {
    ($test:ident: $name:ident => $fault:expr; $($kernel:tt)*) => {
        block!($name);

        #[kernel]
        impl Logic for $name {
            $($kernel)*
        }

        #[test]
        fn $test() {
            assert_eq!(fault_of(&$name::new(4, 4, 4)), $fault);
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

refused! { a_latch_is_refused: Latch => Fault::Latch { signal: named("o_y") };
    fn update(&mut self) {
        self.count.next = self.i_b.val() + self.limit.val();
        self.middle.next = self.i_a.val();
        if self.i_go.val() {
            self.o_y.next = self.middle.val() ^ self.count.val();
        }
    }
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

refused! { an_oversize_literal_is_refused: Oversize => Fault::OversizeLiteral { value: 17, width: 4 };
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
fn a_literal_that_fits_is_not() {
    assert!(verilog_of(&Oversize::new(5, 5, 5), &Prefix::default(), "a test").is_ok());
}

refused! { an_undriven_signal_is_refused: Undriven => Fault::Undriven { signal: named("middle") };
    fn update(&mut self) {
        if self.i_go.val() {
            self.count.next = self.i_b.val() + self.limit.val();
        }
        self.o_y.next = self.middle.val() ^ self.i_a.val() ^ self.count.val();
    }
}

refused! { a_second_driver_is_refused: TwoDrivers => Fault::MultipleDrivers { signal: named("middle") };
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

refused! { driving_a_registers_content_beside_the_register_is_refused: DrivesQ => Fault::MultipleDrivers { signal: named("count_r") };
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

refused! { driving_an_own_input_is_refused: DrivesInput => Fault::OwnInputDriven { signal: named("i_go") };
    fn update(&mut self) {
        self.count.next = self.i_b.val() + self.limit.val();
        self.middle.next = self.count.val();
        self.i_go.next = false;
        self.i_a.next = self.middle.val();
        self.o_y.next = self.middle.val();
    }
}

refused! { a_signal_that_nothing_reads_is_refused: Unread => Fault::Unread { signal: named("middle") };
    fn update(&mut self) {
        self.middle.next = self.i_a.val();
        if self.i_go.val() {
            self.count.next = self.i_b.val() + self.limit.val();
        }
        self.o_y.next = self.count.val();
    }
}

refused! { an_assignment_after_a_read_is_refused: Reassigned => Fault::AssignedAfterRead { signal: named("middle") };
    fn update(&mut self) {
        self.count.next = self.i_b.val() + self.limit.val();
        self.middle.next = self.i_a.val();
        self.o_y.next = self.middle.val() ^ self.count.val();
        if self.i_go.val() {
            self.middle.next = self.count.val();
        }
    }
}

refused! { a_combinational_loop_is_refused: Loops => Fault::AssignedAfterRead { signal: named("middle") };
    fn update(&mut self) {
        self.count.next = self.i_b.val() + self.limit.val();
        self.o_y.next = self.middle.val() ^ self.count.val() ^ signed_cast(self.i_go.val());
        self.middle.next = self.o_y.val() + self.i_a.val();
    }
}

refused! { a_bit_beyond_the_vector_is_refused: OutOfRange => Fault::OutOfRange { bit: 4, width: 4 };
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

refused! { a_literal_without_a_width_is_refused: NoWidth =>
    Fault::NoWidth { expression: "literal 1".to_owned() };
    fn update(&mut self) {
        self.count.next = self.i_b.val() + self.limit.val();
        self.middle.next = self.i_a.val() ^ self.count.val();
        if self.i_go.val() {
            self.o_y.next = self.middle.val();
        } else {
            self.o_y.next = bit_cast(1 == 2, 4);
        }
    }
}

#[block(unsound)]
/// a block of a test
struct Absent {
    has: bool,
    #[when(has)]
    #[width(4)]
    gone: Optional<Local<Word>>,
    #[width(4)]
    o_y: Output<Word>,
}

#[kernel]
impl Logic for Absent {
    fn update(&mut self) {
        self.o_y.next = self.gone.val();
    }
}

#[test]
fn a_part_that_is_not_there_is_refused() {
    assert_eq!(fault_of(&Absent::new(false)), Fault::UnknownName { name: named("gone") });
}

#[block(unsound)]
/// a block of a test
struct Reserved {
    table: Output<bool>,
}

#[kernel]
impl Logic for Reserved {
    fn update(&mut self) {
        self.table.next = true;
    }
}

#[test]
fn a_keyword_as_a_name_is_refused() {
    assert!(matches!(fault_of(&Reserved::new()), Fault::BadName { .. }));
}
