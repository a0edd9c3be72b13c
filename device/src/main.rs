//! `goldtof-device`: reads a sensor at a serial port.

mod job;
mod parts;
mod samples;
mod view;

use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Parser, Subcommand};
use goldtof::Sensor;
use goldtof_device::{Line, hexadecimal, scene_hash};
use goldtof_system::files;
use goldtof_system::printable::printable_path;
use goldtof_wire::{Content, Identity};

/// What ended the program, in words.
type Failed = Box<dyn Error>;

/// Reads a sensor at a serial port: what it is, its counts, its registers.
#[derive(Debug, Parser)]
#[command(
    name = "goldtof-device",
    version,
    after_help = "Examples:\n  goldtof-device watch --port /dev/ttyUSB1 --scene build/board/scene.toml\n  \
                  goldtof-device record --port /dev/ttyUSB1 --scene scenes/quick.toml --out counts.csv --seconds 10"
)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Lists the serial ports of this machine.
    Ports,
    /// Says what the device is.
    Identify {
        #[command(flatten)]
        line: LineArguments,
        /// Takes the scene from the device, whose scene has hardware.scene_text, into this file, which may
        /// not exist.
        #[arg(long, value_name = "FILE")]
        scene_out: Option<PathBuf>,
    },
    /// Shows counts, distance, rate and losses in the terminal as they come.
    Watch {
        #[command(flatten)]
        line: LineArguments,
        #[command(flatten)]
        recording: Recording,
    },
    /// Says each second how the measurement goes, and writes counts.
    Record {
        #[command(flatten)]
        line: LineArguments,
        #[command(flatten)]
        recording: Recording,
    },
    /// Counts hits by sample of the chip, for `goldtof calibrate`: cover detectors, and turn lasers off.
    Samples {
        #[command(flatten)]
        line: LineArguments,
        /// File for the counts, which may not exist.
        #[arg(long, value_name = "FILE")]
        out: PathBuf,
        /// Length of each recording.
        #[arg(long, value_name = "SECONDS", default_value_t = 10.0)]
        seconds: f64,
        /// Recordings, which have to agree.
        #[arg(long, value_name = "N", default_value_t = 4)]
        runs: u32,
    },
    /// Reads a register.
    Read {
        #[command(flatten)]
        line: LineArguments,
        /// Byte address, `0x` for hexadecimal: 0x010.
        #[arg(value_parser = number)]
        address: u32,
    },
    /// Writes a register.
    Write {
        #[command(flatten)]
        line: LineArguments,
        /// Byte address, `0x` for hexadecimal: 0x010.
        #[arg(value_parser = number)]
        address: u32,
        /// What to write: 0x1 or 1.
        #[arg(value_parser = number)]
        data: u32,
        /// Writes taps that are no primitive polynomial, too, which --scene finds.
        #[arg(long)]
        force: bool,
    },
}

/// What becomes of the counts, and how long.
#[derive(Debug, clap::Args)]
struct Recording {
    /// File for the counts, CSV, or NAME.parquet for a folder of Parquet files; losses go to FILE.losses.csv, and
    /// neither may exist.
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Ends after so many seconds; without it by Ctrl-C, or when the device is unplugged (`watch` waits for it).
    #[arg(long, value_name = "SECONDS")]
    seconds: Option<f64>,
}

/// Where the device is, and which one it has to be.
#[derive(Debug, Clone, clap::Args)]
struct LineArguments {
    /// Serial port: /dev/ttyUSB1, or a pseudo-terminal of a simulated board.
    #[arg(long, value_name = "PORT")]
    port: String,
    /// Bits per second of the line.
    #[arg(long, default_value_t = 3_000_000)]
    baud: u32,
    /// The scene that the device was built from; another device is refused.
    #[arg(long, value_name = "SCENE")]
    scene: Option<PathBuf>,
}

fn main() -> ExitCode {
    match run(&Arguments::parse().command) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(command: &Command) -> Result<(), Failed> {
    match command {
        Command::Ports => {
            for port in serialport::available_ports()? {
                println!("{}", port.port_name);
            }
            Ok(())
        }
        Command::Identify { line, scene_out } => {
            let (mut device, identity) = Line::from(line).open()?;
            println!("{}", description(&identity));
            if let Some(path) = scene_out {
                let text = device.scene_text(&identity)?;
                if scene_hash(&text) != identity.scene {
                    return Err("the scene's text in the device is not what its hash is of".into());
                }
                job::check_free(path)?;
                files::stage(path, |out| out.write_all(&text))?.publish()?;
                println!("{} bytes in {}", text.len(), printable_path(path));
            }
            Ok(())
        }
        Command::Watch { line, recording } => job::watch(&line.into(), recording),
        Command::Record { line, recording } => job::record(&line.into(), recording),
        Command::Samples { line, out, seconds, runs } => {
            samples::record(&line.into(), out, *seconds, *runs)
        }
        Command::Read { line, address } => {
            let (mut device, _) = Line::from(line).open()?;
            println!("{:#010x}", device.read(register(*address)?)?);
            Ok(())
        }
        Command::Write { line, address, data, force } => {
            let sensor = line.scene.as_ref().map(Sensor::load).transpose()?;
            let doubt = sensor.and_then(|sensor| sensor.interface().doubt(*address, *data));
            if let Some(doubt) = doubt.filter(|_| !force) {
                return Err(format!("{doubt}; --force writes it all the same").into());
            }
            let (mut device, _) = Line::from(line).open()?;
            Ok(device.write(register(*address)?, *data)?)
        }
    }
}

impl From<&LineArguments> for Line {
    fn from(arguments: &LineArguments) -> Line {
        let LineArguments { port, baud, scene } = arguments.clone();
        Line { port, baud, scene }
    }
}

fn description(identity: &Identity) -> String {
    let content = match identity.content {
        Content::Counts => "counts of phase steps",
        Content::Rows => "rows of a histogram",
        Content::Peaks => "peaks",
    };
    let content = match identity.accumulate {
        1 => content.to_owned(),
        scans => format!("{content}, each the sum of {scans} scans"),
    };
    let layout = identity.layout;
    format!(
        "scene {}: {content}, {} detector(s), {} steps from {}, {} at once, {} samples in a chip of {} ps; results of {} \
         bits ({} x {} + {})",
        hexadecimal(&identity.scene),
        identity.detectors,
        identity.steps,
        identity.first_step,
        identity.parallel,
        identity.samples_per_chip,
        f64::from(identity.chip_period_fs) / 1000.0,
        layout.result_bits(),
        layout.counts,
        layout.count_bits,
        layout.more_bits
    )
}

/// A number as a person writes it.
fn number(text: &str) -> Result<u32, String> {
    let parsed = match text.strip_prefix("0x") {
        Some(digits) => u32::from_str_radix(digits, 16),
        None => text.parse(),
    };
    parsed.map_err(|_| "write a number up to 0xffffffff, such as 16 or 0x10".to_owned())
}

/// A byte address of the bridge's 12 bits.
fn register(address: u32) -> Result<u16, String> {
    u16::try_from(address)
        .ok()
        .filter(|address| *address < 1 << 12 && address.is_multiple_of(4))
        .ok_or_else(|| {
            format!("{address:#x} is not a register: addresses are multiples of 4 below 0x1000")
        })
}
