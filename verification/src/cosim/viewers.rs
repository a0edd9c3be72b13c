//! What wave viewers show of the waveforms first: a save file for GTKWave, a command file for
//! Surfer, and one for Questa and ModelSim.

use std::fmt::Write as _;
use std::fs::{self, File};
use std::io::Read as _;
use std::path::{Path, PathBuf};

use super::wave::{ANY, DIFFERS, DUT, MODEL, ROOT};
use crate::scan::Timescale;
use crate::sensor::layout::{Field, Layout};

/// What GTKWave's file begins with, when it is ours to replace: GTKWave writes another
/// line when it saves.
const GTKWAVE_MARK: &str = "[*] Made by goldtof";
/// What Surfer's file begins with, and Questa's.
const SURFER_MARK: &str = "# Made by goldtof";

/// What a viewer's file ends with, how ours begins, and its text.
type Viewer = (&'static str, &'static str, fn(&Layout, Timescale, u64) -> String);

const VIEWERS: [Viewer; 3] =
    [("gtkw", GTKWAVE_MARK, gtkwave), ("sucl", SURFER_MARK, surfer), ("do", SURFER_MARK, questa)];

/// Clocks on the screen.
const CLOCKS_SHOWN: u64 = 40;
/// Width of GTKWave's waves for which that is so, in frames of 200 pixels.
const FRAMES: f64 = 4.5;

/// GTKWave's flags of a trace: bits, or hexadecimal digits, at the right.
const BITS: &str = "@28";
const DIGITS: &str = "@22";
/// A line of text between traces.
const LABEL: &str = "@200";

/// A file beside the waveforms.
pub(super) struct ViewerFile {
    pub(super) path: PathBuf,
    pub(super) text: String,
}

/// The views of waveforms in `path` that show the clock `shown`. One is left out where
/// something stands in its place that is not ours: a view that the user has changed and
/// saved, say.
pub(super) fn views(path: &Path, layout: &Layout, time: Timescale, shown: u64) -> Vec<ViewerFile> {
    let is_file = fs::metadata(path).map_or(true, |found| found.is_file());
    VIEWERS
        .into_iter()
        .map(|(ending, mark, text)| (path.with_extension(ending), mark, text))
        .filter(|(view, mark, _)| is_file && view != path && is_free(view, mark))
        .map(|(path, _, text)| ViewerFile { path, text: text(layout, time, shown) })
        .collect()
}

/// The names of views in `folder` that an earlier run has written of the waveforms
/// `name`.
pub fn views_beside(name: &Path, folder: &Path) -> Vec<String> {
    VIEWERS
        .into_iter()
        .map(|(ending, mark, _)| (name.with_extension(ending), mark))
        .filter(|(view, mark)| is_ours(&folder.join(view), mark))
        .filter_map(|(view, _)| Some(view.to_str()?.to_owned()))
        .collect()
}

/// Whether nothing stands there, or what an earlier run has written.
fn is_free(path: &Path, mark: &str) -> bool {
    let found = fs::symlink_metadata(path);
    let is_nothing = found.is_err_and(|error| error.kind() == std::io::ErrorKind::NotFound);
    is_nothing || is_ours(path, mark)
}

fn is_ours(path: &Path, mark: &str) -> bool {
    let mut start = vec![0; mark.len()];
    fs::symlink_metadata(path).is_ok_and(|found| found.is_file())
        && File::open(path).is_ok_and(|mut file| file.read_exact(&mut start).is_ok())
        && start == mark.as_bytes()
}

/// Signals in the order in which they are shown: those without a scope of a side are of
/// both, a label stands over each group.
fn groups(layout: &Layout) -> Vec<(&'static str, Vec<(&'static str, &Field)>)> {
    let inputs = layout.inputs.fields.iter().map(|field| (DUT, field));
    let outputs = layout.outputs.fields.iter();
    vec![
        ("inputs", inputs.collect()),
        ("outputs", outputs.flat_map(|field| [DUT, MODEL].map(|side| (side, field))).collect()),
    ]
}

fn gtkwave(layout: &Layout, time: Timescale, shown: u64) -> String {
    let at = time.after_halves(2 * shown + 1);
    let from = time.after_halves(2 * shown.saturating_sub(CLOCKS_SHOWN / 2));
    // A frame is 2^-zoom wide.
    let zoom = -((CLOCKS_SHOWN * time.period()) as f64 / FRAMES).log2();
    let mut text = format!(
        "{GTKWAVE_MARK} for GTKWave: gtkwave FILE.vcd FILE.gtkw\n[timestart] {from}\n\
         *{zoom:.6} {at} -1\n[size] 1200 700\n[pos] -1 -1\n[treeopen] {ROOT}.\n\
         [signals_width] 200\n[sst_expanded] 0\n{BITS}\n{ROOT}.{}\n+{{{DIFFERS}}} {ROOT}.{DIFFERS}.{ANY}\n",
        Layout::CLOCK
    );
    for (label, signals) in groups(layout) {
        let _ = writeln!(text, "{LABEL}\n-{label}");
        for (scope, field) in signals {
            let (name, width) = (&field.port.name, field.port.width);
            let (flags, range) = match width {
                1 => (BITS, String::new()),
                _ => (DIGITS, format!("[{}:0]", width - 1)),
            };
            // The name that is shown, without which the sides look the same.
            let shown = format!("+{{{scope}:{name}}}");
            let _ = writeln!(text, "{flags}\n{shown} {ROOT}.{scope}.{name}{range}");
        }
    }
    text
}

fn surfer(layout: &Layout, time: Timescale, shown: u64) -> String {
    let mut text = format!(
        "{SURFER_MARK} for Surfer: surfer --command-file FILE.sucl FILE.vcd\n\
         variable_add {ROOT}.{}\nvariable_add {ROOT}.{DIFFERS}.{ANY}\n",
        Layout::CLOCK
    );
    for (label, signals) in groups(layout) {
        let _ = writeln!(text, "divider_add {label}");
        for (scope, field) in signals {
            let _ = writeln!(text, "variable_add {ROOT}.{scope}.{}", field.port.name);
        }
    }
    let at = time.after_halves(2 * shown + 1);
    text + &format!("cursor_set {at}\nzoom_fit\ngoto_cursor\n")
}

fn questa(layout: &Layout, time: Timescale, shown: u64) -> String {
    let place = |scope: &str, name: &str| format!("/{ROOT}/{scope}/{name}");
    let mut text = format!(
        "{SURFER_MARK} for Questa and ModelSim: vcd2wlf FILE.vcd FILE.wlf; vsim -view FILE.wlf -do FILE.do\n\
         add wave /{ROOT}/{}\nadd wave -label {DIFFERS} {}\n",
        Layout::CLOCK,
        place(DIFFERS, ANY)
    );
    for (label, signals) in groups(layout) {
        let _ = writeln!(text, "add wave -divider {label}");
        for (scope, field) in signals {
            let (name, width) = (&field.port.name, field.port.width);
            let radix = if width == 1 { "" } else { "-radix hexadecimal " };
            let _ = writeln!(text, "add wave {radix}-label {scope}:{name} {}", place(scope, name));
        }
    }
    let edge = |halves: u64| time.after_halves(halves);
    let (at, half) = (2 * shown + 1, CLOCKS_SHOWN);
    let (from, until) = (edge(at.saturating_sub(half)), edge(at + half));
    text + &format!(
        "wave cursor add -time {} -name shown\nwave zoom range {from} {until}\n",
        edge(at)
    )
}
