//! Options that several commands share.

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::Args;

use super::output::{CommandOutput, Ending};
use crate::code::{Family, Generator, MOST_HARDWARE_DEGREE};
use crate::cosim::MOST_CLOCKS;
use crate::estimate::folded;
use crate::light::distance_m;
use crate::plan::link::LinkBudget;
use crate::printable::{printable, printable_path, shell_word};
use crate::scene::{DetectorIndex, PathIndex, SceneErrors, SceneText, Setting};
use crate::sensor::Sensor;
use crate::shard::JobPart;

#[derive(Debug, Args)]
pub(super) struct SceneArgument {
    /// Scene file (TOML), for example scenes/paper-single.toml
    pub scene: PathBuf,
    /// Override a key of the file; may be repeated. Several tables are told
    /// apart by number or name: --set 'path[0].distance=5 m' --set 'source[laser].mean_power=1 pW'
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub settings: Vec<Setting>,
}

impl SceneArgument {
    /// The sensor of the scene with its settings, and a warning of paths that are too far for it.
    ///
    /// # Errors
    /// If it cannot be read, and everything that is wrong with it.
    pub fn sensor(&self, output: &CommandOutput) -> Result<Sensor, SceneErrors> {
        let sensor = Sensor::new(&self.read()?.scene()?);
        warn(&sensor, output);
        Ok(sensor)
    }

    /// The file's text, and the settings.
    ///
    /// # Errors
    /// If it cannot be read.
    pub fn read(&self) -> Result<SceneText, SceneErrors> {
        SceneText::read(&self.scene, &self.settings)
    }

    /// The file's name and the settings, as a command line has them. Where the file lies
    /// is left out, so that what is made does not depend on it.
    pub fn shown(&self) -> String {
        let name = self.scene.file_name().unwrap_or_default();
        let mut shown = shell_word(&printable_path(Path::new(name))).into_owned();
        for setting in &self.settings {
            let origin = printable(setting.origin());
            let (option, set) = origin.split_once(' ').unwrap_or(("", &origin));
            shown += &format!(" {option} {}", shell_word(set));
        }
        shown
    }
}

/// Which part of the work, and where it goes.
pub(super) struct ShardOrder<'a> {
    /// Which part.
    pub part: JobPart,
    /// The folder of the job's shards is in this one.
    pub out: &'a Path,
}

/// Whether the exit status reports a contradicted expectation.
#[derive(Debug, Args)]
pub(super) struct CheckArgument {
    /// Exit with status 1 if scans contradict their expected bias, standard deviation or
    /// share of missed peaks, or recorded counts their scene
    #[arg(long)]
    pub check: bool,
}

/// A shard of the work, of a command without an output folder of its own.
#[derive(Debug, Args)]
pub(super) struct ShardArguments {
    /// Do one of N shards of the work, for `goldtof merge` to join: --shard 3/20, or
    /// --shard task/20 in an array job (Slurm, HyperQueue)
    #[arg(long, value_name = "I/N", value_parser = parse_shard, requires = "out")]
    pub shard: Option<JobPart>,
    /// Folder for the shards; created if missing, for example --out out/many
    #[arg(long, value_name = "DIR", requires = "shard")]
    pub out: Option<PathBuf>,
}

impl ShardArguments {
    /// Which part, and where it goes, if only a part is asked for.
    pub fn order(&self) -> Option<ShardOrder<'_>> {
        let (part, out) = (self.shard?, self.out.as_deref()?);
        Some(ShardOrder { part, out })
    }
}

/// A window of clocks for waveforms.
#[derive(Debug, Args)]
pub(super) struct VcdWindow {
    /// First clock of the waveforms, reset included, 0 to 2^50 [default: 0 with --vcd-clocks,
    /// else a thousand before the first mismatch or result], for example --vcd-from 100000
    #[arg(long, value_name = "CLOCK", value_parser = clap::value_parser!(u64).range(0..=MOST_CLOCKS))]
    pub vcd_from: Option<u64>,
    /// Clocks of the waveforms, 1 to 1000000 [default: 2000], for example --vcd-clocks 500
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    pub vcd_clocks: Option<u64>,
}

impl VcdWindow {
    /// Clocks of a window without a length.
    const CLOCKS: u64 = 2000;

    /// The window, if one was given.
    pub fn clocks(&self) -> Option<Range<u64>> {
        if self.vcd_from.is_none() && self.vcd_clocks.is_none() {
            return None;
        }
        let from = self.vcd_from.unwrap_or(0);
        Some(from..from + self.vcd_clocks.unwrap_or(VcdWindow::CLOCKS))
    }
}

/// What a command line asks for.
pub(super) trait Command {
    /// Does it, with the seed of all random numbers.
    fn run(&self, seed: u64, output: &CommandOutput) -> anyhow::Result<Ending>;
}

/// Longest time that can be asked for: 1000 days.
const MOST_SECONDS: f64 = 1000.0 * 86_400.0;

