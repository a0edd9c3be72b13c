//! Where outputs stand among the planes, and the planes of those that follow a code.

use super::model::Table;
use super::slices::Slice;
use crate::code::Code;
use crate::reference::stimulus::RESET_CLOCKS;
use crate::sensor::interface::Interface;
use crate::sensor::layout::Layout;
use crate::sensor::port::Role;

/// Word and bit of each output's plane in a record, in the planes' order.
pub(super) fn output_places(layout: &Layout) -> Vec<(usize, u32)> {
    let fields = layout.outputs.fields.iter();
    fields
        .flat_map(|field| {
            (0..field.port.width).map(|bit| {
                let bit = field.shift + bit;
                (field.word + (bit / 64) as usize, bit % 64)
            })
        })
        .collect()
}

/// Lasers and epoch: their planes at every clock of a period.
pub(super) fn tables(interface: &Interface, layout: &Layout, slices: &[Slice]) -> Vec<Table> {
    let most = slices.iter().map(Slice::length).max().unwrap_or_default();
    let planes = |period: u64, value: &dyn Fn(u64) -> bool| {
        let starts: Vec<u64> = slices
            .iter()
            .map(|slice| (slice.clocks.start % period + period - RESET_CLOCKS % period) % period)
            .collect();
        let plane = |clock: u64| {
            let lanes = starts.iter().enumerate();
            lanes.fold(0, |plane, (lane, start)| {
                plane | u64::from(value((start + clock) % period)) << lane
            })
        };
        (0..period.min(most)).map(plane).collect::<Vec<u64>>()
    };
    let of_code = |code: &Code| planes(code.len(), &|chip| code.chips[chip as usize] == 1);
    let period = interface.reference_codes[0].len();
    let lasers = interface.source_codes.iter().enumerate();
    let mut tables: Vec<Table> = lasers
        .map(|(number, code)| Table {
            output: layout.outputs.bits_before(Role::Laser) + number,
            planes: of_code(code).into(),
        })
        .collect();
    tables.push(Table {
        output: layout.outputs.bits_before(Role::Epoch),
        planes: planes(period, &|chip| chip == 0).into(),
    });
    tables
}
