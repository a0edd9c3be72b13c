//! What a verilated model does while its clock is low: mostly nothing.
//!
//! A receiver takes outputs with the next rising edge, with the clock low before it and that
//! edge's inputs there. A model is evaluated and looked at there, too, if anything can have
//! moved by then: where its Verilog looks at the clock for more than its rising edge (latches,
//! gated clocks, falling edges, a clock that is data), where an output follows an input
//! within a clock, and where any net but the clock has edges (an asynchronous reset). Elsewhere that the clock was low is noted directly, which saves a sixth of
//! the time of a small design. A model that is not written as known here, which depends on
//! Verilator's version, is evaluated and looked at.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use super::cache::write;
use super::error::CosimError;
use crate::sensor::interface::Interface;
use crate::sensor::layout::Layout;
use crate::sensor::port::{Direction, Port};

/// Name of the header that `testbench/cosim.cpp` includes.
const HEADER: &str = "goldtof_low.h";

/// What stands before each of a model's members.
const MODEL: &str = "vlSelf->";

/// What is in the name of each function that an input of the model makes it call.
const OF_INPUTS: &str = "___ico_";

/// How the names of members begin that hold what was looked at for an edge, in the versions known.
const LAST: [&str; 2] = ["__Vtrigrprev", "__Vtrigprev"];

/// Writes the header: how the clock falls of the model of `top` in `folder`, and whether it
/// is looked at when it is low.
pub(super) fn write_header(
    folder: &Path,
    top: &str,
    interface: &Interface,
) -> Result<(), CosimError> {
    let ports = interface.ports();
    let outputs = ports.iter().filter(|port| port.direction == Direction::Output);
    let outputs: Vec<&Port> = outputs.collect();
    let generated = generated(folder, top)?;
    let last = last_value(Layout::CLOCK, &generated)
        .filter(|last| !follows(&outputs, &generated) && is_only_edge(last, &generated));
    write(&folder.join(HEADER), &header(top, last.as_deref()))
}

/// Parts of a build's identity: the rule, in both its outcomes.
pub(super) fn identity(top: &str) -> [String; 4] {
    [header(top, Some("LAST")), header(top, None), OF_INPUTS.to_owned(), LAST.concat()]
}

/// Verilator's files of a model.
fn generated(folder: &Path, top: &str) -> Result<Vec<String>, CosimError> {
    let prefix = format!("V{top}");
    let mut texts = Vec::new();
    for entry in fs::read_dir(folder).map_err(CosimError::cache(folder))? {
        let path = entry.map_err(CosimError::cache(folder))?.path();
        let name = path.file_name().and_then(|name| name.to_str());
        if name.is_some_and(|name| {
            name.starts_with(&prefix) && (name.ends_with(".cpp") || name.ends_with(".h"))
        }) {
            texts.push(fs::read_to_string(&path).map_err(CosimError::cache(&path))?);
        }
    }
    Ok(texts)
}

/// `last` is the member with the clock's value at the last evaluation, of a model that is not
/// looked at.
fn header(top: &str, last: Option<&str>) -> String {
    let clock = Layout::CLOCK;
    let mut text = format!("#include \"V{top}___024root.h\"\n");
    let noted = last.map_or(String::new(), |last| format!("    top->rootp->{last} = 0;\n"));
    let _ = write!(
        text,
        "constexpr bool GOLDTOF_LOOKS_AGAIN = {};\n\
         static inline void goldtof_fall(GOLDTOF_MODEL* top) {{\n    top->{clock} = 0;\n{noted}}}\n",
        last.is_none(),
    );
    text
}

/// Whether an output is written where an input of the model is followed.
fn follows(outputs: &[&Port], generated: &[String]) -> bool {
    generated.iter().any(|text| {
        let mut is_of_inputs = false;
        let mut of_inputs = String::new();
        for line in text.lines() {
            let is_head = !line.starts_with(char::is_whitespace) && !line.ends_with(';');
            if is_head && line.contains(OF_INPUTS) {
                is_of_inputs = true;
            } else if line.starts_with('}') {
                is_of_inputs = false;
            }
            if is_of_inputs {
                of_inputs.extend([line, "\n"]);
            }
        }
        let of_inputs = compact(&of_inputs);
        outputs.iter().any(|output| is_written(output, &of_inputs))
    })
}

