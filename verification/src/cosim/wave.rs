//! Waveforms of both sides as a VCD file.

use std::io;

use vcd::{IdCode, ReferenceIndex, SimulationCommand, TimescaleUnit, Value, VarType, Writer};

use super::comparison::OutputComparison;
use crate::reference::blocks::Records;
use crate::scan::Timescale;
use crate::sensor::layout::{Field, Layout};

/// Name of the outermost scope.
pub(super) const ROOT: &str = "cosim";
/// The Verilog.
pub(super) const DUT: &str = "dut";
/// The reference model.
pub(super) const MODEL: &str = "model";
/// For each output whether it differs.
pub(super) const DIFFERS: &str = "differs";
/// High while any output differs.
pub(super) const ANY: &str = "any";

/// Writes the clock, both sides with all their ports (they share the inputs), and for
/// each output whether it differs and may not.
///
/// Time is real time since the start of the run: clock t starts at t chip periods with
/// its inputs, and with what outputs do in the clock's low half; the clock rises, and the
/// outputs change, half a chip period later.
///
/// # Errors
/// When `out` takes no more.
pub(super) fn write(
    out: &mut dyn io::Write,
    records: &Records,
    comparison: OutputComparison,
    time: Timescale,
) -> io::Result<()> {
    let layout = comparison.layout;
    let mut writer = Writer::new(out);
    writer.timescale(time.multiple, unit(time))?;
    if !time.is_exact() {
        writer.comment(&format!(
            "half a chip period is not a whole number of any unit of time: edges are rounded to {time}"
        ))?;
    }
    writer.add_module(ROOT)?;
    let clock = writer.add_wire(1, Layout::CLOCK)?;
    writer.add_module(DUT)?;
    let mut inputs = Side::declare(&mut writer, &layout.inputs.fields)?;
    let mut got = Side::declare(&mut writer, &layout.outputs.fields)?;
    writer.upscope()?;
    writer.add_module(MODEL)?;
    inputs.declare_again(&mut writer)?;
    let mut expected = Side::declare(&mut writer, &layout.outputs.fields)?;
    writer.upscope()?;
    let mut differences = Differences::declare(&mut writer, &layout.outputs.fields)?;
    writer.upscope()?;
    writer.enddefinitions()?;

    let rows = records
        .inputs
        .chunks_exact(layout.inputs.words)
        .zip(records.expected.chunks_exact(layout.outputs.words))
        .zip(records.got.records(layout.outputs.words));
    let mut low = records.low.records(layout.outputs.words);
    let mut last_wanted = None;
    for (i, ((input, wanted), seen)) in rows.enumerate() {
        let t = records.first_clock + i as u64;
        writer.timestamp(time.after_halves(2 * t))?;
        if i == 0 {
            writer.begin(SimulationCommand::Dumpvars)?;
        }
        writer.change_scalar(clock, false)?;
        inputs.change(&mut writer, (input, &[]))?;
        if i == 0 {
            writer.end()?;
        }
        if let (Some(low), Some(wanted)) = (low.next(), last_wanted.replace(wanted)) {
            got.change(&mut writer, low)?;
            differences.change(&mut writer, comparison.differing(wanted, low))?;
        }
        writer.timestamp(time.after_halves(2 * t + 1))?;
        writer.change_scalar(clock, true)?;
        got.change(&mut writer, seen)?;
        expected.change(&mut writer, (wanted, &[]))?;
        differences.change(&mut writer, comparison.differing(wanted, seen))?;
    }
    // So that the last outputs can be seen.
    writer.timestamp(time.after_halves(2 * records.clocks(layout).end))
}

fn unit(time: Timescale) -> TimescaleUnit {
    // All of its units are VCD's.
    time.unit.parse().unwrap_or(TimescaleUnit::FS)
}

/// A port's value, and which of its bits are undefined.
type FourStates = [Vec<u64>; 2];

/// Ports and their last values.
struct Side<'a> {
    ports: Vec<(&'a Field, IdCode, Option<FourStates>)>,
}

impl<'a> Side<'a> {
    fn declare(writer: &mut Writer<impl io::Write>, fields: &'a [Field]) -> io::Result<Side<'a>> {
        let mut ports = Vec::new();
        for field in fields {
            let (name, width) = (&field.port.name, field.port.width);
            let id = writer.add_var(VarType::Wire, width, name, range(width))?;
            ports.push((field, id, None));
        }
        Ok(Side { ports })
    }

    /// The same signals in another scope.
    fn declare_again(&self, writer: &mut Writer<impl io::Write>) -> io::Result<()> {
        for (field, id, _) in &self.ports {
            let (name, width) = (&field.port.name, field.port.width);
            writer.var_def(VarType::Wire, width, *id, name, range(width))?;
        }
        Ok(())
    }

    /// A record, and which of its bits are undefined, if any.
    fn change(
        &mut self,
        writer: &mut Writer<impl io::Write>,
        (record, undefined): (&[u64], &[u64]),
    ) -> io::Result<()> {
        for (field, id, last) in &mut self.ports {
            let none = vec![0; field.port.width.div_ceil(64) as usize];
            let value = [
                field.read(record),
                if undefined.is_empty() { none } else { field.read(undefined) },
            ];
            if last.as_ref() == Some(&value) {
                continue;
            }
            let width = field.port.width;
            let is_set = |words: &[u64], bit: u32| words[bit as usize / 64] >> (bit % 64) & 1 == 1;
            let bit = |bit: u32| match is_set(&value[1], bit) {
                true => Value::X,
                false => Value::from(is_set(&value[0], bit)),
            };
            if width == 1 {
                writer.change_scalar(*id, bit(0))?;
            } else {
                writer.change_vector(*id, (0..width).rev().map(bit))?;
            }
            *last = Some(value);
        }
        Ok(())
    }
}

fn range(width: u32) -> Option<ReferenceIndex> {
    (width > 1).then(|| ReferenceIndex::Range(width as i32 - 1, 0))
}

/// A signal for each output, and one for all of them.
struct Differences {
    any: IdCode,
    ports: Vec<IdCode>,
    /// The last values, with that of all of them at the end.
    last: Vec<Option<bool>>,
}

impl Differences {
    fn declare(writer: &mut Writer<impl io::Write>, fields: &[Field]) -> io::Result<Differences> {
        writer.add_module(DIFFERS)?;
        let any = writer.add_wire(1, ANY)?;
        let ports = fields.iter().map(|field| writer.add_wire(1, &field.port.name));
        let ports = ports.collect::<io::Result<Vec<IdCode>>>()?;
        writer.upscope()?;
        Ok(Differences { any, last: vec![None; ports.len() + 1], ports })
    }

    fn change(
        &mut self,
        writer: &mut Writer<impl io::Write>,
        differing: impl Iterator<Item = usize>,
    ) -> io::Result<()> {
        let mut now = vec![false; self.last.len()];
        for number in differing {
            now[number] = true;
            now[self.ports.len()] = true;
        }
        let ids = self.ports.iter().chain([&self.any]);
        for ((&id, last), now) in ids.zip(&mut self.last).zip(now) {
            if last.replace(now) != Some(now) {
                writer.change_scalar(id, now)?;
            }
        }
        Ok(())
    }
}
