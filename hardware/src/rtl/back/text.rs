//! Verilog-2005 text of statements and expressions.

use std::fmt::Write;

use super::expr::{BinaryOp, Expr, UnaryOp};
use super::lower::Statement;
use super::module::{Memory, Module};
use super::signals::Reset;

/// Characters in a line of code, where the code allows.
pub const LINE_WIDTH: usize = 96;

/// Characters in a line with a comment beside its code.
const LINE_WIDTH_BESIDE: usize = 100;

/// Words in lines of at most `width` characters.
pub fn wrapped(text: &str, width: usize) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        let line = lines.last_mut().expect("there is always a line");
        if !line.is_empty() && line.len() + 1 + word.len() > width {
            lines.push(word.to_owned());
        } else {
            if !line.is_empty() {
                line.push(' ');
            }
            line.push_str(word);
        }
    }
    lines
}

/// Code, and what is said of it: beside it, or above it where the line is too short.
pub fn commented(indent: usize, code: &str, padding: usize, about: &str) -> String {
    if about.is_empty() {
        return format!("{:indent$}{code}\n", "");
    }
    let beside = format!("{:indent$}{code:padding$} // {about}\n", "");
    if beside.len() <= LINE_WIDTH_BESIDE + 1 {
        return beside;
    }
    let mut out = String::new();
    for line in wrapped(about, LINE_WIDTH - 3 - indent) {
        let _ = writeln!(out, "{:indent$}// {line}", "");
    }
    let _ = writeln!(out, "{:indent$}{code}", "");
    out
}

/// `head rest` on one line, or `rest` on lines below it: broken after commas and
/// before operators, in as few brackets as will do, and rather after commas.
pub fn push_broken(out: &mut String, indent: usize, head: &str, rest: &str) {
    let one_line = format!("{:indent$}{head} {rest}", "");
    if one_line.len() <= LINE_WIDTH {
        let _ = writeln!(out, "{one_line}");
        return;
    }
    let _ = writeln!(out, "{:indent$}{head}", "");
    let indent = indent + 4;
    let width = LINE_WIDTH - indent;
    let worst = gaps(rest).map(|(_, rank)| rank).max().unwrap_or(0);
    let lines = (0..worst)
        .map(|rank| filled(rest, rank, width))
        .find(|lines| lines.iter().all(|line| line.len() <= width))
        .unwrap_or_else(|| filled(rest, worst, width));
    for line in lines {
        let _ = writeln!(out, "{:indent$}{line}", "");
    }
}

/// `text` in lines of at most `width`, broken at gaps of at most `rank`.
fn filled(text: &str, rank: usize, width: usize) -> Vec<String> {
    let mut lines = vec![String::new()];
    let mut start = 0;
    let ends = gaps(text).filter(|gap| gap.1 <= rank).map(|gap| gap.0);
    for end in ends.chain([text.len()]) {
        let piece = text[start..end].trim();
        start = end;
        let line = lines.last_mut().expect("there is always a line");
        if line.is_empty() {
            line.push_str(piece);
        } else if line.len() + 1 + piece.len() <= width {
            line.push(' ');
            line.push_str(piece);
        } else {
            lines.push(piece.to_owned());
        }
    }
    lines
}

/// Spaces at which a line may break, and how bad that is: twice the brackets that are open
/// there, and one before an operator.
fn gaps(text: &str) -> impl Iterator<Item = (usize, usize)> {
    let mut depth = 0;
    text.char_indices().filter_map(move |(at, character)| {
        match character {
            '(' | '{' => depth += 1,
            ')' | '}' => depth -= 1,
            _ => {}
        }
        let next = text[at..].chars().nth(1);
        let is_operator = next.is_some_and(|c| "&|^+-=!<>?:".contains(c));
        let before_operator = is_operator && text[at + 2..].contains(' ');
        let after_comma = text[..at].ends_with(',');
        let breaks = character == ' ' && (after_comma || before_operator);
        breaks.then_some((at, 2 * depth + usize::from(!after_comma)))
    })
}

/// A memory: an instance of the module `kind`.
pub fn memory_block(memory: &Memory, module: &Module, kind: &str) -> String {
    let contents = &module.signals[memory.contents];
    let [write, place, word] = memory.write.each_ref().map(|pin| expression(pin, module));
    let [read, from] = memory.read.each_ref().map(|pin| expression(pin, module));
    let mut out = format!(
        "\n    // {}\n    {kind} #(\n        .WORDS({}), .ADDRESS_BITS({}), .BITS({})\n    ) {} (\n",
        contents.about,
        memory.words,
        memory.write[1].width(),
        contents.width,
        contents.name,
    );
    let pins = [
        (".i_clk          ", "(i_clk),".to_owned()),
        (".i_write        ", format!("({write}),")),
        (".i_write_address", format!("({place}),")),
        (".i_data         ", format!("({word}),")),
        (".i_read         ", format!("({read}),")),
        (".i_address      ", format!("({from}),")),
        (".o_word         ", format!("({})", module.signals[memory.q].name)),
    ];
    for (pin, value) in pins {
        push_broken(&mut out, 8, pin, &value);
    }
    out.push_str("    );\n");
    out
}

