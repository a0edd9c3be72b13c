//! `goldtof-device`: reads a sensor at a serial port.

use std::error::Error;
use std::fs::{self, File, OpenOptions};
use std::io;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use clap::{Parser, Subcommand};
use goldtof_device::{Device, DeviceError, Recorder, Watch};
use goldtof_system::digest::sha256;
use goldtof_system::files;
use goldtof_system::printable::printable_path;
use goldtof_wire::{Content, Event, Frame, Identity};
use serialport::SerialPort;

/// What ended the program, in words.
type Failed = Box<dyn Error>;

/// Reads a sensor at a serial port: what it is, its counts, its registers.
#[derive(Debug, Parser)]
#[command(
    name = "goldtof-device",
    version,
    after_help = "Example:\n  goldtof-device record --port /dev/ttyUSB1 --scene scenes/quick.toml --out counts.csv --seconds 10"
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
        line: Line,
        /// Takes the scene from the device, whose scene has hardware.scene_text, into this file, which may
        /// not exist.
        #[arg(long, value_name = "FILE")]
        scene_out: Option<PathBuf>,
    },
    /// Shows how the measurement goes, and writes counts as CSV.
    Record {
        #[command(flatten)]
        line: Line,
        /// File for the counts; losses go to FILE.losses.csv, and neither may exist.
        #[arg(long, value_name = "FILE")]
        out: Option<PathBuf>,
        /// Ends after so many seconds; without it, when the device is unplugged or by Ctrl-C.
        #[arg(long, value_name = "SECONDS")]
        seconds: Option<f64>,
    },
    /// Reads a register.
    Read {
        #[command(flatten)]
        line: Line,
        /// Byte address, `0x` for hexadecimal: 0x010.
        #[arg(value_parser = number)]
        address: u32,
    },
    /// Writes a register.
    Write {
        #[command(flatten)]
        line: Line,
        /// Byte address, `0x` for hexadecimal: 0x010.
        #[arg(value_parser = number)]
        address: u32,
        /// What to write: 0x1 or 1.
        #[arg(value_parser = number)]
        data: u32,
    },
}

/// Where the device is, and which one it has to be.
#[derive(Debug, clap::Args)]
struct Line {
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
            let (mut device, identity) = line.device()?;
            println!("{}", description(&identity));
            if let Some(path) = scene_out {
                let text = device.scene_text(&identity)?;
                if hash(&text)? != identity.scene {
                    return Err("the scene's text in the device is not what its hash is of".into());
                }
                drop(fresh(path)?);
                files::stage(path, |out| out.write_all(&text))?.publish()?;
                println!("{} bytes in {}", text.len(), printable_path(path));
            }
            Ok(())
        }
        Command::Record { line, out, seconds } => record(line, out.as_deref(), *seconds),
        Command::Read { line, address } => {
            let (mut device, _) = line.device()?;
            println!("{:#010x}", device.read(register(*address)?)?);
            Ok(())
        }
        Command::Write { line, address, data } => {
            let (mut device, _) = line.device()?;
            Ok(device.write(register(*address)?, *data)?)
        }
    }
}

impl Line {
    /// The device, which has said what it is.
    fn device(&self) -> Result<(Device<Box<dyn SerialPort>>, Identity), Failed> {
        let expected = self.scene.as_deref().map(scene_hash).transpose()?;
        let port = serialport::new(&self.port, self.baud)
            .timeout(Duration::from_millis(100))
            .open()
            .map_err(|error| format!("{}: {error}", self.port))?;
        let mut device = Device::new(port);
        let identity = device.identify()?;
        if let (Some(expected), Some(scene)) = (expected, &self.scene)
            && expected != identity.scene
        {
            return Err(format!(
                "the device was built from another scene: its hash begins with {}, and that of {} with {}. Load the \
                 bitstream of this scene, or name the scene of this bitstream",
                hexadecimal(&identity.scene),
                printable_path(scene),
                hexadecimal(&expected)
            )
            .into());
        }
        Ok((device, identity))
    }
}

/// The first eight bytes of the SHA-256 of a scene's text.
fn scene_hash(path: &Path) -> Result<[u8; 8], Failed> {
    hash(&fs::read(path).map_err(|error| format!("{}: {error}", printable_path(path)))?)
}

/// The same of a text.
fn hash(text: &[u8]) -> Result<[u8; 8], Failed> {
    let digits = sha256(text);
    let mut hash = [0; 8];
    for (byte, k) in hash.iter_mut().zip((0..).step_by(2)) {
        *byte = u8::from_str_radix(&digits[k..k + 2], 16)?;
    }
    Ok(hash)
}

/// Shows and writes results until the time is over or the device is gone.
fn record(line: &Line, out: Option<&Path>, seconds: Option<f64>) -> Result<(), Failed> {
    let (mut device, identity) = line.device()?;
    println!("{}", description(&identity));
    let recorder = out.map(|path| {
        let losses = path.with_added_extension("losses.csv");
        let recorder = Recorder::new(fresh(path)?, fresh(&losses)?, identity)?;
        Ok::<Recorder<File>, Failed>(recorder)
    });
    let mut recorder = recorder.transpose()?;
    let mut watch = Watch::new(identity);
    let began = Instant::now();
    let ended = loop {
        if seconds.is_some_and(|seconds| began.elapsed().as_secs_f64() >= seconds) {
            break Ok(());
        }
        let event = match device.next_event() {
            Ok(event) => event,
            Err(error) => break Err(error),
        };
        let time_s =
            SystemTime::now().duration_since(UNIX_EPOCH).map_or(0.0, |time| time.as_secs_f64());
        match event {
            Some(Event::Frame(Frame::Results(frame))) => {
                watch.results(&frame);
                if let Some(recorder) = &mut recorder {
                    recorder.results(&frame, time_s)?;
                }
            }
            Some(Event::Lost(loss)) => {
                if let Some(recorder) = &mut recorder {
                    recorder.loss(&loss, time_s)?;
                }
            }
            // Answers to requests that were sent twice.
            Some(Event::Frame(_)) | None => {}
        }
        if let Some(report) = watch.report(Duration::from_secs(1), device.tally()) {
            println!("{report}");
        }
    };
    if let Some(report) = watch.report(Duration::ZERO, device.tally()) {
        println!("{report}");
    }
    if let (Some(recorder), Some(path)) = (&recorder, out) {
        println!("{} results in {}", recorder.written(), printable_path(path));
    }
    ended.map_err(|error: DeviceError| error.into())
}

/// A file that is not there yet.
fn fresh(path: &Path) -> Result<File, Failed> {
    OpenOptions::new().write(true).create_new(true).open(path).map_err(|error| {
        let advice = match error.kind() {
            io::ErrorKind::AlreadyExists => "; name another file, or remove it",
            _ => "",
        };
        format!("{}: {error}{advice}", printable_path(path)).into()
    })
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

fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
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
            format!("{address:#x} is no register: addresses are multiples of 4 below 0x1000")
        })
}