/// Reads a time with its unit: "90s", "10min" or "2h".
pub(super) fn parse_time(text: &str) -> Result<Duration, String> {
    let text = text.trim();
    let digits = text.trim_end_matches(|c: char| c.is_ascii_alphabetic());
    let unit_s = match &text[digits.len()..] {
        "s" => 1.0,
        "min" => 60.0,
        "h" => 3600.0,
        _ => {
            return Err("write a number with its unit, as \"90 s\", \"10min\" or \"2h\"".to_owned());
        }
    };
    let seconds = digits.trim().parse::<f64>().map_or(f64::NAN, |n| n * unit_s);
    // Neither is one that is not a number.
    if (1e-3..=MOST_SECONDS).contains(&seconds) {
        Ok(Duration::from_secs_f64(seconds))
    } else {
        Err(format!("write a time from 0.001 s to {} h", MOST_SECONDS / 3600.0))
    }
}

/// `--shard`, which may ask for the number of the present task.
pub(super) fn parse_shard(text: &str) -> Result<JobPart, String> {
    JobPart::parse(text, |name| std::env::var(name).ok())
}

/// Primary detections in a dead time from which a detector counts as saturated: it is ready for
/// less than a tenth of the time, and the code shows in little more than when it becomes ready.
const SATURATED: f64 = 10.0;

/// Warns of what the sensor that a scene describes hardly can do.
pub(super) fn warn(sensor: &Sensor, output: &CommandOutput) {
    tell_pixel(sensor, output);
    warn_of_far_paths(sensor, output);
    warn_of_saturation(sensor, output);
}

/// Tells which pixel of an array it is.
fn tell_pixel(sensor: &Sensor, output: &CommandOutput) {
    let Some(array) = &sensor.scene().array else { return };
    let (row, column, lens) = (array.row, array.column, &array.lens);
    let dark = match sensor.scene().own_paths(DetectorIndex(0)).next() {
        Some(_) => "",
        None => ", which gets no light of its detector's source",
    };
    output.note(&format!(
        "of the array's {} rows of {} pixels this is row {row}, column {column}{dark} (array.row, \
         array.column); `goldtof image` takes all",
        lens.rows, lens.columns
    ));
}

/// Warns of detectors that the light of one path keeps blind.
fn warn_of_saturation(sensor: &Sensor, output: &CommandOutput) {
    let scene = sensor.scene();
    for index in PathIndex::of(&scene.paths) {
        let path = &scene.paths[index];
        let (source, spad) = (&scene.sources[path.source], &scene.detectors[path.detector]);
        let primary_hz = LinkBudget::of(scene, index).primary_hz;
        let in_dead_time = primary_hz * spad.dead_time_ps * 1e-12 / f64::from(spad.cells);
        if in_dead_time > SATURATED {
            output.note(&format!(
                "warning: detector {} saturates: path {index} would fire it {primary_hz:.2e} times a second, \
                 and it is blind for {} ns after each detection; source[{}].mean_power = \"{:.1e} W\" \
                 leaves it ready half of the time",
                printable(&spad.name),
                spad.dead_time_ps * 1e-3,
                printable(&source.name),
                source.mean_power_w / in_dead_time,
            ));
        }
    }
}

/// Warns of paths beyond the unambiguous range; whether there are any.
pub(super) fn warn_of_far_paths(sensor: &Sensor, output: &CommandOutput) -> bool {
    for (path, folded) in far_paths(sensor) {
        let advice = longer_code(sensor, path)
            .map_or(String::new(), |degree| format!("; codes of degree {degree} reach that far"));
        output.note(&format!("warning: path {path}: {folded}{advice}"));
    }
    is_far(sensor)
}

/// Whether a path is beyond the unambiguous range.
pub(super) fn is_far(sensor: &Sensor) -> bool {
    far_paths(sensor).next().is_some()
}

fn far_paths(sensor: &Sensor) -> impl Iterator<Item = (PathIndex, String)> {
    let paths = PathIndex::of(&sensor.scene().paths);
    paths.filter_map(|path| Some((path, folded(sensor, path)?)))
}

/// Smallest degree of the path's code family with an unambiguous range beyond the path, as far
/// as the hardware supports it.
fn longer_code(sensor: &Sensor, path: PathIndex) -> Option<u32> {
    let path = &sensor.scene().paths[path];
    let code = &sensor.scene().sources[path.source].code;
    let family = match code.generator {
        Generator::Gold { .. } => Family::Gold,
        Generator::MSequence(_) => Family::MSequence,
        Generator::Square | Generator::Chips(_) => return None,
    };
    let reaches = |degree: u32| {
        let chips = ((1_u64 << degree) - 1) << code.interleave;
        distance_m(sensor.clock().ps(chips as f64)) > path.distance_m()
    };
    // No preferred pair where 4 divides the degree.
    let has_codes = |degree: &u32| family == Family::MSequence || !degree.is_multiple_of(4);
    (3..=MOST_HARDWARE_DEGREE).filter(has_codes).find(|&degree| reaches(degree))
}

#[cfg(test)]
mod tests {
    use super::parse_time;

    #[test]
    fn a_time_has_its_unit_and_its_bounds() {
        let time = |text| parse_time(text).map(|time| time.as_secs_f64());
        assert_eq!(time("10min"), Ok(600.0));
        assert_eq!(time(" 1.5 h "), Ok(5400.0));
        assert_eq!(time("0.25s"), Ok(0.25));
        for text in ["", "10", "s", "-1 s", "0 s", "1e99 h", "nan s", "inf s", "1 d", "1 \u{b5}s"] {
            assert!(time(text).is_err(), "{text}");
        }
    }
}
