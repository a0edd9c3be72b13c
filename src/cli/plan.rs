//! `goldtof plan`: what is kept and what is left out, and why; the sensor in numbers.

use super::Ending;
use super::arguments::SceneArgument;
use super::output::{Output, terminal_width};
use crate::plan::overview::overview;
use crate::report::plan::text;
use crate::scene;

pub(super) fn run(arguments: &SceneArgument, output: &mut Output) -> anyhow::Result<Ending> {
    let scene = scene::load(&arguments.scene)?;
    let overview = overview(&scene);
    output.answer(&overview, &text(&overview, terminal_width()))?;
    Ok(Ending::Done)
}