/// The `always` of all registers; empty if there are none.
pub fn clocked_block(module: &Module) -> String {
    if module.registers.is_empty() {
        return String::new();
    }
    let mut out = "\n    always @(posedge i_clk) begin\n        if (i_rst) begin\n".to_owned();
    for (id, reset) in &module.registers {
        let register = &module.signals[*id];
        let value = match reset {
            Reset::Literal(value) => literal(*value, register.width),
            Reset::Constant(id) => module.signals[*id].name.clone(),
        };
        let _ = writeln!(out, "            {} <= {value};", register.name);
    }
    if module.clocked.is_empty() {
        out.push_str("        end\n    end\n");
        return out;
    }
    match module.clocked.as_slice() {
        [Statement::If { test, yes, no }] => {
            push_if(&mut out, "end else if", (test, yes, no), 8, module);
        }
        block => {
            out.push_str("        end else begin\n");
            push_statements(&mut out, block, 12, module);
            out.push_str("        end\n");
        }
    }
    out.push_str("    end\n");
    out
}

fn push_statements(out: &mut String, block: &[Statement], indent: usize, module: &Module) {
    for statement in block {
        match statement {
            Statement::Assign { target, value } => {
                let head = format!("{} <=", module.register_of(*target).name);
                let value = format!("{};", expression(value, module));
                push_broken(out, indent, &head, &value);
            }
            Statement::If { test, yes, no } => push_if(out, "if", (test, yes, no), indent, module),
        }
    }
}

/// An `if` under `head`, which is `if` or `end else if`.
fn push_if(
    out: &mut String,
    head: &str,
    (test, yes, no): (&Expr, &[Statement], &[Statement]),
    indent: usize,
    module: &Module,
) {
    if yes.is_empty() {
        let inverted = Expr::Unary(UnaryOp::Not, Box::new(test.clone()));
        return push_if(out, head, (&inverted, no, &[]), indent, module);
    }
    let test = format!("({}) begin", expression(test, module));
    push_broken(out, indent, head, &test);
    push_statements(out, yes, indent + 4, module);
    match no {
        [] => {}
        [Statement::If { test, yes, no }] => {
            return push_if(out, "end else if", (test, yes, no), indent, module);
        }
        block => {
            let _ = writeln!(out, "{:indent$}end else begin", "");
            push_statements(out, block, indent + 4, module);
        }
    }
    let _ = writeln!(out, "{:indent$}end", "");
}

/// A sized literal.
pub fn literal(value: u128, width: u32) -> String {
    if width == 1 {
        format!("1'b{value}")
    } else if value < 10 {
        format!("{width}'d{value}")
    } else {
        format!("{width}'h{value:x}")
    }
}

fn symbol(op: BinaryOp) -> &'static str {
    match op {
        BinaryOp::Add => "+",
        BinaryOp::Sub => "-",
        BinaryOp::And => "&",
        BinaryOp::Or => "|",
        BinaryOp::Xor => "^",
        BinaryOp::Eq => "==",
        BinaryOp::Ne => "!=",
        BinaryOp::Lt => "<",
        BinaryOp::Le => "<=",
        BinaryOp::Gt => ">",
        BinaryOp::Ge => ">=",
    }
}

/// An expression as Verilog.
pub fn expression(expr: &Expr, module: &Module) -> String {
    let name = |id: &usize| &module.signals[*id].name;
    match expr {
        Expr::Signal { id, .. } => name(id).clone(),
        Expr::Slice { id, high, low: 0 } if high + 1 == module.signals[*id].width => {
            name(id).clone()
        }
        Expr::Slice { id, high, low } if high == low => format!("{}[{low}]", name(id)),
        Expr::Slice { id, high, low } => format!("{}[{high}:{low}]", name(id)),
        Expr::Literal { value, width } => literal(*value, *width),
        Expr::Concat(parts) => {
            let parts: Vec<_> = parts.iter().map(|p| expression(p, module)).collect();
            format!("{{{}}}", parts.join(", "))
        }
        Expr::Repeat { count, bit } => format!("{{{count}{{{}}}}}", expression(bit, module)),
        Expr::Lookup { table, index } => format!("{}[{}]", name(table), expression(index, module)),
        Expr::Unary(op, inner) => {
            let symbol = match op {
                UnaryOp::Not => "~",
                UnaryOp::All => "&",
                UnaryOp::Any => "|",
                UnaryOp::Parity => "^",
            };
            format!("{symbol}{}", operand(inner, None, module))
        }
        Expr::Binary(op, left, right) => format!(
            "{} {} {}",
            operand(left, Some(*op), module),
            symbol(*op),
            operand(right, Some(*op), module)
        ),
        Expr::Mux { test, yes, no } => format!(
            "{} ? {} : {}",
            operand(test, None, module),
            operand(yes, None, module),
            operand(no, None, module)
        ),
    }
}

/// An operand, in parentheses unless it binds tighter or continues a chain of
/// the same bitwise operator.
fn operand(expr: &Expr, under: Option<BinaryOp>, module: &Module) -> String {
    let plain = expression(expr, module);
    let needs_parentheses = match expr {
        Expr::Binary(op, ..) => !(op.is_bitwise() && under == Some(*op)),
        Expr::Unary(UnaryOp::Not, _) => false,
        Expr::Unary(..) | Expr::Mux { .. } => true,
        _ => false,
    };
    if needs_parentheses { format!("({plain})") } else { plain }
}
