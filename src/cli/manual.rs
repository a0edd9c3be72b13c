//! `goldtof completions` and `goldtof man`.

use clap::CommandFactory as _;

use super::arguments::{Cli, CompletionsArguments, ManArguments};
use super::prelude::*;

/// The JSON of `goldtof completions`.
#[derive(Serialize, schemars::JsonSchema)]
pub(super) struct Completions {
    /// The shell's name.
    shell: String,
    /// What the shell has to read.
    script: String,
}

/// The JSON of `goldtof man`.
#[derive(Serialize, schemars::JsonSchema)]
pub(super) struct Pages {
    /// Names of the pages' files, in the folder that was asked for.
    files: Vec<String>,
}

impl Command for CompletionsArguments {
    fn run(&self, _: u64, output: &CommandOutput) -> anyhow::Result<Ending> {
        let mut script = Vec::new();
        clap_complete::generate(self.shell, &mut Cli::command(), "goldtof", &mut script);
        let script = String::from_utf8(script)?;
        let document = Completions { shell: self.shell.to_string(), script };
        output.answer(None, &document, &document.script)
    }
}

impl Command for ManArguments {
    fn run(&self, _: u64, output: &CommandOutput) -> anyhow::Result<Ending> {
        let folder = output.folder(&self.out)?;
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
        output.answer(None, &Pages { files: names }, &text)
    }
}
