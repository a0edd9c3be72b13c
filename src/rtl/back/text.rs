//! Verilog-2005 text of statements and expressions.

use std::fmt::Write;

use super::expr::{BinaryOp, Expr, UnaryOp};
use super::lower::Statement;
use super::module::Module;
use super::signals::Reset;

/// Characters in a line, where the code allows.
pub const LINE_WIDTH: usize = 96;

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

/// Comments on lines of their own.
pub fn push_comments(out: &mut String, comments: &[String], indent: usize) {
    for comment in comments {
        for line in wrapped(comment, LINE_WIDTH - 3 - indent) {
            let _ = writeln!(out, "{:indent$}// {line}", "");
        }
    }
}

/// An assignment, its operands on lines of their own where one line is too
/// short.
pub fn push_assignment(out: &mut String, indent: usize, head: &str, value: &Expr, module: &Module) {
    let one_line = format!("{:indent$}{head} {};", "", expression(value, module));
    if one_line.len() <= LINE_WIDTH {
        let _ = writeln!(out, "{one_line}");
        return;
    }
    let more = indent + 4;
    let _ = match value {
        Expr::Binary(op, left, right) => writeln!(
            out,
            "{:indent$}{head}\n{:more$}{}\n{:more$}{} {};",
            "",
            "",
            operand(left, Some(*op), module),
            "",
            symbol(*op),
            operand(right, Some(*op), module)
        ),
        Expr::Mux { test, yes, no } => writeln!(
            out,
            "{:indent$}{head}\n{:more$}{} ? {}\n{:more$}: {};",
            "",
            "",
            operand(test, None, module),
            operand(yes, None, module),
            "",
            operand(no, None, module)
        ),
        _ => writeln!(out, "{one_line}"),
    };
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
    out.push_str("        end else begin\n");
    push_statements(&mut out, &module.clocked, 12, module);
    out.push_str("        end\n    end\n");
    out
}

fn push_statements(out: &mut String, block: &[Statement], indent: usize, module: &Module) {
    for statement in block {
        match statement {
            Statement::Assign {
                target,
                value,
                comments,
            } => {
                push_comments(out, comments, indent);
                let head = format!("{} <=", module.register_of(*target).name);
                push_assignment(out, indent, &head, value, module);
            }
            Statement::If { comments, .. } => {
                push_comments(out, comments, indent);
                let _ = write!(out, "{:indent$}", "");
                push_if(out, statement, indent, module);
            }
        }
    }
}

fn push_if(out: &mut String, statement: &Statement, indent: usize, module: &Module) {
    let Statement::If { test, yes, no, .. } = statement else {
        return;
    };
    if yes.is_empty() {
        let inverted = Expr::Unary(UnaryOp::Not, Box::new(test.clone()));
        let _ = writeln!(out, "if ({}) begin", expression(&inverted, module));
        push_statements(out, no, indent + 4, module);
        let _ = writeln!(out, "{:indent$}end", "");
        return;
    }
    let _ = writeln!(out, "if ({}) begin", expression(test, module));
    push_statements(out, yes, indent + 4, module);
    match no.as_slice() {
        [] => {
            let _ = writeln!(out, "{:indent$}end", "");
        }
        [nested @ Statement::If { comments, .. }] if comments.is_empty() => {
            let _ = write!(out, "{:indent$}end else ", "");
            push_if(out, nested, indent, module);
        }
        block => {
            let _ = writeln!(out, "{:indent$}end else begin", "");
            push_statements(out, block, indent + 4, module);
            let _ = writeln!(out, "{:indent$}end", "");
        }
    }
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
    if needs_parentheses {
        format!("({plain})")
    } else {
        plain
    }
}