/// Whether a compact text writes an output: `name=`, or a function does, of one that is several
/// words and that it is handed.
fn is_written(output: &Port, text: &str) -> bool {
    let is_part = |c: char| c.is_alphanumeric() || c == '_';
    text.match_indices(&output.name).any(|(at, name)| {
        let (before, after) = (&text[..at], &text[at + name.len()..]);
        let is_whole = !before.ends_with(is_part) && !after.starts_with(is_part);
        let is_assigned = after.starts_with('=') && !after.starts_with("==");
        is_whole && (is_assigned || output.width > u64::BITS)
    })
}

/// Whether a model waits for no edge but that of the clock, whose last value has this name.
fn is_only_edge(last: &str, generated: &[String]) -> bool {
    let is_part = |c: char| c.is_alphanumeric() || c == '_';
    generated.iter().all(|text| {
        LAST.iter().flat_map(|start| text.match_indices(start)).all(|(at, _)| {
            let name = text[at..].split(|c| !is_part(c)).next();
            text[..at].ends_with(is_part) || name == Some(last)
        })
    })
}

/// The member with the clock's value at the last evaluation, of a model that looks at the
/// clock for nothing but its rising edge.
fn last_value(clock: &str, generated: &[String]) -> Option<String> {
    let mut last: Option<String> = None;
    let mut has_edge = false;
    for text in generated {
        let text = compact(text);
        for (at, _) in text.match_indices(clock) {
            let (before, after) = (&text[..at], &text[at + clock.len()..]);
            let is_part = |c: char| c.is_alphanumeric() || c == '_';
            if before.ends_with(is_part) || after.starts_with(is_part) {
                continue;
            }
            match Use::of(before, after)? {
                Use::Port => {}
                Use::RisingEdge(name) | Use::Noted(name)
                    if last.get_or_insert_with(|| name.to_owned()) != name =>
                {
                    return None;
                }
                Use::RisingEdge(_) => has_edge = true,
                Use::Noted(_) => {}
            }
        }
    }
    last.filter(|_| has_edge)
}

/// What a place in a model's text does with the clock.
enum Use<'t> {
    /// It is a port, starts with some value, and is saved with the model.
    Port,
    /// It is compared with its last value, which has this name.
    RisingEdge(&'t str),
    /// It is kept as the last value.
    Noted(&'t str),
}

impl<'t> Use<'t> {
    /// `None` for anything else.
    fn of(before: &'t str, after: &'t str) -> Option<Use<'t>> {
        let is_port =
            ["VL_IN8(", "VL_IN8(&", "{vlSymsp->TOP."].iter().any(|start| before.ends_with(start))
                || ["os<<", "os>>"].iter().any(|saved| before.ends_with(saved));
        if is_port || after.starts_with("{vlSymsp->TOP.") {
            return Some(Use::Port);
        }
        let before = before.strip_suffix(MODEL)?;
        if after.starts_with("=VL_RAND_RESET") || after.starts_with("=VL_SCOPED_RAND_RESET") {
            return Some(Use::Port);
        }
        if before.ends_with("(IData)(")
            && let Some(rest) = after.strip_prefix(")&(~(IData)(vlSelf->")
        {
            return rest.split_once(')').map(|(name, _)| Use::RisingEdge(name));
        }
        let name = before.strip_suffix('=').filter(|_| after.starts_with(';'))?;
        let start = name.rfind(MODEL)? + MODEL.len();
        Some(Use::Noted(&name[start..]))
    }
}

/// A text without white space, comments, and what is compiled for debugging alone; the
/// model's name is the same in all versions of Verilator.
fn compact(text: &str) -> String {
    let mut kept = String::new();
    let mut is_for_debugging = false;
    for line in text.lines() {
        match line.trim() {
            "#ifdef VL_DEBUG" => is_for_debugging = true,
            line if line.starts_with("#endif") => is_for_debugging = false,
            _ if is_for_debugging => {}
            line => {
                let code = line.split("//").next().unwrap_or_default();
                kept.extend(code.chars().filter(|c| !c.is_whitespace()));
            }
        }
    }
    kept.replace("vlSelfRef.", MODEL)
}

#[cfg(test)]
mod tests {
    use super::{follows, is_only_edge, last_value};
    use crate::sensor::port::PortRole;

