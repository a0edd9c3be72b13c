//! `goldtof plan`: what is kept and what is left out, and why; the sensor in numbers.

use super::common::SceneArgument;
use super::ending::Ending;
use super::output::{Output, terminal_width};
use super::warnings::warn_of_far_paths;
use crate::plan::overview::overview;
use crate::report::plan::text;
use crate::sensor::Sensor;

pub(super) fn run(arguments: &SceneArgument, output: &mut Output) -> anyhow::Result<Ending> {
    let scene = arguments.load()?;
    let sensor = Sensor::new(&scene);
    warn_of_far_paths(&sensor, output);
    let overview = overview(&sensor);
    output.answer(Some(&scene), &overview, &text(&overview, terminal_width()))?;
    Ok(Ending::Done)
}
