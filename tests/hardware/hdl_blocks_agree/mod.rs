//! Block by block: the rust-hdl simulation, Verilator on the emitted Verilog and
//! a description of what the block is for agree at every clock under random
//! inputs.

mod comparing;
mod counting;
mod sequence;
mod streaming;

use crate::hdl_support::block_testbench::run_in_verilator;
use crate::hdl_support::stimulus::Noise;
use comparing::*;
use counting::*;
use goldtof::sensor::interface::CountSegments;
use sequence::*;
use streaming::*;

/// Clocks of each block's run.
const CLOCKS: usize = 3000;

/// Bit `index` of a value.
pub fn bit(value: u128, index: usize) -> bool {
    value >> index & 1 == 1
}

/// A two's complement number of `bits` bits.
pub fn signed(value: u128, bits: u32) -> i128 {
    ((value << (128 - bits)) as i128) >> (128 - bits)
}

/// The lowest `bits` bits of a number.
pub fn wrapped(value: i128, bits: u32) -> u128 {
    value as u128 & (u128::MAX >> (128 - bits))
}

#[test]
fn every_block_does_in_rust_hdl_and_in_verilator_what_it_is_for() {
    let noise = &mut Noise::new(31);
    let mut cases = code_sources(noise);
    cases.extend(set_code_sources(noise));
    cases.extend([
        edge_detector(noise, 8, 1),
        edge_detector(noise, 4, 3),
        edge_detector(noise, 1, 5),
        cell_combiner(noise, 3, 0),
        cell_combiner(noise, 5, 1),
        cell_combiner(noise, 5, 5),
        cell_combiner(noise, 4, 2),
        cell_combiner(noise, 7, 3),
        cell_combiner(noise, 15, 8),
        quad_counter(noise),
        accumulator(noise),
        updown_correlator(noise),
        count_clamp(noise),
        count_choice(noise),
        count_piece(noise),
        count_comparison(noise),
        state_match(noise),
        scan_controller(noise),
        detector_channel(noise),
        peak_detector(noise, 1),
        peak_detector(noise, 5),
        result_stream(noise, 1, 2, 1, false),
        result_stream(noise, 1, 5, 2, false),
        result_stream(noise, 3, 4, 3, false),
        result_stream(noise, 1, 1, 1, true),
        result_stream(noise, 1, 2, 1, true),
        result_stream(noise, 1, 5, 2, true),
        result_stream(noise, 2, 1, 1, true),
        result_stream(noise, 2, 3, 1, true),
        result_stream(noise, 3, 4, 3, true),
    ]);
    let one = |top_bits| CountSegments { count: 1, lower_bits: top_bits, top_bits };
    let three = CountSegments { count: 3, lower_bits: 4, top_bits: 3 };
    cases.extend([
        hit_counter(noise, 1, one(8), 7),
        hit_counter(noise, 1, one(8), 4),
        hit_counter(noise, 2, one(9), 8),
        hit_counter(noise, 4, three, 10),
        hit_counter(noise, 4, three, 7),
        hit_counter(noise, 8, one(11), 10),
        // Cells whose hits are added up.
        hit_counter(noise, 3, one(9), 8),
        hit_counter(noise, 5, one(11), 10),
        hit_counter(noise, 18, one(12), 11),
        hit_counter(noise, 40, one(12), 7),
    ]);
    let verilog = run_in_verilator(&cases);
    for (case, verilog) in cases.iter().zip(&verilog) {
        case.agrees_with(verilog);
    }
}
