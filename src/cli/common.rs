//! Options that several commands share.

use std::ops::Range;
use std::path::{Path, PathBuf};

use clap::Args;

use super::output::Output;
use super::values::parse_shard;
use super::warnings::warn;
use crate::cosim::MOST_CLOCKS;
use crate::printable::{printable, printable_path, shell_word};
use crate::scene::{SceneErrors, SceneText, Setting};
use crate::sensor::Sensor;
use crate::shard::Part;

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
    pub fn sensor(&self, output: &Output) -> Result<Sensor, SceneErrors> {
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
pub(super) struct Order<'a> {
    /// Which part.
    pub part: Part,
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
    pub shard: Option<Part>,
    /// Folder for the shards; created if missing, for example --out out/many
    #[arg(long, value_name = "DIR", requires = "shard")]
    pub out: Option<PathBuf>,
}

impl ShardArguments {
    /// Which part, and where it goes, if only a part is asked for.
    pub fn order(&self) -> Option<Order<'_>> {
        let (part, out) = (self.shard?, self.out.as_deref()?);
        Some(Order { part, out })
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
