//! A netlist as C++ in which every net is a vector of 256 lanes.
//!
//! The statements are those of [`super::verilog`], in another language, so that what one pass does
//! is the same; the compiler makes vector instructions of them where the processor has any
//! (GCC's `vector_size`), and several of its widest words elsewhere. Verilator's 64 lanes say
//! in each run whether it did so rightly ([`super::referee`]).

use std::collections::HashMap;
use std::fmt::Write as _;

use super::netlist::{BitNet, GateNetlist};
use super::verilog::{Branch, Language, outputs_of_no_register, outputs_text};

/// Lanes of a vector.
pub const LANES: usize = 256;

/// What a plane is: a word that need not be where such words are best.
const PLANE: &str = "\
#include <cstdint>
#define GOLDTOF_WITHOUT_VERILATOR
#define LANES_WORDS 4
typedef uint64_t Plane __attribute__((vector_size(32), may_alias));
typedef uint64_t Stored __attribute__((vector_size(32), aligned(8), may_alias));
static inline bool any(const Plane& plane) {
#ifdef __AVX__
    typedef long long Whole __attribute__((vector_size(32)));
    return !__builtin_ia32_ptestz256((Whole)plane, (Whole)plane);
#else
    return (plane[0] | plane[1] | plane[2] | plane[3]) != 0;
#endif
}
";

/// Writes all nets that outlive a clock, and what a clock does. `reset` is the net of
/// `i_rst`, if lanes are clocked apart where it is low.
pub(super) fn model(netlist: &GateNetlist, reset: Option<BitNet>) -> String {
    let mut text = format!("{PLANE}struct LanesRoot {{\n");
    let inputs: usize = netlist.inputs.iter().map(|port| port.nets.len()).sum();
    let numbered = (0..inputs).map(|i| ('i', i));
    let registers = (0..netlist.registers.len()).map(|i| ('q', i));
    for (kind, i) in
        numbered.chain(registers).chain(outputs_of_no_register(netlist).map(|i| ('y', i)))
    {
        let _ = writeln!(text, "    Plane {kind}{i};");
    }
    let shown = outputs_text(netlist, Language::Cpp);
    let mut clocked = |name: &str, netlist: &GateNetlist| {
        let branch = Branch::write(netlist, "g", Language::Cpp);
        let _ = writeln!(text, "    void {name}() {{");
        for name in &branch.variables {
            let _ = writeln!(text, "    Plane {name};");
        }
        let _ = writeln!(text, "{}{shown}    }}", branch.text);
    };
    clocked("clock_in_reset", netlist);
    let tied = reset.map(|reset| netlist.with_tied(&HashMap::from([(reset, false)])));
    clocked("clock", tied.as_ref().unwrap_or(netlist));
    text += "};\nstatic LanesRoot lanes;\n\
             static inline LanesRoot& lanes_start() { return lanes; }\n\
             static inline void lanes_clock(LanesRoot& root, bool in_reset) {\n    \
             if (in_reset) root.clock_in_reset(); else root.clock();\n}\n";
    text
}

/// What the compiler is told of this processor. With AVX-512 it makes one operation of some two or
/// three, and has twice the registers; wider vectors gain nothing more.
pub(super) fn compiler_flags() -> &'static [&'static str] {
    #[cfg(target_arch = "x86_64")]
    {
        if std::arch::is_x86_feature_detected!("avx512vl") {
            return &["-mavx512vl"];
        }
        if std::arch::is_x86_feature_detected!("avx2") {
            return &["-mavx2"];
        }
    }
    // Vectors in memory alone: no function takes one.
    &["-Wno-psabi"]
}
