//! Where outputs stand among the planes, and the planes of those that follow a code.

use super::model::PeriodicOutput;
use super::planes::Planes;
use super::slices::Slice;
use crate::reference::stimulus::RESET_CLOCKS;
use crate::sensor::interface::Interface;
use crate::sensor::layout::Layout;
use crate::sensor::port::PortRole;

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

/// Lasers and epoch: their planes at every clock of a period, for a model of so many lanes.
pub(super) fn tables(
    interface: &Interface,
    layout: &Layout,
    slices: &[Slice],
    lanes: usize,
) -> Vec<PeriodicOutput> {
    let most = slices.iter().map(Slice::length).max().unwrap_or_default();
    let table = |output: usize, period: u64, value: &dyn Fn(u64) -> bool| {
        let length = period.min(most);
        let mut planes = Planes::new(lanes, length as usize);
        for (lane, slice) in slices.iter().enumerate() {
            let mut chip = (slice.clocks.start % period + period - RESET_CLOCKS % period) % period;
            for clock in 0..length as usize {
                planes.set(clock, lane, value(chip));
                chip = if chip + 1 == period { 0 } else { chip + 1 };
            }
        }
        PeriodicOutput { output, planes: planes.into(), length }
    };
    let period = interface.reference_codes[0].len();
    let lasers = interface.source_codes.iter().enumerate();
    let mut tables: Vec<PeriodicOutput> = lasers
        .map(|(number, code)| {
            let is_on = |chip: u64| code.chips[chip as usize] == 1;
            table(layout.outputs.bits_before(PortRole::Laser) + number, code.len(), &is_on)
        })
        .collect();
    tables.push(table(layout.outputs.bits_before(PortRole::Epoch), period, &|chip| chip == 0));
    tables
}
