//! `goldtof image`: what an array of pixels sees.

use std::path::{Path, PathBuf};

use clap::Args;

use super::command::Command;
use super::common::{Order, SceneArgument};
use super::image_files::{PAGE, write};
use super::output::{Bar, Ending, Output, terminal_width};
use super::provenance::typed_command;
use super::shards::InShards;
use super::target_maps::read_target;
use super::values::parse_shard;
use crate::files::OutputFolder;
use crate::image::{Image, ImageError, ImageOptions, MapTarget, View, image};
use crate::printable::printable_path;
use crate::progress::Progress;
use crate::report::image::text;
use crate::scene::{Lens, SceneReference};
use crate::sensor::Sensor;
use crate::shard::{ImageJob, Job, Part, Parts, Results, pixel_rows};

#[derive(Debug, Args)]
#[command(after_help = "Example: goldtof image scenes/image.toml --out out/image --check 200")]
pub(super) struct ImageArguments {
    #[command(flatten)]
    pub scene: SceneArgument,
    #[command(flatten)]
    pub options: ImageOptions,
    /// Map of depths along the axis in place of the scene's surfaces, as large as the array: NPY or
    /// PFM in metres, or 16-bit PNG in millimetres; for example --depth room.npy
    #[arg(long, value_name = "FILE")]
    pub depth: Option<PathBuf>,
    /// Map of reflectances to go with --depth: NPY, PFM, or PNG whose white is 1
    /// [default: 0.5 everywhere], for example --reflectance room.png
    #[arg(long, value_name = "FILE", requires = "depth")]
    pub reflectance: Option<PathBuf>,
    /// Simulate one of N shards of the rows of pixels, for `goldtof merge` to join: --shard 3/20, or
    /// --shard task/20 in an array job (Slurm, HyperQueue)
    #[arg(long, value_name = "I/N", value_parser = parse_shard, conflicts_with = "depth")]
    pub shard: Option<Part>,
    /// Folder for the maps (NPY and PNG), points.ply and index.html; created if missing, for
    /// example --out out/image
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
}

impl Command for ImageArguments {
    fn run(&self, seed: u64, output: &Output) -> anyhow::Result<Ending> {
        let text = self.scene.read()?;
        let sensor = Sensor::new(&text.scene()?);
        let options = ImageOptions { seed, ..self.options.clone() };
        if let Some(part) = self.shard {
            anyhow::ensure!(
                options.fidelity.draws(),
                "an image from theory takes seconds, and has no rows that could be shared out; \
                 leave out --shard, or simulate every pixel: --fidelity events"
            );
            // An array without light is told before a folder is made.
            View::new(&sensor, &options, None)?;
            let job = Job::Image(ImageJob { scene: text.without_folder(), options });
            return Order { part, out: &self.out }.fulfil(job, output);
        }
        let target = target(self, &sensor)?;
        // Before the work, so that a folder that cannot be had is told at once.
        let folder = output.folder(&self.out)?;
        let bar = output.bar();
        let told = image(&sensor, &options, target.as_ref(), shown_on(&bar));
        bar.end();
        tell(&sensor, text.reference(), &told?, &folder, output)
    }
}

impl InShards for ImageJob {
    fn part(&self, part: Part, _: &OutputFolder, output: &Output) -> anyhow::Result<Results> {
        let view = View::new(&Sensor::new(&self.scene.scene()?), &self.options, None)?;
        let rows = part.every(u64::from(view.lens().rows)).map(|row| row as u32);
        let bar = output.bar();
        let told = view.scans(&rows.collect::<Vec<_>>(), shown_on(&bar));
        bar.end();
        Ok(Results::Image(told?))
    }

    fn merge(&self, parts: Parts, out: &Path, output: &Output) -> anyhow::Result<Ending> {
        let sensor = Sensor::new(&self.scene.scene()?);
        let view = View::new(&sensor, &self.options, None)?;
        let rows = pixel_rows([view.lens().rows, view.lens().columns], parts)?;
        let image = view.image(rows)?;
        tell(&sensor, self.scene.reference(), &image, &output.folder(out)?, output)
    }
}

/// Pixels that are done, on a bar.
fn shown_on(bar: &Bar) -> impl FnMut(Progress) + '_ {
    |progress| {
        if let Progress::Parts { done, of } = progress {
            bar.clocks("simulating pixels", done, of);
        }
    }
}

fn tell(
    sensor: &Sensor,
    scene: SceneReference,
    image: &Image,
    folder: &OutputFolder,
    output: &Output,
) -> anyhow::Result<Ending> {
    let of_scene = sensor.scene();
    let estimator = image.options.estimator.unwrap_or(of_scene.estimator);
    let report = image.report(&of_scene.name, estimator);
    let names = write(image, &report, &typed_command(), folder)?;
    output.note(&format!(
        "wrote {} files, the page {} among them",
        names.len(),
        printable_path(&folder.join(PAGE))
    ));
    output.answer(Some(scene), &report, &text(&report, terminal_width()))
}

/// The maps that stand for the scene's surfaces.
fn target(arguments: &ImageArguments, sensor: &Sensor) -> anyhow::Result<Option<MapTarget>> {
    let Some(depth) = &arguments.depth else { return Ok(None) };
    let lens: Lens = sensor.scene().array.as_ref().ok_or(ImageError::NoArray)?.lens;
    Ok(Some(read_target(depth, arguments.reflectance.as_deref(), &lens)?))
}
