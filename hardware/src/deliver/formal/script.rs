//! The files: properties, the start of registers, and sby's tasks.

use std::fmt::Write as _;

use super::harness::Harness;
use crate::deliver::design::{Design, EmittedFile};

/// Name of the folder of these files.
pub(super) const FOLDER: &str = "formal";
const REGISTERS: &str = "registers.v";
const EMPTIED: &str = "emptied.v";
const ABC: &str = "abc.sh";
/// After which a proof is given up; each takes seconds.
const TIMEOUT_S: u32 = 600;

/// Name of the file with the properties.
fn properties_name(design: &Design) -> String {
    design.file_name("_formal.sv")
}

/// Name of sby's file.
fn script_name(design: &Design) -> String {
    design.file_name(".sby")
}

/// The properties of all proofs.
pub(super) fn properties(design: &Design, harnesses: &[Harness], modules: &str) -> EmittedFile {
    let mut text = format!(
        "// What {top} has to do: a module for each proof of {script}\n\
         //\n\
         // Each has the design, a specification of its own, and assertions. Registers start as one clock\n\
         // of reset leaves them, which the proof `reset` shows to be one state; i_rst may come again at any\n\
         // time. Outputs of modules inside are seen, or cut and driven by the proof, by {script}.\n\
         //\n\
         // Made by  {made_by}\n\n`default_nettype none\n\n",
        top = design.top(),
        script = script_name(design),
        made_by = design.made_by,
    );
    text += &modules.replace("endmodule\n", "endmodule\n\n");
    for harness in harnesses {
        text += &harness.text(design);
        text.push('\n');
    }
    text += "`default_nettype wire\n";
    EmittedFile { name: properties_name(design), text }
}

/// Maps for Yosys' techmap.
pub(super) fn registers(made_by: &str) -> EmittedFile {
    EmittedFile {
        name: REGISTERS.to_owned(),
        text: format!("// Registers, for Yosys' techmap\n// Made by  {made_by}\n\n{REGISTER_MAPS}"),
    }
}

/// For an ABC that is not sby's own.
pub(super) fn abc(made_by: &str) -> EmittedFile {
    let text = format!("#!/bin/sh\n# Made by  {made_by}\n#\n{ABC_WRAPPER}");
    EmittedFile { name: ABC.to_owned(), text }
}

/// What Debian's berkeley-abc lacks of sby's.
const ABC_WRAPPER: &str = r#"# ABC as sby calls it, with -c and its commands, for whoever has Debian's berkeley-abc, or the
# yosys-abc of an older Yosys, and not sby's own. In the folder of the design:
#   sby --abc "sh '$PWD/formal/abc.sh'" -f formal/NAME.sby
abc=$(command -v berkeley-abc || command -v yosys-abc) || {
    echo "neither berkeley-abc nor yosys-abc is installed" >&2
    exit 127
}
# pdr of these has no option -l, which only prints more.
commands=$(printf '%s' "$2" | sed 's/pdr -v -l/pdr -v/')
status=0
"$abc" "$1" "$commands" || status=$?
# They leave out the line break before the end of a counterexample.
sed -i 's/\([01]\)# DONE$/\1\n# DONE/' engine_*/trace*.aiw 2>/dev/null || true
exit "$status"
"#;

/// Registers that start at their reset value; with `IN_RESET` those that start at
/// any, and the claim that reset takes them to it. One whose reset Yosys does not
/// recognise, because the register is but the reset's inverse, starts at 0.
const REGISTER_MAPS: &str = "\
`ifdef IN_RESET