    /// What Verilator 5.006 and 5.048 write of a clock, in their own words.
    const MODELS: [(&str, &str); 2] = [
        (
            "VL_IN8(&i_clk,0,0);\n , i_clk{vlSymsp->TOP.i_clk}\n\
             vlSelf->__VactTriggered.at(0U) = ((IData)(vlSelf->i_clk) \n  & (~ \
             (IData)(vlSelf->__Vtrigrprev__TOP__i_clk)));\n\
             vlSelf->__Vtrigrprev__TOP__i_clk = vlSelf->i_clk;\n\
             vlSelf->i_clk = VL_RAND_RESET_I(1);\n    os<<i_clk;\n    os>>i_clk;\n\
             #ifdef VL_DEBUG\n if ((vlSelf->i_clk & 0xfeU)) {}\n#endif  // VL_DEBUG\n",
            "__Vtrigrprev__TOP__i_clk",
        ),
        (
            "VL_IN8(i_clk,0,0);\nvlSelfRef.__VactTriggered[0U] = (QData)((IData)( \
             ((IData)(vlSelfRef.i_clk) & (~ \
             (IData)(vlSelfRef.__Vtrigprevexpr___TOP__i_clk__0)))));\n\
             vlSelfRef.__Vtrigprevexpr___TOP__i_clk__0 = vlSelfRef.i_clk;\n\
             vlSelf->i_clk = VL_SCOPED_RAND_RESET_I(1, __VscopeHash, 15ull);\n",
            "__Vtrigprevexpr___TOP__i_clk__0",
        ),
    ];

    #[test]
    fn a_rising_edge_alone_is_recognised() {
        for (text, name) in MODELS {
            assert_eq!(last_value("i_clk", &[text.to_owned()]).as_deref(), Some(name));
            assert!(is_only_edge(name, &[text.to_owned()]));
            let other = name.replace("i_clk", "i_ready");
            assert!(!is_only_edge(name, &[text.to_owned(), format!("vlSelf->{other} = 1U;")]));
        }
    }

    /// Falling edges, edges of either kind, latches and gates, a clock that is passed on, and
    /// a model without registers.
    #[test]
    fn any_other_use_of_the_clock_needs_both_evaluations() {
        let last = MODELS[0].1;
        for other in [
            format!("t.at(1U) = ((~ (IData)(vlSelf->i_clk)) & (IData)(vlSelf->{last}));"),
            format!("t.at(1U) = ((IData)(vlSelf->i_clk) != (IData)(vlSelf->{last}));"),
            "if ((1U & (~ (IData)(vlSelf->i_clk)))) { vlSelf->top__DOT__held = 1U; }".to_owned(),
            "vlSelf->top__DOT__gated = ((IData)(vlSelf->i_clk) & (IData)(vlSelf->on));".to_owned(),
            "vlSelf->o_clk = vlSelf->i_clk;".to_owned(),
            "vlSymsp->TOP__sub.i_clk = vlSelf->i_clk;".to_owned(),
            "vlSelf->__Vfunc(vlSelf->i_clk);".to_owned(),
        ] {
            for texts in [[MODELS[0].0, &other], [&other, MODELS[0].0]] {
                assert_eq!(last_value("i_clk", &texts.map(str::to_owned)), None, "{other}");
            }
        }
        assert_eq!(last_value("i_clk", &["vlSelf->a = vlSelf->i_clk;".to_owned()]), None);
        assert_eq!(last_value("i_clk", &[]), None);
    }

    /// Verilator 5.006's words for an output that follows an input, and for one that does not.
    #[test]
    fn an_output_that_follows_an_input_is_recognised() {
        let text = |line: &str| {
            format!(
                "VL_INLINE_OPT void Vt___024root___ico_sequent__TOP__0(Vt___024root* vlSelf) {{\n    \
                 // Body\n    {line};\n}}\n\
                 void Vt___024root___nba_sequent__TOP__0(Vt___024root* vlSelf) {{\n    \
                 Vt___024root___ico_sequent__TOP__0(vlSelf);\n    vlSelf->o_laser = 1U;\n}}\n"
            )
        };
        let ports = [(PortRole::Laser, 1), (PortRole::Epoch, 1), (PortRole::Data, 65)];
        let ports = ports.map(|(role, width)| role.port(width));
        let follows = |line: &str| follows(&ports.each_ref(), &[text(line)]);
        assert!(follows("vlSelf->o_laser = i") && follows("vlSymsp->TOP.o_epoch \n    = 1U"));
        assert!(follows("VL_ASSIGN_W(65,vlSelf->m_axis_tdata, i)"));
        assert!(!follows("vlSelf->t__DOT__o_laser = 1U") && !follows("vlSelf->o_laser_r = 1U"));
        assert!(!follows("vlSelf->a = (1U == (IData)(vlSelf->o_laser))"));
    }
}
