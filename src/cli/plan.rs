//! `goldtof plan`: what is kept and what is left out, and why; the sensor in numbers.

use super::command::Command;
use super::common::SceneArgument;
use super::output::{Ending, Output, terminal_width};
use crate::plan::overview::overview;
use crate::report::plan::text;

impl Command for SceneArgument {
    fn run(&self, _: u64, output: &Output) -> anyhow::Result<Ending> {
        let sensor = self.sensor(output)?;
        let overview = overview(&sensor);
        output.answer(
            Some(sensor.scene().reference()),
            &overview,
            &text(&overview, terminal_width()),
        )
    }
}
