//! `goldtof plan`: what is kept and what is left out, and why; the sensor in numbers.

use super::common::SceneArgument;
use super::ending::Ending;
use super::output::{Output, terminal_width};
use crate::plan::overview::overview;
use crate::report::plan::text;

pub(super) fn run(arguments: &SceneArgument, output: &mut Output) -> anyhow::Result<Ending> {
    let sensor = arguments.sensor(output)?;
    let overview = overview(&sensor);
    output.answer(
        Some(sensor.scene().reference()),
        &overview,
        &text(&overview, terminal_width()),
    )?;
    Ok(Ending::Done)
}
