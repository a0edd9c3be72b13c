//! Tests: what only a hand-written syntax tree can say.

use super::{fault_of, named};
use crate::rtl::back::Fault;
use crate::rtl::front::prelude::*;

/// Kernels that only a hand-written `hdl` can say.
struct ByHand(Vec<ast::VerilogStatement>, Output<Word>, About);

impl Logic for ByHand {
    fn update(&mut self) {}
    fn hdl(&self) -> ast::Verilog {
        ast::Verilog::Combinatorial(self.0.clone())
    }
}

impl Block for ByHand {
    fn connect_all(&mut self) {}
    fn update_all(&mut self) {}
    fn has_changed(&self) -> bool {
        false
    }
    fn accept(&self, name: &str, probe: &mut dyn probe::Probe) {
        probe.visit_start_scope(name, self);
        self.1.accept("o_y", probe);
        self.2.accept("about", probe);
        probe.visit_end_scope(name, self);
    }
}

fn by_hand(statement: ast::VerilogStatement) -> ByHand {
    ByHand(vec![statement], Output::word(4, ""), About::new("unsound", "a block of a test"))
}

#[test]
fn a_partial_drive_is_refused() {
    let statement = ast::VerilogStatement::SliceAssignment {
        base: ast::VerilogExpression::Signal(named("o_y")),
        width: 1,
        offset: ast::VerilogExpression::Literal(0.into()),
        replacement: ast::VerilogExpression::Literal(true.into()),
    };
    assert_eq!(fault_of(&by_hand(statement)), Fault::PartialDrive { signal: named("o_y") });
}

#[test]
fn an_unknown_name_is_refused() {
    let statement = ast::VerilogStatement::Assignment(
        ast::VerilogExpression::Signal(named("o_y")),
        ast::VerilogExpression::Signal(named("nowhere")),
    );
    assert_eq!(fault_of(&by_hand(statement)), Fault::UnknownName { name: named("nowhere") });
}

#[test]
fn a_literal_without_a_width_is_refused() {
    let one = || Box::new(ast::VerilogExpression::Literal(1.into()));
    let statement = ast::VerilogStatement::Assignment(
        ast::VerilogExpression::Signal(named("o_y")),
        ast::VerilogExpression::Cast(
            Box::new(ast::VerilogExpression::Binary(one(), ast::VerilogOp::Eq, one())),
            4,
        ),
    );
    assert!(matches!(fault_of(&by_hand(statement)), Fault::NoWidth { .. }));
}

#[test]
fn a_match_is_refused() {
    let statement = ast::VerilogStatement::Match(ast::VerilogMatch {
        test: ast::VerilogExpression::Signal(named("o_y")),
        cases: Vec::new(),
    });
    assert_eq!(fault_of(&by_hand(statement)), Fault::Unsupported { construct: named("`match`") });
}

#[test]
fn a_keyword_as_a_name_is_refused() {
    struct Table(Output<bool>, About);
    impl Logic for Table {
        fn update(&mut self) {}
    }
    impl Block for Table {
        fn connect_all(&mut self) {}
        fn update_all(&mut self) {}
        fn has_changed(&self) -> bool {
            false
        }
        fn accept(&self, name: &str, probe: &mut dyn probe::Probe) {
            probe.visit_start_scope(name, self);
            self.0.accept("table", probe);
            self.1.accept("about", probe);
            probe.visit_end_scope(name, self);
        }
    }
    let block = Table(Output::bit(""), About::new("unsound", "a block of a test"));
    assert!(matches!(fault_of(&block), Fault::BadName { .. }));
}
