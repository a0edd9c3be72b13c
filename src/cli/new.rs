//! `goldtof new`: a scene to start from.

use std::path::PathBuf;

use anyhow::bail;
use clap::Args;
use serde::Serialize;

use super::ending::Ending;
use super::output::Output;
use super::values::Like;
use crate::document::Body;
use crate::files;
use crate::printable::printable_path;

/// The short scene.
const SHORT: &str = include_str!("new/short.toml");

/// The text of a standard scene.
fn text_of(like: Like) -> &'static str {
    match like {
        Like::Quick => include_str!("../../scenes/quick.toml"),
        Like::PaperSingle => include_str!("../../scenes/paper-single.toml"),
        Like::PaperSquare => include_str!("../../scenes/paper-square.toml"),
        Like::PaperInterleaved => include_str!("../../scenes/paper-interleaved.toml"),
        Like::DualView => include_str!("../../scenes/dual-view.toml"),
        Like::Multipath => include_str!("../../scenes/multipath.toml"),
        Like::Histogram => include_str!("../../scenes/histogram.toml"),
        Like::Moving => include_str!("../../scenes/moving.toml"),
        Like::Image => include_str!("../../scenes/image.toml"),
        Like::ImageGlass => include_str!("../../scenes/image-glass.toml"),
        Like::ImageTwoSensors => include_str!("../../scenes/image-two-sensors.toml"),
    }
}

#[derive(Debug, Args)]
#[command(after_help = "Example: goldtof new my-sensor --like multipath")]
pub(super) struct NewArguments {
    /// Name of the scene: the file is NAME.toml, and NAME may have a path
    pub name: PathBuf,
    /// The standard scene to copy in place of a minimal one
    #[arg(long, value_name = "SCENE", value_enum)]
    pub like: Option<Like>,
}

/// The JSON of `goldtof new`.
#[derive(Serialize, schemars::JsonSchema)]
pub(super) struct Made {
    /// The scene's file.
    file: String,
}

impl Body for Made {
    const NAME: &'static str = "new";
}

pub(super) fn run(arguments: &NewArguments, output: &Output) -> anyhow::Result<Ending> {
    let path = path_of(arguments)?;
    let text = arguments.like.map_or(SHORT, text_of);
    // The schema lies beside the scenes of the source tree only.
    let lines = text.lines().filter(|line| !line.starts_with("#:schema"));
    let text: String = lines.map(|line| format!("{line}\n")).collect();
    if path.symlink_metadata().is_ok() {
        bail!(
            "{}: there is a file of that name already; choose another name, or remove it",
            printable_path(&path)
        );
    }
    files::write(&path, text.trim_start_matches('\n'))?;
    let shown = printable_path(&path);
    let text = format!("{shown}: try goldtof plan {shown}\n");
    output.answer(None, &Made { file: shown }, &text)?;
    Ok(Ending::Done)
}

/// Where the scene goes.
fn path_of(arguments: &NewArguments) -> anyhow::Result<PathBuf> {
    let mut path = arguments.name.clone();
    match path.file_name() {
        None => bail!("{}: this names no file; write for example my-sensor", printable_path(&path)),
        Some(name) if path.extension().is_none_or(|extension| extension != "toml") => {
            let mut name = name.to_owned();
            name.push(".toml");
            path.set_file_name(name);
        }
        Some(_) => {}
    }
    Ok(path)
}