// The proof `reset`: i_rst is high, and registers have any value.
(* techmap_celltype = \"$sdff\" *)
module resettable (CLK, SRST, D, Q);
    parameter WIDTH = 1;
    parameter CLK_POLARITY = 1;
    parameter SRST_POLARITY = 1;
    parameter [WIDTH-1:0] SRST_VALUE = 0;
    input CLK;
    input SRST;
    input [WIDTH-1:0] D;
    output [WIDTH-1:0] Q;

    wire [WIDTH-1:0] next = SRST == SRST_POLARITY ? SRST_VALUE : D;
    \\$anyseq #(.WIDTH(WIDTH)) any (.Y(Q));
    \\$assert is_reset (.A(next == SRST_VALUE), .EN(1'b1));
endmodule

(* techmap_celltype = \"$dff\" *)
module other (CLK, D, Q);
    parameter WIDTH = 1;
    parameter CLK_POLARITY = 1;
    input CLK;
    input [WIDTH-1:0] D;
    output [WIDTH-1:0] Q;

    \\$anyseq #(.WIDTH(WIDTH)) any (.Y(Q));
    \\$assert is_reset (.A(D == 0), .EN(1'b1));
endmodule

`else

// All other proofs: a register starts as reset leaves it.
(* techmap_celltype = \"$sdff\" *)
module resettable (CLK, SRST, D, Q);
    parameter WIDTH = 1;
    parameter CLK_POLARITY = 1;
    parameter SRST_POLARITY = 1;
    parameter [WIDTH-1:0] SRST_VALUE = 0;
    input CLK;
    input SRST;
    input [WIDTH-1:0] D;
    (* init = SRST_VALUE *) output [WIDTH-1:0] Q;

    wire [WIDTH-1:0] next = SRST == SRST_POLARITY ? SRST_VALUE : D;
    \\$dffe #(.WIDTH(WIDTH), .CLK_POLARITY(CLK_POLARITY), .EN_POLARITY(1)) register
        (.CLK(CLK), .EN(1'b1), .D(next), .Q(Q));
endmodule

(* techmap_celltype = \"$dff\" *)
module other (CLK, D, Q);
    parameter WIDTH = 1;
    parameter CLK_POLARITY = 1;
    input CLK;
    input [WIDTH-1:0] D;
    (* init = {WIDTH{1'b0}} *) output [WIDTH-1:0] Q;

    \\$dffe #(.WIDTH(WIDTH), .CLK_POLARITY(CLK_POLARITY), .EN_POLARITY(1)) register
        (.CLK(CLK), .EN(1'b1), .D(D), .Q(Q));
endmodule

`endif
";

/// Modules that a proof empties: ports without anything behind them, or behind outputs
/// whatever the proof's engine likes.
pub(super) fn emptied(design: &Design, harnesses: &[Harness]) -> EmittedFile {
    let mut text = format!(
        "// Modules of {} of which a proof drives the outputs, or leaves them free: their ports and no more\n\
         // Made by  {}\n\n`default_nettype none\n",
        design.top(),
        design.made_by,
    );
    for harness in harnesses.iter().filter(|harness| harness.is_cut()) {
        let _ = writeln!(text, "\n`ifdef PROVE_{}", harness.name.to_uppercase());
        let files = design.files.iter();
        for file in files.filter(|file| harness.empties(module(design, file))) {
            text += &ports_only(&file.text, harness.frees(module(design, file)));
        }
        text += "`endif\n";
    }
    text += "\n`default_nettype wire\n";
    EmittedFile { name: EMPTIED.to_owned(), text }
}

/// The head of a module, with its end; if `free`, its outputs are anything.
fn ports_only(text: &str, free: bool) -> String {
    let head = text.lines().skip_while(|line| !line.starts_with("module "));
    let (mut ports, mut anything) = (String::new(), String::new());
    for line in head {
        let line = line.replace("output reg ", "output wire");
        let _ = writeln!(ports, "{line}");
        if line == ");" {
            break;
        }
        if let Some((range, name)) = output(&line).filter(|_| free) {
            let _ = writeln!(anything, "    (* anyseq *) wire {range}any_{name};");
            let _ = writeln!(anything, "    assign {name} = any_{name};");
        }
    }
    if anything.is_empty() {
        // Without a line of its own Yosys would take it for a black box.
        anything += "    wire nothing = 1'b0;\n";
    }
    ports + &anything + "endmodule\n"
}

/// The range, with a space behind it if there is one, and the name of an output that a
/// line declares.
fn output(line: &str) -> Option<(String, &str)> {
    let declared = line.trim_start().strip_prefix("output wire")?;
    let (declared, _comment) = declared.split_once("//").unwrap_or((declared, ""));
    let declared = declared.trim().trim_end_matches(',');
    Some(match declared.rsplit_once(']') {
        Some((range, name)) => (format!("{range}] "), name.trim_start()),
        None => (String::new(), declared),
    })
}

/// The module of a file, without the prefix.
fn module<'f>(design: &Design, file: &'f EmittedFile) -> &'f str {
    let name = file.name.trim_end_matches(".v");
    design.prefix.strip(name).unwrap_or(name)
}

/// The files of the design that a proof reads.
fn names(design: &Design, harness: &Harness) -> String {
    let files = design.files.iter();
    let read = files.filter(|file| !harness.empties(module(design, file)));
    let names: Vec<&str> = read.map(|file| file.name.as_str()).collect();
    names.join(" ")
}

/// sby's tasks.
pub(super) fn script(design: &Design, harnesses: &[Harness]) -> EmittedFile {
    let properties = properties_name(design);
    let mut text = format!(
        "# Proofs of {top}, for sby (SymbiYosys). In the folder of {top}.v:\n\
         #   sby -f {folder}/{script}         all of them\n\
         #   sby -f {folder}/{script} counts  one; {properties} says what each of them proves\n\
         # A task ..._cover passes if what its proof is about can be.\n\
         # {folder}/{ABC} says what to add where ABC is Debian's.\n\
         # Made by  {made_by}\n\n[tasks]\n",
        top = design.top(),
        script = script_name(design),
        made_by = design.made_by,
        folder = FOLDER
    );
    let covers = || harnesses.iter().filter_map(|harness| Some((harness, harness.cover_task()?)));
    for harness in harnesses {
        let _ = writeln!(text, "{0} on_{0}", harness.name);
    }
    for (harness, task) in covers() {
        let _ = writeln!(text, "{task} on_{} cover", harness.name);
    }
    let _ = write!(text, "\n[options]\naigsmt none\ntimeout {TIMEOUT_S}\n");
    for harness in harnesses {
        for option in harness.options() {
            let _ = writeln!(text, "{}: {option}", harness.name);
        }
    }
    text += "cover: mode bmc\ncover: expect fail\n";
    for (harness, task) in covers() {
        let _ = writeln!(text, "{task}: depth {}", harness.cover_depth());
    }
    text += "\n[engines]\ncover: abc bmc3\n";
    for harness in harnesses {
        let _ = writeln!(text, "{}: {}", harness.name, harness.engine_line());
    }
    text += "\n[script]\n";
    write_yosys(design, harnesses, &properties, &mut text);
    text += "\n[files]\n";
    for name in design.files.iter().map(|file| &file.name) {
        let _ = writeln!(text, "{name}");
    }
    for name in [properties.as_str(), EMPTIED, REGISTERS] {
        let _ = writeln!(text, "{}/{name}", FOLDER);
    }
    EmittedFile { name: script_name(design), text }
}

/// What Yosys does before the proofs, line by line; one that begins with a name is for
/// that task alone.
fn write_yosys(design: &Design, harnesses: &[Harness], properties: &str, text: &mut String) {
    for harness in harnesses {
        let _ = writeln!(text, "on_{}: read_verilog {}", harness.name, names(design, harness));
        if harness.is_cut() {
            let macros = format!("-D PROVE_{}", harness.name.to_uppercase());
            let _ = writeln!(text, "on_{}: read_verilog -formal {macros} {EMPTIED}", harness.name);
        }
    }
    let _ = writeln!(text, "~cover: read_verilog -formal -sv {properties}");
    let _ = writeln!(text, "cover: read_verilog -formal -sv -D COVER {properties}");
    for harness in harnesses {
        let _ =
            writeln!(text, "on_{}: hierarchy -check -top {}", harness.name, harness.top(design));
    }
    *text +=
        "proc -noopt\nflatten\ncover: chformal -assert -remove\ncover: chformal -assume2assert\n";
    for harness in harnesses {
        for line in harness.script(design) {
            let _ = writeln!(text, "on_{}: {line}", harness.name);
        }
    }
    *text += "opt_dff -nodffe\n";
    for harness in harnesses {
        if let Some(mode) = harness.register_map() {
            let _ = writeln!(text, "{}: techmap -autoproc {mode}-map {REGISTERS}", harness.name);
        }
    }
    *text += "opt_expr\nopt_clean\n";
}
