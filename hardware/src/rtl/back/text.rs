//! Verilog-2005 text of statements and expressions.

use std::fmt::Write;

use super::expr::{BinaryOp, UnaryOp};
use super::lines::VerilogLine;
use super::number::Num;
use super::scope::RESET;
use super::sheet::Sheet;
use super::term::Term;

/// Characters in a line of code, where the code allows.
pub const LINE_WIDTH: usize = 96;

/// Characters in a line with a comment beside its code.
pub const LINE_WIDTH_BESIDE: usize = 100;

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

/// `head rest` on one line, or on several: broken after commas and before operators, in as few
/// brackets as will do, and rather after commas.
pub fn push_broken(out: &mut String, indent: usize, head: &str, rest: &str) {
    let width = LINE_WIDTH - indent;
    let worst = gaps(rest).map(|(_, rank)| rank).max().unwrap_or(0);
    let lines = (0..worst)
        .map(|rank| filled(head, rest, rank, width))
        .find(|lines| lines.iter().all(|line| line.len() <= width))
        .unwrap_or_else(|| filled(head, rest, worst, width));
    for line in lines {
        let _ = writeln!(out, "{:indent$}{line}", "");
    }
}

/// `text` in lines of at most `width`, broken at gaps of at most `rank`. Behind a head, which the first line
/// begins with, the others are indented.
pub fn filled(head: &str, text: &str, rank: usize, width: usize) -> Vec<String> {
    let mut lines = vec![head.to_owned()];
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
            let indent = if head.is_empty() { 0 } else { 4 };
            lines.push(format!("{:indent$}{piece}", ""));
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

/// The `always` of all registers; empty if there are none.
pub fn clocked_block(sheet: &Sheet) -> String {
    if sheet.resets.is_empty() {
        return String::new();
    }
    let mut out = "\n    always @(posedge i_clk)\n".to_owned();
    let reset = Term::Name(RESET.0.to_owned());
    let resets = reset_first(&sheet.resets);
    if let Some(lines) = short_if("if", (&reset, &resets, &sheet.clocked), 8) {
        lines.iter().for_each(|line| _ = writeln!(out, "{line}"));
        return out;
    }
    out.push_str("        if (i_rst) begin\n");
    push_lines(&mut out, &resets, 12);
    match sheet.clocked.as_slice() {
        [] => out.push_str("        end\n"),
        [VerilogLine::If { test, yes, no }] => push_if(&mut out, "end else if", (test, yes, no), 8),
        block => {
            out.push_str("        end else begin\n");
            push_lines(&mut out, block, 12);
            out.push_str("        end\n");
        }
    }
    out
}

/// Registers and their values after reset, those to 0 first.
fn reset_first(resets: &[VerilogLine]) -> Vec<VerilogLine> {
    let (zeros, others): (Vec<_>, Vec<_>) = resets
        .iter()
        .cloned()
        .partition(|line| matches!(line, VerilogLine::Store { value, .. } if is_zero(value)));
    [zeros, others].concat()
}

fn is_zero(value: &Term) -> bool {
    matches!(value, Term::Literal { value: 0, .. })
}

/// Neighbours that are cleared, or that take neighbouring parts of one signal, as one statement.
fn together(block: &[VerilogLine]) -> Vec<VerilogLine> {
    let mut out: Vec<VerilogLine> = Vec::new();
    for line in block {
        match out.last().and_then(|before| both(before, line)) {
            Some(one) => *out.last_mut().expect("there is one before") = one,
            None => out.push(line.clone()),
        }
    }
    out
}

/// One statement of two, if there is one.
fn both(first: &VerilogLine, second: &VerilogLine) -> Option<VerilogLine> {
    let (
        VerilogLine::Store { target: one, value },
        VerilogLine::Store { target: other, value: next },
    ) = (first, second)
    else {
        return None;
    };
    let stored = |high: &Term, low: &Term, value| {
        let parts = [high, low].map(|target| match target {
            Term::Concat(parts) => parts.clone(),
            other => vec![other.clone()],
        });
        VerilogLine::Store { target: Term::Concat(parts.concat()), value }
    };
    let (Term::Part { name, low, width }, Term::Part { name: same, low: from, width: bits }) =
        (value, next)
    else {
        return (is_zero(value) && is_zero(next)).then(|| stored(one, other, next.clone()));
    };
    if name != same || low.is_of_loop() || from.is_of_loop() {
        return None;
    }
    let all =
        |low: &Num| Term::Part { name: name.clone(), low: low.clone(), width: width.add(bits) };
    if low.add(width) == *from {
        Some(stored(other, one, all(low)))
    } else if from.add(bits) == *low {
        Some(stored(one, other, all(from)))
    } else {
        None
    }
}

/// How a loop begins.
pub fn loop_head(trips: &Num, index: &str) -> String {
    format!("for ({index} = 0; {index} < {}; {index} = {index} + 1)", trips.text())
}

/// A statement on one line. What is cleared together has no width of its own.
fn store(target: &Term, value: &Term) -> String {
    let value = match target {
        Term::Concat(_) if is_zero(value) => "0".to_owned(),
        _ => expression(value),
    };
    format!("{} <= {value};", expression(target))
}

fn push_lines(out: &mut String, block: &[VerilogLine], indent: usize) {
    for line in &together(block) {
        match line {
            VerilogLine::Store { target: target @ Term::Concat(_), value } => {
                for line in filled("", &store(target, value), 2, LINE_WIDTH - indent) {
                    let _ = writeln!(out, "{:indent$}{line}", "");
                }
            }
            VerilogLine::Store { target, value } => {
                let head = format!("{} <=", expression(target));
                push_broken(out, indent, &head, &format!("{};", expression(value)));
            }
            VerilogLine::If { test, yes, no } => push_if(out, "if", (test, yes, no), indent),
            VerilogLine::Fold { .. } => {}
            VerilogLine::Loop { index, trips, body } => {
                let _ = writeln!(out, "{:indent$}{} begin", "", loop_head(trips, index));
                push_lines(out, body, indent + 4);
                let _ = writeln!(out, "{:indent$}end", "");
            }
        }
    }
}

/// An `if` under `head`, which is `if` or `end else if`.
fn push_if(
    out: &mut String,
    head: &str,
    (test, yes, no): (&Term, &[VerilogLine], &[VerilogLine]),
    indent: usize,
) {
    if yes.is_empty() {
        let inverted = Term::Unary(UnaryOp::Not, Box::new(test.clone()));
        return push_if(out, head, (&inverted, no, &[]), indent);
    }
    if head == "if"
        && let Some(lines) = short_if("if", (test, yes, no), indent)
    {
        lines.iter().for_each(|line| _ = writeln!(out, "{line}"));
        return;
    }
    let test = format!("({}) begin", expression(test));
    push_broken(out, indent, head, &test);
    push_lines(out, yes, indent + 4);
    match no {
        [] => {}
        [VerilogLine::If { test, yes, no }] => {
            return push_if(out, "end else if", (test, yes, no), indent);
        }
        block => {
            let _ = writeln!(out, "{:indent$}end else begin", "");
            push_lines(out, block, indent + 4);
        }
    }
    let _ = writeln!(out, "{:indent$}end", "");
}

/// An `if` of single statements, a line for each; none where one is longer than a line.
fn short_if(
    head: &str,
    (test, yes, no): (&Term, &[VerilogLine], &[VerilogLine]),
    indent: usize,
) -> Option<Vec<String>> {
    let line = |head: &str, block: &[VerilogLine]| {
        let [VerilogLine::Store { target, value }] = &together(block)[..] else {
            return None;
        };
        let line = format!("{:indent$}{head} {}", "", store(target, value));
        (line.len() <= LINE_WIDTH).then_some(line)
    };
    let mut lines = vec![line(&format!("{head} ({})", expression(test)), yes)?];
    match no {
        [] => {}
        [VerilogLine::If { test, yes, no }] if !yes.is_empty() => {
            lines.extend(short_if("else if", (test, yes, no), indent)?);
        }
        block => lines.push(line("else", block)?),
    }
    Some(lines)
}

/// A sized literal.
fn literal(value: u128, width: u32) -> String {
    if width == 1 {
        format!("1'b{value}")
    } else if value < 10 {
        format!("{width}'d{value}")
    } else if value == u128::MAX >> (128 - width) {
        format!("{{{width}{{1'b1}}}}")
    } else {
        format!("{width}'h{value:x}")
    }
}

/// An operator as Verilog.
pub fn symbol(op: BinaryOp) -> &'static str {
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

/// A sized literal whose width may depend on parameters.
fn sized(value: u128, width: &Num) -> String {
    match width.constant() {
        Some(width) => literal(value, width as u32),
        None if value == 0 => format!("{{{}{{1'b0}}}}", counted(width)),
        None => {
            let bits = u128::BITS - value.leading_zeros();
            let zeros = width.sub(&bits.into());
            format!("{{{{{}{{1'b0}}}}, {}}}", counted(&zeros), literal(value, bits))
        }
    }
}

/// A number of copies.
fn counted(count: &Num) -> String {
    if count.is_sum() { format!("({})", count.text()) } else { count.text() }
}

/// An expression as Verilog.
pub fn expression(expr: &Term) -> String {
    match expr {
        Term::Name(name) => name.clone(),
        Term::Part { name, low, width } if width.constant() == Some(1) => {
            format!("{name}[{}]", low.text())
        }
        Term::Part { name, low, width } if low.is_of_loop() => {
            format!("{name}[{} +: {}]", low.text(), width.text())
        }
        Term::Part { name, low, width } => {
            let high = low.add(width).sub(&1u32.into());
            format!("{name}[{}:{}]", high.text(), low.text())
        }
        Term::Literal { value, width } => sized(*value, width),
        Term::Concat(parts) => {
            let parts: Vec<_> = parts.iter().map(expression).collect();
            format!("{{{}}}", parts.join(", "))
        }
        Term::Repeat { count, bit } => {
            format!("{{{}{{{}}}}}", counted(count), expression(bit))
        }
        Term::Lookup { table, index } => format!("{table}[{}]", expression(index)),
        Term::Unary(op, inner) => {
            let symbol = match op {
                UnaryOp::Not => "~",
                UnaryOp::All => "&",
                UnaryOp::Any => "|",
                UnaryOp::Parity => "^",
            };
            format!("{symbol}{}", operand(inner, None))
        }
        Term::Binary(op, left, right) => {
            format!("{} {} {}", operand(left, Some(*op)), symbol(*op), operand(right, Some(*op)))
        }
        Term::Mux(parts) => {
            let [test, yes, no] = parts.each_ref().map(|part| operand(part, None));
            format!("{test} ? {yes} : {no}")
        }
    }
}

/// An operand of `op`.
pub fn operand_of(expr: &Term, op: BinaryOp) -> String {
    operand(expr, Some(op))
}

/// An operand, in parentheses unless it binds tighter or continues a chain of
/// the same bitwise operator.
fn operand(expr: &Term, under: Option<BinaryOp>) -> String {
    let plain = expression(expr);
    let needs_parentheses = match expr {
        Term::Binary(op, ..) => !(op.is_bitwise() && under == Some(*op)),
        Term::Unary(UnaryOp::Not, _) => false,
        Term::Unary(..) | Term::Mux(_) => true,
        _ => false,
    };
    if needs_parentheses { format!("({plain})") } else { plain }
}
