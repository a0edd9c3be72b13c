//! `goldtof new`: a scene to start from.

use anyhow::bail;

use super::prelude::*;
use crate::files;

/// The short scene.
const SHORT: &str = include_str!("new/short.toml");

/// Declares the standard scenes, each by its file.
macro_rules! scenes {
    ($($what:literal $name:ident $file:literal;)*) => {
        /// The standard scenes.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
        pub(super) enum Like { $(#[doc = $what] #[value(name = $file)] $name,)* }

        impl Like {
            /// Its text.
            fn text(self) -> &'static str {
                match self {
                    $(Like::$name => include_str!(concat!("../../scenes/", $file, ".toml")),)*
                }
            }
        }
    };
}

scenes! {
    "The whole way in a second: degree 5" Quick "quick";
    "One sensor with the parameters of Table I, degree 11" PaperSingle "paper-single";
    "The same with square-wave modulation" PaperSquare "paper-square";
    "The same with the code interleaved once" PaperInterleaved "paper-interleaved";
    "Two lasers with two codes of one Gold set" DualView "dual-view";
    "One code over two paths, 1.5 chips apart" Multipath "multipath";
    "A histogram of arrival times in place of up/down counts" Histogram "histogram";
    "A pixel of four SPADs, of which two have to fire" Macropixel "macropixel";
    "A target that drifts away and fluctuates" Moving "moving";
    "An array of 256 x 192 pixels in a room" Image "image";
    "A pane in front of a wall, seen by an array" ImageGlass "image-glass";
    "An array beside another sensor's laser" ImageTwoSensors "image-two-sensors";
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

impl Command for NewArguments {
    fn run(&self, _: u64, output: &CommandOutput) -> anyhow::Result<Ending> {
        let path = path_of(self)?;
        let text = self.like.map_or(SHORT, Like::text);
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
        output.answer(None, &Made { file: shown }, &text)
    }
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
