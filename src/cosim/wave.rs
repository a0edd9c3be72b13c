//! Waveforms of both sides, for a wave viewer.

use std::io;
use std::path::Path;

use vcd::{IdCode, SimulationCommand, TimescaleUnit, Value, Writer};

use crate::files::{FileError, stage};
use crate::reference::blocks::Records;
use crate::sensor::layout::{Field, Layout, Record};

/// Writes a VCD file with all ports: `inputs`, `expected` (the reference model),
/// `got` (the Verilog) and `differs`, high while any port differs.
///
/// Time is real time since the start of the run, in picoseconds: clock t starts
/// at t chip periods with its inputs; the clock rises, and the outputs change,
/// half a chip period later.
///
/// # Errors
/// When the file cannot be written; nothing is left under its name then.
pub fn write(
    path: &Path,
    records: &Records,
    layout: &Layout,
    chip_period_ps: f64,
) -> Result<(), FileError> {
    stage(path, |out| write_to(out, records, layout, chip_period_ps))?.publish()
}

fn write_to(
    out: &mut dyn io::Write,
    records: &Records,
    layout: &Layout,
    chip_period_ps: f64,
) -> io::Result<()> {
    let mut writer = Writer::new(out);
    writer.timescale(1, TimescaleUnit::PS)?;
    writer.add_module("cosim")?;
    let clock = writer.add_wire(1, Layout::CLOCK)?;
    let differs = writer.add_wire(1, "differs")?;
    let mut inputs = Side::declare(&mut writer, "inputs", &layout.inputs)?;
    let mut expected = Side::declare(&mut writer, "expected", &layout.outputs)?;
    let mut got = Side::declare(&mut writer, "got", &layout.outputs)?;
    writer.upscope()?;
    writer.enddefinitions()?;

    let rows = records
        .inputs
        .chunks_exact(layout.inputs.words)
        .zip(records.expected.chunks_exact(layout.outputs.words))
        .zip(records.got.chunks_exact(layout.outputs.words));
    for (i, ((input, wanted), seen)) in rows.enumerate() {
        let t = (records.first_clock + i as u64) as f64;
        writer.timestamp((t * chip_period_ps).round() as u64)?;
        if i == 0 {
            writer.begin(SimulationCommand::Dumpvars)?;
        }
        writer.change_scalar(clock, false)?;
        inputs.change(&mut writer, input)?;
        if i == 0 {
            writer.end()?;
        }
        writer.timestamp(((t + 0.5) * chip_period_ps).round() as u64)?;
        writer.change_scalar(clock, true)?;
        writer.change_scalar(differs, wanted != seen)?;
        expected.change(&mut writer, wanted)?;
        got.change(&mut writer, seen)?;
    }
    Ok(())
}

/// The ports of one side and their last values.
struct Side<'a> {
    ports: Vec<(&'a Field, IdCode, Option<Vec<u64>>)>,
}

impl<'a> Side<'a> {
    fn declare(
        writer: &mut Writer<impl io::Write>,
        name: &str,
        record: &'a Record,
    ) -> io::Result<Side<'a>> {
        writer.add_module(name)?;
        let mut ports = Vec::new();
        for field in &record.fields {
            let id = writer.add_wire(field.port.width, &field.port.name)?;
            ports.push((field, id, None));
        }
        writer.upscope()?;
        Ok(Side { ports })
    }

    fn change(&mut self, writer: &mut Writer<impl io::Write>, record: &[u64]) -> io::Result<()> {
        for (field, id, last) in &mut self.ports {
            let value = field.read(record);
            if last.as_ref() == Some(&value) {
                continue;
            }
            let width = field.port.width;
            if width == 1 {
                writer.change_scalar(*id, value[0] == 1)?;
            } else {
                let bits = (0..width)
                    .rev()
                    .map(|bit| Value::from(value[bit as usize / 64] >> (bit % 64) & 1 == 1));
                writer.change_vector(*id, bits)?;
            }
            *last = Some(value);
        }
        Ok(())
    }
}
