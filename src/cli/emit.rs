//! `goldtof emit`.

use std::path::{Path, PathBuf};

use clap::Args;

use super::common::SceneArgument;
use super::ending::Ending;
use super::output::Output;
use super::warnings::warn;
use crate::deliver::testbenches::{self, BIND, COCOTB};
use crate::deliver::{self, Emission, EmittedFile};
use crate::door::{EmitOptions, Jobs as _};
use crate::printable::printable_path;
use crate::sensor::Sensor;

#[derive(Debug, Args)]
#[command(after_help = "Example: goldtof emit scenes/quick.toml --out rtl")]
pub(super) struct EmitArguments {
    #[command(flatten)]
    pub scene: SceneArgument,
    /// Folder for the Verilog and manifest.json; made when missing, for example
    /// --out rtl
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    #[command(flatten)]
    pub options: EmitOptions,
    /// Also a testbench for cocotb, with goldtof's scoreboard, in the folder cocotb: `make` there runs it
    #[arg(long)]
    pub cocotb: bool,
    /// Also a SystemVerilog file that binds the scoreboard of the C library, and rules of an AXI4-Stream,
    /// to the design or to your own, in the folder bind
    #[arg(long)]
    pub bind: bool,
}

pub(super) fn run(arguments: &EmitArguments, output: &mut Output) -> anyhow::Result<Ending> {
    // Once: what stands beside the design is of the same scene.
    let scene = arguments.scene.read()?;
    let sensor = Sensor::new(&scene.scene()?);
    warn(&sensor, output);
    let mut made_by = command_line(&arguments.scene);
    if let Some(prefix) = &arguments.options.prefix {
        made_by += &format!(" --prefix {prefix}");
    }
    let emission = sensor.emit(&EmitOptions { made_by, ..arguments.options.clone() })?;
    let folder = output.folder(&arguments.out)?;
    deliver::write_into(&emission, &folder)?;
    let mut text = text(&emission, &arguments.out);
    let prefix = arguments.options.prefix.clone().unwrap_or_default();
    let cocotb = || (COCOTB, testbenches::cocotb(&sensor, &emission, &scene));
    let bind = || (BIND, testbenches::bind(&emission, &prefix, &scene));
    let more = [arguments.cocotb.then(cocotb), arguments.bind.then(bind)];
    for (name, files) in more.into_iter().flatten() {
        let beside = folder.subfolder(name, |path| output.waits(path))?;
        let stage = |file: &EmittedFile| {
            beside.stage(&file.name, |out| out.write_all(file.text.as_bytes()))
        };
        beside.publish(files.iter().map(stage).collect::<Result<_, _>>()?)?;
        text += &format!("{} files in {}\n", files.len(), printable_path(beside.path()));
    }
    output.answer_document(&emission.document(), &text)?;
    Ok(Ending::Done)
}

/// The command that the headers of emitted files name. Only the scene's file
/// name is in it, so that emission does not depend on where the scene lies.
pub(super) fn command_line(scene: &SceneArgument) -> String {
    format!("goldtof emit {}", scene.shown())
}

/// The emission in words.
pub(super) fn text(emission: &Emission, folder: &Path) -> String {
    let mut text = format!(
        "{} Verilog files and manifest.json in {}, top module {}, {:.3} MHz\n",
        emission.files.len(),
        printable_path(folder),
        emission.top,
        emission.clock_hz / 1e6,
    );
    for left_out in &emission.left_out {
        text += &format!("left out: {} ({})\n", left_out.part, left_out.reason);
    }
    text
}
