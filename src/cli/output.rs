//! Output: one JSON document to stdout, or text to stdout and stderr.

use std::cell::Cell;
use std::io::{self, BufWriter, IsTerminal as _, Write as _};
use std::path::Path;
use std::time::Duration;

use anyhow::Context as _;
use clap::ColorChoice;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use rustix::termios::tcgetwinsize;

use super::failure::Failure;
use super::provenance::typed_command;
use crate::document::{Body, Document};
use crate::files::{FileError, OutputFolder};
use crate::printable::{printable_json, printable_lines, printable_path};
use crate::scene::SceneReference;

/// Colour of the word "error", and back; as clap has it of a command line.
const BOLD_RED: (&str, &str) = ("\x1b[1m\x1b[31m", "\x1b[0m");

/// How a command that did its work ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Ending {
    /// Exit status 0.
    Done,
    /// Exit status 1: what was checked does not hold.
    DoesNotHold,
    /// Exit status 4: a score is below what was asked for.
    BelowThreshold,
}

impl Ending {
    /// That of a command with `--check`, or without it, whose scans bear their expectations out
    /// or do not.
    pub fn of_check(check: bool, holds: bool) -> Ending {
        if check && !holds { Ending::DoesNotHold } else { Ending::Done }
    }
}

/// The outputs of a command.
pub(super) struct CommandOutput {
    json: bool,
    quiet: bool,
}

impl CommandOutput {
    pub fn new(json: bool, quiet: bool) -> CommandOutput {
        CommandOutput { json, quiet }
    }

    /// The command's result: a document with `--json`, else `text`. `scene` goes into the
    /// document's head.
    pub fn answer<B: Body>(
        &self,
        scene: Option<SceneReference>,
        body: &B,
        text: &str,
    ) -> anyhow::Result<Ending> {
        let document = Document::new(body, typed_command(), None);
        self.answer_document(&Document { scene, ..document }, text)
    }

    /// [`CommandOutput::answer`] with a document that has its head.
    pub fn answer_document<B: Body>(
        &self,
        document: &Document<B>,
        text: &str,
    ) -> anyhow::Result<Ending> {
        let mut stdout = BufWriter::new(io::stdout().lock());
        let written = if self.json {
            // A sweep's document may be larger than the memory.
            let written = serde_json::to_writer_pretty(Printable(&mut stdout), document);
            written.map_err(io::Error::from).and_then(|()| writeln!(stdout))
        } else if self.quiet {
            Ok(())
        } else {
            write!(stdout, "{}", printable_lines(text))
        };
        match written.and_then(|()| stdout.flush()) {
            Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
                Err(error).context("cannot write to stdout")
            }
            // A broken pipe: the reader has seen enough.
            _ => Ok(Ending::Done),
        }
    }

    /// A remark on stderr.
    pub fn note(&self, text: &str) {
        if !self.quiet {
            to_stderr(text);
        }
    }

    /// Opens a folder for the command's files; waits while another run writes
    /// into it.
    pub fn folder(&self, path: &Path) -> Result<OutputFolder, FileError> {
        OutputFolder::open(path, |path| self.waits(path))
    }

    /// [`CommandOutput::folder`], if there is to be one.
    pub fn folder_if(&self, path: Option<&Path>) -> Result<Option<OutputFolder>, FileError> {
        path.map(|path| self.folder(path)).transpose()
    }

    /// Says which files of a folder were written.
    pub fn wrote(&self, folder: &OutputFolder, names: &[&str]) {
        for name in names {
            self.note(&format!("wrote {}", printable_path(&folder.join(name))));
        }
    }

    /// Reports that the folder is locked by another run.
    pub fn waits(&self, path: &Path) {
        self.note(&format!(
            "{}: another goldtof writes here; waiting for its end",
            printable_path(path)
        ));
    }

    /// A progress bar over the points of a sweep, on a terminal only.
    pub fn points(&self, total: usize) -> ProgressBar {
        let bar = ProgressBar::with_draw_target(Some(total as u64), self.target());
        let style = "sweep [{bar:40}] {percent}% {human_pos} of {human_len} points, {eta} left";
        if let Ok(style) = ProgressStyle::with_template(style) {
            bar.set_style(style.progress_chars("=> "));
        }
        bar
    }

    /// A progress bar, on a terminal only.
    pub fn bar(&self) -> Bar {
        Bar { bar: ProgressBar::with_draw_target(None, self.target()), counts: Cell::new(false) }
    }

    fn target(&self) -> ProgressDrawTarget {
        match self.quiet {
            true => ProgressDrawTarget::hidden(),
            false => ProgressDrawTarget::stderr(),
        }
    }

    /// An error, with its causes; with `--json` as the document on stdout, too.
    pub fn error(&self, error: &anyhow::Error, exit_status: u8) {
        let text = with_causes(error);
        let (on, off) = if is_coloured() { BOLD_RED } else { ("", "") };
        let told = printable_lines(&text);
        let _ = writeln!(io::stderr(), "{on}error:{off} {told}");
        if self.json {
            failure(&Failure::new(error, &text, exit_status));
        }
    }
}

