//! `goldtof image`: what an array of pixels sees.

use std::io::{self, Write};

use super::output::Bar;
use super::prelude::*;
use super::target_maps::read_target;
use crate::files::FileError;
use crate::image::{
    ArrayView, Image, ImageError, ImageOptions, ImageReport, Map, MapTarget, image,
};
use crate::progress::Progress;
use crate::report::image::{page, text};
use crate::report::raster::{Picture, picture};
use crate::scene::Lens;
use crate::shard::{ImageJob, pixel_rows};

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
    pub shard: Option<JobPart>,
    /// Folder for the maps (NPY and PNG), points.ply and index.html; created if missing, for
    /// example --out out/image
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
}

impl Command for ImageArguments {
    fn run(&self, seed: u64, output: &CommandOutput) -> anyhow::Result<Ending> {
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
            ArrayView::new(&sensor, &options, None)?;
            let job = Job::Image(ImageJob { scene: text.without_folder(), options });
            return ShardOrder { part, out: &self.out }.fulfil(job, output);
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
    fn part(
        &self,
        part: JobPart,
        _: &OutputFolder,
        output: &CommandOutput,
    ) -> anyhow::Result<Results> {
        let view = ArrayView::new(&Sensor::new(&self.scene.scene()?), &self.options, None)?;
        let rows = part.every(u64::from(view.lens().rows)).map(|row| row as u32);
        let bar = output.bar();
        let told = view.scans(&rows.collect::<Vec<_>>(), shown_on(&bar));
        bar.end();
        Ok(Results::Image(told?))
    }

    fn merge(
        &self,
        parts: PartResults,
        out: &Path,
        output: &CommandOutput,
    ) -> anyhow::Result<Ending> {
        let sensor = Sensor::new(&self.scene.scene()?);
        let view = ArrayView::new(&sensor, &self.options, None)?;
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
    output: &CommandOutput,
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

pub(super) const PAGE: &str = "index.html";
const POINTS: &str = "points.ply";

/// Writes all files, all or none; gives their names, the page last.
///
/// # Errors
/// When one cannot be written.
pub(super) fn write(
    image: &Image,
    report: &ImageReport,
    command: &str,
    folder: &OutputFolder,
) -> Result<Vec<String>, FileError> {
    let mut names: Vec<String> = Vec::new();
    let mut staged = Vec::new();
    for named in image.maps() {
        let (array, shown) = (format!("{}.npy", named.name), format!("{}.png", named.name));
        staged.push(folder.stage(&array, |out| npy(&named.map, out))?);
        staged.push(folder.stage(&shown, |out| png(&picture(&named), out))?);
        names.extend([array, shown]);
    }
    staged.push(folder.stage(POINTS, |out| ply(image, out))?);
    staged.push(folder.stage(PAGE, |out| out.write_all(page(report, command).as_bytes()))?);
    names.extend([POINTS.to_owned(), PAGE.to_owned()]);
    folder.publish(staged)?;
    Ok(names)
}

/// A map as a NumPy array of 32-bit floating-point numbers, version 1.0 of the format: a header of
/// text, padded so that the numbers begin at a multiple of 64 bytes.
fn npy(map: &Map, out: &mut dyn Write) -> io::Result<()> {
    const BEFORE_TEXT: usize = 10;
    let text = format!(
        "{{'descr': '<f4', 'fortran_order': False, 'shape': ({}, {}), }}",
        map.rows(),
        map.columns
    );
    let length = (BEFORE_TEXT + text.len() + 1).next_multiple_of(64) - BEFORE_TEXT;
    out.write_all(b"\x93NUMPY\x01\x00")?;
    out.write_all(&(length as u16).to_le_bytes())?;
    writeln!(out, "{text:<width$}", width = length - 1)?;
    let numbers = map.values.iter().flat_map(|value| (*value as f32).to_le_bytes());
    out.write_all(&numbers.collect::<Vec<u8>>())
}

fn png(picture: &Picture, out: &mut dyn Write) -> io::Result<()> {
    let mut encoder = png::Encoder::new(out, picture.width as u32, picture.height as u32);
    encoder.set_color(png::ColorType::Indexed);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_palette(picture.palette.concat());
    encoder.set_compression(png::Compression::High);
    // Numbers of colours are no measure of anything: their differences are no smaller.
    encoder.set_filter(png::Filter::NoFilter);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&picture.pixels)?;
    Ok(writer.finish()?)
}

/// The measured points, in metres: x to the right, y down, z away from the lens; with the
/// detections per second, the confidence, and the standard deviation where it is known.
fn ply(image: &Image, out: &mut dyn Write) -> io::Result<()> {
    let (seen, measured) = (&image.seen, &image.measured);
    let pixels = 0..measured.distance_m.values.len();
    let known: Vec<usize> =
        pixels.filter(|&pixel| measured.distance_m.values[pixel].is_finite()).collect();
    writeln!(out, "ply\nformat binary_little_endian 1.0\nelement vertex {}", known.len())?;
    for property in ["x", "y", "z", "intensity_cps", "confidence", "std_m"] {
        writeln!(out, "property float {property}")?;
    }
    writeln!(out, "end_header")?;
    let mut bytes = Vec::with_capacity(known.len() * 24);
    for pixel in known {
        let light = &seen.lights[pixel];
        let depth = measured.distance_m.values[pixel] * light.depth_per_distance();
        let beside = [&measured.detected_rate_cps, &measured.found_fraction, &measured.std_m];
        let place = light.ray.iter().map(|along| along * depth);
        for value in place.chain(beside.map(|map| map.values[pixel])) {
            bytes.extend((value as f32).to_le_bytes());
        }
    }
    out.write_all(&bytes)
}
