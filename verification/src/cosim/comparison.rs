//! Which outputs of the two sides have to be equal at a clock.

use super::mismatch::{Mismatch, MismatchKind};
use crate::sensor::layout::{Field, Layout};
use crate::sensor::port::PortRole;

/// How outputs are compared.
#[derive(Debug, Clone, Copy)]
pub(crate) struct OutputComparison<'a> {
    pub(crate) layout: &'a Layout,
    /// What `m_axis_tdata` and `m_axis_tlast` hold counts only with `m_axis_tvalid`: no
    /// more is promised. What is emitted keeps its last result, and is held to it.
    pub(crate) ignores_idle_payload: bool,
}

impl OutputComparison<'_> {
    /// The ports that differ and are not free to, by their numbers in
    /// [`Layout::outputs`]. An undefined bit is never what it should be; `undefined` may be
    /// empty.
    pub(crate) fn differing<'s>(
        &self,
        expected: &'s [u64],
        (got, undefined): (&'s [u64], &'s [u64]),
    ) -> impl Iterator<Item = usize> + use<'_, 's> {
        let outputs = &self.layout.outputs;
        let is_idle =
            self.ignores_idle_payload && outputs.field(PortRole::Valid).low_word(expected) == 0;
        let fields = outputs.fields.iter().enumerate();
        fields.filter_map(move |(number, field)| {
            let is_payload = field.port.role.is_payload();
            let differs =
                field.read(expected) != field.read(got) || is_any_undefined(field, undefined);
            (differs && !(is_idle && is_payload)).then_some(number)
        })
    }
}

impl OutputComparison<'_> {
    /// The first port that differs at a clock and is not free to, with what it shows.
    pub(crate) fn mismatch(
        &self,
        clock: u64,
        kind: MismatchKind,
        expected: &[u64],
        got: (&[u64], &[u64]),
    ) -> Option<Mismatch> {
        let number = self.differing(expected, got).next()?;
        let field = &self.layout.outputs.fields[number];
        let undefined = if got.1.is_empty() { Vec::new() } else { field.read(got.1) };
        let is_undefined = undefined.iter().any(|&bits| bits != 0);
        Some(Mismatch {
            clock,
            kind: if is_undefined { MismatchKind::Undefined } else { kind },
            field: number,
            expected: field.read(expected),
            got: field.read(got.0),
            undefined: if is_undefined { undefined } else { Vec::new() },
        })
    }
}

/// Whether a bit of a port is undefined, as `undefined` says of all ports.
fn is_any_undefined(field: &Field, undefined: &[u64]) -> bool {
    !undefined.is_empty() && field.read(undefined).iter().any(|&bits| bits != 0)
}
