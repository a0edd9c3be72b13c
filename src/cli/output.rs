//! Who prints what: JSON to stdout, people's words to stdout or stderr.

use std::io::{self, Write as _};

use anyhow::Context as _;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde::Serialize;

/// The outputs of a command.
pub(super) struct Output {
    json: bool,
    quiet: bool,
}

impl Output {
    pub fn new(json: bool, quiet: bool) -> Output {
        Output { json, quiet }
    }

    /// The command's answer: `value` with `--json`, else `text`.
    pub fn answer(&self, value: &impl Serialize, text: &str) -> anyhow::Result<()> {
        let mut stdout = io::stdout().lock();
        let written = if self.json {
            let document = serde_json::to_string_pretty(value).context("cannot make JSON")?;
            writeln!(stdout, "{document}")
        } else if self.quiet {
            Ok(())
        } else {
            write!(stdout, "{text}")
        };
        match written.and_then(|()| stdout.flush()) {
            // A reader that has seen enough is no error.
            Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
            other => other.context("cannot write to stdout"),
        }
    }

    /// A remark on the way, for people.
    pub fn note(&self, text: &str) {
        if !self.quiet {
            eprintln!("{text}");
        }
    }

    /// A progress bar over `total` clocks, drawn only for people who can see it.
    pub fn progress(&self, what: &'static str) -> ProgressBar {
        let bar = ProgressBar::with_draw_target(
            None,
            if self.quiet {
                ProgressDrawTarget::hidden()
            } else {
                ProgressDrawTarget::stderr()
            },
        );
        let style = "{msg} [{bar:40}] {percent}% {human_pos} of {human_len} clocks, {eta} left";
        if let Ok(style) = ProgressStyle::with_template(style) {
            bar.set_style(style.progress_chars("=> "));
        }
        bar.set_message(what);
        bar
    }

    /// An error, with its causes.
    pub fn error(&self, error: &anyhow::Error) {
        eprintln!("error: {error:#}");
    }
}
