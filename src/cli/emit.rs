//! `goldtof emit`.

use super::prelude::*;
use crate::deliver::board::{BOARD, Board, BoardPlan, BoardProject, PinChoice};
use crate::deliver::testbenches::{self, BIND, COCOTB};
use crate::deliver::{self, Emission, EmittedFile};
use crate::door::{EmitOptions, Jobs as _};
use crate::printable::shell_word;
use crate::scene::SceneText;

#[derive(Debug, Args)]
#[command(after_help = "Example: goldtof emit scenes/quick.toml --out rtl")]
pub(super) struct EmitArguments {
    #[command(flatten)]
    pub scene: SceneArgument,
    /// Folder for the Verilog and manifest.json; created if missing, for example
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
    /// Also the project of a board up to its bitstream, in the folder board, for example --board ulx3s-12f. The
    /// manifest's scene then has the chip period that the board's PLL makes
    #[arg(long, value_name = "BOARD", value_parser = Board::named, conflicts_with = "prefix")]
    pub board: Option<&'static Board>,
    /// Another pin for a detector or laser of the board; may be repeated: --pin 'i_detector[0]=H4'
    #[arg(long = "pin", value_name = "PORT=PIN", requires = "board")]
    pub pins: Vec<PinChoice>,
}

impl EmitArguments {
    /// The board and its pins, as a command line has them.
    fn board_words(&self) -> Vec<String> {
        let board = self.board.map(|board| format!("--board {}", board.name));
        let pins = self.pins.iter().map(|pin| {
            format!("--pin {}", shell_word(&printable(&format!("{}={}", pin.port, pin.site))))
        });
        board.into_iter().chain(pins).collect()
    }
}

impl Command for EmitArguments {
    fn run(&self, _: u64, output: &CommandOutput) -> anyhow::Result<Ending> {
        // Once: what stands beside the design is of the same scene.
        let scene = self.scene.read()?;
        let mut made_by = command_line(&self.scene);
        if let Some(prefix) = &self.options.prefix {
            made_by += &format!(" --prefix {prefix}");
        }
        for word in self.board_words() {
            made_by += &format!(" {word}");
        }
        let options = EmitOptions { made_by, ..self.options.clone() };
        let (scene, sensor, emission) = match self.board {
            Some(board) => on_board(scene, board, &self.pins, &options)?,
            None => {
                let sensor = Sensor::new(&scene.scene()?);
                let emission = sensor.emit(&options)?;
                (scene, sensor, emission)
            }
        };
        warn(&sensor, output);
        let folder = output.folder(&self.out)?;
        deliver::write_into(&emission, &folder)?;
        let mut text = text(&emission, &self.out);
        let prefix = self.options.prefix.clone().unwrap_or_default();
        let cocotb = || (COCOTB, testbenches::cocotb(&sensor, &emission, &scene));
        let bind = || (BIND, testbenches::bind(&emission, &prefix, &scene));
        let more = [self.cocotb.then(cocotb), self.bind.then(bind)];
        for (name, files) in more.into_iter().flatten() {
            let beside = folder.subfolder(name, |path| output.waits(path))?;
            let stage = |file: &EmittedFile| {
                beside.stage(&file.name, |out| out.write_all(file.text.as_bytes()))
            };
            beside.publish(files.iter().map(stage).collect::<Result<_, _>>()?)?;
            text += &format!("{} files in {}\n", files.len(), printable_path(beside.path()));
        }
        output.answer_document(&emission.document(), &text)
    }
}

/// The design on a board: the scene has the chip period that the board's PLL makes.
pub(super) fn on_board(
    scene: SceneText,
    board: &'static Board,
    pins: &[PinChoice],
    options: &EmitOptions,
) -> anyhow::Result<(SceneText, Sensor, Emission)> {
    let plan = BoardPlan::of(&Sensor::new(&scene.scene()?), board, pins)?;
    let scene = plan.achieved(scene);
    let sensor = Sensor::new(&scene.scene()?);
    let mut emission = sensor.emit(options)?;
    emission.board = Some(plan.project(&sensor, &emission, &scene)?);
    Ok((scene, sensor, emission))
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
    if let Some(board) = &emission.board {
        text += &board_text(board, folder);
    }
    for left_out in &emission.left_out {
        text += &format!("left out: {} ({})\n", left_out.part, left_out.reason);
    }
    text
}

/// A board's project in words.
fn board_text(board: &BoardProject, folder: &Path) -> String {
    let mut text = format!(
        "{} files of {} in {}: chip of {} ns ({} ns asked for), {} Mbaud, {:.0} % of them needed\n",
        board.files.len(),
        board.name,
        printable_path(&folder.join(BOARD)),
        (board.chip_period_ps * 1e3).round() / 1e6,
        (board.asked_chip_period_ps * 1e3).round() / 1e6,
        (board.uart.baud() / 1e4).round() / 1e2,
        board.line_use_fraction * 1e2,
    );
    for pin in &board.pins {
        text += &format!("  {} at {} ({})\n", pin.port, pin.site, pin.label);
    }
    text
}
