//! `goldtof plan`: what is kept and what is left out, and why.

use super::Ending;
use super::arguments::SceneArgument;
use super::output::Output;
use crate::plan;
use crate::scene;
use crate::sensor::Sensor;

pub(super) fn run(arguments: &SceneArgument, output: &mut Output) -> anyhow::Result<Ending> {
    let sensor = Sensor::new(&scene::load(&arguments.scene)?);
    let plan = plan::with_savings(plan::plan(&sensor), &sensor);
    output.answer(&plan, &plan.to_text())?;
    Ok(Ending::Done)
}
