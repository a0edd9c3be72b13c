//! `goldtof explain`: what limits a sensor.

use super::prelude::*;
use crate::report::limits::text;
use crate::study::limits::limits;

#[derive(Debug, Args)]
#[command(after_help = "Example: goldtof explain scenes/quick.toml")]
pub(super) struct ExplainArguments {
    #[command(flatten)]
    pub scene: SceneArgument,
    /// Name of the detector, for example --detector spad [default: the scene's first]
    #[arg(long, value_name = "NAME")]
    pub detector: Option<String>,
}

impl Command for ExplainArguments {
    fn run(&self, _: u64, output: &CommandOutput) -> anyhow::Result<Ending> {
        let scene = self.scene.read()?;
        warn(&Sensor::new(&scene.scene()?), output);
        let limits = limits(&scene, self.detector.as_deref())?;
        output.answer(Some(scene.reference()), &limits, &text(&limits, terminal_width()))
    }
}
