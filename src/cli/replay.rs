//! `goldtof replay`: photons that an instrument recorded.

use std::fs::File;
use std::io::BufReader;

use goldtof_tags::{Channel, TagReader};

use super::prelude::*;
use crate::recorded::{Assessment, RecordedScan};
use crate::replay::{Epochs, Replay, ReplayOptions, ReplayReport, as_histogram, replay, report};
use crate::report::{DetectorCounts, bins_csv, counts_csv, residual_plot};

/// Which channels of a recording are which.
#[derive(Debug, Clone, Args)]
pub(super) struct ChannelArguments {
    /// Channel of a detector's photons, with its name where there are several detectors: --photons 1,
    /// or --photons left=1 --photons right=2. Inputs are numbered as on the instrument
    #[arg(long, value_name = "[DETECTOR=]CHANNEL")]
    pub photons: Vec<String>,
    /// Channel of the marks at the code's epochs: the number of an input, m1 to m4 for a marker, or
    /// sync, for example --epoch m1
    #[arg(long, value_name = "CHANNEL", default_value = "m1")]
    pub epoch: Channel,
    /// Code periods from one mark to the next, 1 to 1000000, for example --epoch-periods 16
    #[arg(long, value_name = "N", default_value_t = 1,
          value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    pub epoch_periods: u64,
}

impl ChannelArguments {
    /// Reads a recording.
    pub fn replay(
        &self,
        sensor: &Sensor,
        tags: &Path,
        output: &CommandOutput,
    ) -> anyhow::Result<Replay> {
        let scene = sensor.scene();
        let options = ReplayOptions::named(scene, &self.photons, self.epoch, self.epoch_periods)?;
        let mut reader: TagReader<BufReader<File>> = TagReader::open(tags)?;
        let of = reader.announced().unwrap_or(0);
        let bar = output.bar();
        let told = replay(sensor, &mut reader, &options, |done| {
            bar.clocks("reading records", done, of.max(done));
        });
        bar.end();
        Ok(told?)
    }
}

#[derive(Debug, Args)]
#[command(
    after_help = "Example: goldtof replay scenes/quick.toml evening.ptu --photons 1 --epoch m1 --out out/evening"
)]
pub(super) struct ReplayArguments {
    #[command(flatten)]
    pub scene: SceneArgument,
    /// Time tags: a PTU file in T2 mode, or pairs of little-endian 64-bit numbers, picoseconds and
    /// channel
    pub tags: PathBuf,
    #[command(flatten)]
    pub channels: ChannelArguments,
    /// Folder for bins.csv, counts.csv of the first scan, and plots; created if missing, for example
    /// --out out/evening
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    #[command(flatten)]
    pub check: CheckArgument,
}

impl Command for ReplayArguments {
    fn run(&self, _: u64, output: &CommandOutput) -> anyhow::Result<Ending> {
        let sensor = self.scene.sensor(output)?;
        let replayed = self.channels.replay(&sensor, &self.tags, output)?;
        let folded = as_histogram(&sensor, &replayed.file.epochs);
        let (report, scans) = report(&sensor, &replayed)?;
        if let Some(out) = &self.out {
            let folder = output.folder(out)?;
            folder.write("bins.csv", &bins_csv(&folded, &replayed.histograms))?;
            for (number, assessment) in report.histograms.iter().step_by(2).enumerate() {
                folder.write(&format!("bins-{number}.svg"), &residual_plot(assessment))?;
            }
            if !scans.is_empty() {
                let counts = counted(&sensor, &scans, &report.scan);
                folder.write("counts.csv", &counts_csv(&sensor, &counts))?;
            }
            for (number, assessment) in report.scan.iter().enumerate() {
                folder.write(&format!("counts-{number}.svg"), &residual_plot(assessment))?;
            }
        }
        output.answer(Some(sensor.scene().reference()), &report, &text(&report))?;
        let holds = report.histograms.iter().chain(&report.scan).all(Assessment::holds);
        Ok(Ending::of_check(self.check.check, holds))
    }
}

/// Counts with what belongs beside them in a file.
fn counted(sensor: &Sensor, scans: &[RecordedScan], told: &[Assessment]) -> Vec<DetectorCounts> {
    let totals = sensor.scene().sends_total_counts();
    let of_scan = |(scan, told): (&RecordedScan, &Assessment)| {
        let offset_ps = told.estimate.calibration_offset_ps;
        let counts = scan.counts.iter();
        DetectorCounts {
            counts: counts.clone().map(|count| count.signed).collect(),
            totals: totals.then(|| counts.map(|count| count.total).collect()),
            ..DetectorCounts::of_steps(sensor, scan.detector, offset_ps, scan.counts.len())
        }
    };
    scans.iter().zip(told).map(of_scan).collect()
}

fn text(report: &ReplayReport) -> String {
    let file = &report.file;
    let Epochs { epochs, missing, pauses, stray, periods, .. } = &file.epochs;
    let mut text = format!(
        "{}: {} records, {periods} code periods\n{epochs} epochs, {missing} missing, {pauses} pauses, {stray} \
         marks that are none; the code period is {:+.3} ppm off the scene's, and marks scatter by {:.1} ps\n",
        file.kind,
        file.records,
        file.epochs.period_error_fraction * 1e6,
        file.epochs.jitter_std_s * 1e12
    );
    if file.torn_bytes > 0 {
        text += &format!("the last record is torn: {} bytes of it are there\n", file.torn_bytes);
    }
    if let Some(announced) = file.announced_records.filter(|all| *all > file.records) {
        text += &format!(
            "the header says that there are {announced} records: the recording was broken off\n"
        );
    }
    if file.disordered > 0 {
        text += &format!("{} records are earlier than one before them\n", file.disordered);
    }
    for detector in &report.detectors {
        text += &format!(
            "{}: {} photons, {:.4} Mcps, {} of them within another one's pulse\n",
            detector.detector,
            detector.photons,
            detector.rate_cps * 1e-6,
            detector.unseen
        );
    }
    text += "all code periods, folded into a histogram:\n";
    text += &report.histograms.iter().map(Assessment::to_string).collect::<String>();
    if !report.scan.is_empty() {
        text += "the first scan, as the hardware would have counted it:\n";
        text += &report.scan.iter().map(Assessment::to_string).collect::<String>();
    }
    text
}
