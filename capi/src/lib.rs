//! The C library of goldtof: `scene`s, the reference `model` clocked in batches, and a
//! `scoreboard` that a testbench feeds clock by clock, from C, C++ or (DPI-C)
//! SystemVerilog. The header `include/goldtof.h` is made from here.
//!
//! Handles are boxes behind a lock. A panic ends at the border (`border`) as an error,
//! and what it left behind is refused from then on.

// What callers have to keep is the same for all functions, and stands at the header's head.
#![allow(clippy::missing_safety_doc)]

mod border;
mod model;
mod scene;
mod scoreboard;
mod status;
