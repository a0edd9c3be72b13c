//! `goldtof calibrate`: widths of the samples' bins from dark counts.

use anyhow::{Context as _, bail};

use super::prelude::*;
use crate::files;
use crate::recorded::CountsFile;
use crate::recorded::code_density::{CodeDensity, code_density};

#[derive(Debug, Args)]
#[command(
    after_help = "Example: goldtof calibrate scenes/quick.toml dark-counts.csv --out sampler.csv"
)]
pub(super) struct CalibrateArguments {
    #[command(flatten)]
    pub scene: SceneArgument,
    /// Dark counts: columns sample and count, optionally detector and run; or bins of the code
    /// period, as `replay` writes them: bin, count, detector
    pub counts: PathBuf,
    /// File for the widths, which `detector.sampler.file` of a scene reads; with several
    /// detectors, --detector chooses one, for example --out sampler.csv
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Name of the detector to calibrate [default: all], for example --detector spad
    #[arg(long, value_name = "NAME")]
    pub detector: Option<String>,
}

/// The JSON of `goldtof calibrate`.
#[derive(Serialize, schemars::JsonSchema)]
pub(super) struct Calibration {
    /// What the dark counts of each detector say of its sampler.
    samplers: Vec<CodeDensity>,
}

impl Command for CalibrateArguments {
    fn run(&self, _: u64, output: &CommandOutput) -> anyhow::Result<Ending> {
        let sensor = Sensor::new(&self.scene.read()?.scene()?);
        let scene = sensor.scene();
        let file = CountsFile::read(&self.counts)?;
        let mut dark = file.dark_counts(&sensor)?;
        if let Some(name) = &self.detector {
            dark.retain(|dark| scene.detectors[dark.detector].name == *name);
        }
        if dark.is_empty() {
            let names: Vec<&str> = scene.detectors.iter().map(|spad| spad.name.as_str()).collect();
            bail!(
                "--detector names none of the file's: the scene has \"{}\"",
                names.join("\", \"")
            );
        }
        if self.out.is_some() && dark.len() > 1 {
            bail!(
                "--out takes the widths of one detector; choose one of the {} by --detector",
                dark.len()
            );
        }
        let (mut samplers, mut text) = (Vec::new(), String::new());
        for dark in &dark {
            let spad = &scene.detectors[dark.detector];
            let density = code_density(&sensor, dark)
                .with_context(|| format!("{}: detector \"{}\"", file.file, spad.name))?;
            text += &density.text(spad.dark_count_rate_cps);
            samplers.push(density);
        }
        if let (Some(out), [density]) = (&self.out, samplers.as_slice()) {
            files::write(out, &density.csv())?;
            let shown = printable_path(out);
            text += &format!("{shown}: in the scene sampler = {{ file = \"{shown}\" }}\n");
        }
        output.answer(Some(scene.reference()), &Calibration { samplers }, &text)
    }
}
