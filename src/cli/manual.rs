//! `goldtof completions` and `goldtof man`.

use std::io::{self, Write as _};
use std::path::PathBuf;

use anyhow::Context as _;
use clap::{Args, CommandFactory as _};
use serde::Serialize;

use super::arguments::Cli;
use super::ending::Ending;
use super::output::Output;
use crate::document::Body;
use crate::printable::printable_path;

#[derive(Debug, Args)]
#[command(after_help = "Example: goldtof completions bash > \
    ~/.local/share/bash-completion/completions/goldtof")]
pub(super) struct CompletionsArguments {
    /// Shell
    #[arg(value_enum)]
    pub shell: clap_complete::Shell,
}

#[derive(Debug, Args)]
#[command(after_help = "Example: goldtof man --out ~/.local/share/man/man1")]
pub(super) struct ManArguments {
    /// Folder for goldtof.1 and a page for each command; made when missing, for example
    /// --out man
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
}

/// The JSON of `goldtof man`.
#[derive(Serialize, schemars::JsonSchema)]
pub(super) struct Pages {
    /// Names of the pages' files, in the folder that was asked for.
    files: Vec<String>,
}

impl Body for Pages {
    const NAME: &'static str = "man";
}

pub(super) fn completions(arguments: &CompletionsArguments) -> anyhow::Result<Ending> {
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut Cli::command(), "goldtof", &mut script);
    match io::stdout().lock().write_all(&script) {
        // A broken pipe: the reader has seen enough.
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            Err(error).context("cannot write to stdout")
        }
        _ => Ok(Ending::Done),
    }
}

pub(super) fn pages(arguments: &ManArguments, output: &Output) -> anyhow::Result<Ending> {
    let folder = output.folder(&arguments.out)?;
    let mut command = Cli::command();
    command.build();
    let subcommands = command.get_subcommands().filter(|sub| sub.get_name() != "help");
    let mut names = Vec::new();
    for page in std::iter::once(&command).chain(subcommands) {
        let name = match page.get_name() {
            "goldtof" => "goldtof".to_owned(),
            name => format!("goldtof-{name}"),
        };
        let mut text = Vec::new();
        clap_mangen::Man::new(page.clone()).title(name.as_str()).render(&mut text)?;
        let file = format!("{name}.1");
        folder.write(&file, &String::from_utf8_lossy(&text))?;
        names.push(file);
    }
    let text = format!("{} pages in {}\n", names.len(), printable_path(folder.path()));
    output.answer(None, &Pages { files: names }, &text)?;
    Ok(Ending::Done)
}