/// Escapes what cannot be seen in the pieces of a JSON document, which end with characters.
struct Printable<W>(W);

impl<W: io::Write> io::Write for Printable<W> {
    fn write(&mut self, piece: &[u8]) -> io::Result<usize> {
        let shown = printable_json(&String::from_utf8_lossy(piece)).into_owned();
        self.0.write_all(shown.as_bytes()).map(|()| piece.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.flush()
    }
}

/// The progress of a command: a stage of unknown length, then clocks.
pub(super) struct Bar {
    bar: ProgressBar,
    counts: Cell<bool>,
}

impl Bar {
    /// Between two pictures of a stage.
    const TICK: Duration = Duration::from_millis(150);

    /// Names what is being done.
    pub fn stage(&self, what: &'static str) {
        self.show("{spinner} {msg} ({elapsed})", what);
        self.bar.enable_steady_tick(Bar::TICK);
    }

    /// `done` clocks `of` all are done. What was done before the first of them does
    /// not count for how long the others will take.
    pub fn clocks(&self, what: &'static str, done: u64, of: u64) {
        if !self.counts.replace(true) {
            self.bar.disable_steady_tick();
            self.bar.set_length(of);
            self.bar.reset();
            self.show(
                "{msg} [{wide_bar}] {percent}% {human_pos} of {human_len} clocks, {eta} left",
                what,
            );
        }
        self.bar.set_position(done);
    }

    /// Takes it off the screen.
    pub fn end(&self) {
        self.bar.finish_and_clear();
    }

    fn show(&self, template: &str, what: &'static str) {
        if let Ok(style) = ProgressStyle::with_template(template) {
            self.bar.set_style(style.progress_chars("=> "));
        }
        self.bar.set_message(what);
    }
}

/// Whether errors are coloured on stderr.
fn is_coloured() -> bool {
    io::stderr().is_terminal() && !no_colours()
}

/// Whether the user wants no colours (<https://no-color.org>) or the terminal shows none.
fn no_colours() -> bool {
    let is_unwanted = std::env::var_os("NO_COLOR").is_some_and(|value| !value.is_empty());
    let is_dumb = std::env::var_os("TERM").is_none_or(|term| term == "dumb");
    is_unwanted || is_dumb
}

/// The same rule for what clap writes, which would colour a dumb terminal where `CI` is set.
pub(super) fn clap_colours() -> ColorChoice {
    if no_colours() { ColorChoice::Never } else { ColorChoice::Auto }
}

/// Characters of a line of the terminal that stdout is; none if it is not a terminal.
/// `COLUMNS` wins where it is set.
pub(super) fn terminal_width() -> Option<usize> {
    let stdout = io::stdout();
    if !stdout.is_terminal() {
        return None;
    }
    let told = std::env::var("COLUMNS").ok().and_then(|text| text.parse().ok());
    let size = || tcgetwinsize(&stdout).ok().map(|size| usize::from(size.ws_col));
    told.or_else(size).filter(|&columns| columns > 0)
}

/// Writes the document of a failure to stdout; write errors are ignored.
pub(super) fn failure(failure: &Failure) {
    // Which scene it would have been of may be just what is wrong.
    let document = Document::new(failure, typed_command(), None);
    if let Ok(document) = serde_json::to_string_pretty(&document) {
        let _ = writeln!(io::stdout(), "{}", printable_json(&document));
    }
}

/// The error's words and those of its causes that it does not repeat itself.
pub(super) fn with_causes(error: &anyhow::Error) -> String {
    error.chain().fold(String::new(), |text, cause| {
        let cause = cause.to_string();
        match text.as_str() {
            "" => cause,
            _ if text.contains(&cause) => text,
            _ => format!("{text}: {cause}"),
        }
    })
}

/// Writes to stderr, control characters escaped.
/// A closed stderr does not end the program.
pub(super) fn to_stderr(text: &str) {
    let _ = writeln!(io::stderr(), "{}", printable_lines(text));
}

#[cfg(test)]
mod tests {
    use anyhow::Context as _;

    use super::*;

    #[test]
    fn a_cause_is_told_once() {
        let cause = || io::Error::other("the reason");
        let repeated =
            FileError { path: "a".into(), problem: "cannot write the file", source: cause() };
        let text = with_causes(&repeated.into());
        assert_eq!(text, "a: cannot write the file: the reason");
        let told_by_the_chain = Err::<(), _>(cause()).context("no stdout").unwrap_err();
        assert_eq!(with_causes(&told_by_the_chain), "no stdout: the reason");
    }
}
