//! `goldtof emit`.

use std::path::Path;

use super::arguments::{EmitArguments, OwnArguments, SceneArgument};
use super::ending::Ending;
use super::output::Output;
use super::warnings::warn_of_far_paths;
use crate::deliver;
use crate::deliver::Emission;
use crate::door::Rtl;
use crate::printable::printable_path;
use crate::sensor::Sensor;

pub(super) fn run(arguments: &EmitArguments, output: &mut Output) -> anyhow::Result<Ending> {
    let sensor = Sensor::new(&arguments.scene.load()?);
    let mut command = command_line(&arguments.scene);
    if let Some(prefix) = &arguments.prefix {
        command += &format!(" --prefix {prefix}");
    }
    let prefix = arguments.prefix.clone().unwrap_or_default();
    warn_of_far_paths(&sensor, output);
    let emission = deliver::emit_prefixed(&sensor, &prefix, &command)?;
    deliver::write_into(&emission, &output.folder(&arguments.out)?)?;
    output.answer_document(&emission.document(), &text(&emission, &arguments.out))?;
    Ok(Ending::Done)
}

/// The command that the headers of emitted files name. Only the scene's file
/// name is in it, so that emission does not depend on where the scene lies.
pub(super) fn command_line(scene: &SceneArgument) -> String {
    format!("goldtof emit {}", scene.shown())
}

/// The user's own Verilog, or else what is emitted for the scene.
pub(super) fn rtl(own: &OwnArguments, scene: &SceneArgument) -> Rtl {
    own.rtl().map_or_else(|| Rtl::Emitted { made_by: command_line(scene) }, Rtl::Own)
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
