//! How a port differs: the same values at other clocks, the opposite ones, or others.

use serde::Serialize;

use crate::reference::blocks::Records;
use crate::sensor::layout::{Field, Layout};
use crate::sensor::port::PortRole;

/// Farthest that values are looked for, in clocks.
const FARTHEST: i64 = 1_000;

/// How a port differs round the first mismatch.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, schemars::JsonSchema)]
pub struct PortDifference {
    /// The port.
    pub port: String,
    /// Clocks by which its values come late (below 0: early), if they are otherwise as
    /// they should be.
    pub clocks_late: Option<i64>,
    /// The same in words.
    pub text: String,
}

/// Every port that differs in these records, in the order of the ports.
///
/// What `m_axis_tdata` and `m_axis_tlast` hold counts with `m_axis_tvalid`: they are held
/// against what it is when it comes.
pub fn differences(records: &Records, layout: &Layout, ignores_idle: bool) -> Vec<PortDifference> {
    let valid = Pair::of(records, layout, layout.outputs.field(PortRole::Valid));
    let fields = layout.outputs.fields.iter();
    let told = fields.filter_map(|field| {
        let pair = Pair::of(records, layout, field);
        let is_payload = field.port.role.is_payload();
        let counts: Option<&[Vec<u64>]> = (is_payload && ignores_idle).then_some(&valid.expected);
        if pair.agrees(0, counts) {
            return None;
        }
        // Payload goes with its valid, wherever that has gone.
        let shift = match counts {
            Some(_) => valid.shift(None).filter(|&shift| pair.agrees(shift, counts)),
            None => pair.shift(None),
        };
        Some(PortDifference {
            port: field.port.name.clone(),
            clocks_late: shift.filter(|&shift| shift != 0),
            text: match shift {
                Some(late) if late > 0 => format!("same values, {late} clock(s) late"),
                Some(early) if early < 0 => format!("same values, {} clock(s) early", -early),
                _ if pair.is_opposite(field.port.width) => "every bit is the opposite".to_owned(),
                _ => "other values".to_owned(),
            },
        })
    });
    told.collect()
}

/// A port's values on both sides, clock by clock.
struct Pair {
    expected: Vec<Vec<u64>>,
    got: Vec<Vec<u64>>,
}

impl Pair {
    fn of(records: &Records, layout: &Layout, field: &Field) -> Pair {
        let read = |side: &[u64]| -> Vec<Vec<u64>> {
            let records = side.chunks_exact(layout.outputs.words);
            records.map(|record| field.read(record)).collect()
        };
        Pair { expected: read(&records.expected), got: read(&records.got.values) }
    }

    /// The smallest shift at which the two sides agree, and do so at a change.
    fn shift(&self, counts: Option<&[Vec<u64>]>) -> Option<i64> {
        let farthest = FARTHEST.min(self.expected.len() as i64 / 2);
        (0..=farthest)
            .flat_map(|far| [far, -far])
            .find(|&late| self.agrees(late, counts) && self.changes(late))
    }

    /// Clocks of the reference whose counterpart so many clocks later is known.
    fn overlap(&self, late: i64) -> std::ops::Range<usize> {
        let length = self.expected.len() as i64;
        (-late).clamp(0, length) as usize..(length - late).clamp(0, length) as usize
    }

    fn agrees(&self, late: i64, counts: Option<&[Vec<u64>]>) -> bool {
        self.overlap(late).all(|clock| {
            let is_idle = counts.is_some_and(|valid| valid[clock] == [0]);
            is_idle || self.expected[clock] == self.got[(clock as i64 + late) as usize]
        })
    }

    fn changes(&self, late: i64) -> bool {
        let values = &self.expected[self.overlap(late)];
        values.windows(2).any(|pair| pair[0] != pair[1])
    }

    /// Whether every bit is the opposite wherever the port is not 0, as in reset.
    fn is_opposite(&self, width: u32) -> bool {
        width <= 64
            && self.expected.iter().zip(&self.got).all(|(expected, got)| {
                let both = (expected[0], got[0]);
                both == (0, 0) || both.0 ^ both.1 == crate::sensor::layout::mask(width)
            })
    }
}
