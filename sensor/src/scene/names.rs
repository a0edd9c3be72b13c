//! Names by which one table of a scene refers to another.

use super::reader::Section;
use super::wording::{alternatives, nearest, quoted};
use crate::printable::{is_unprintable, printable};

/// Names to which other tables refer, in the order of the file.
pub(super) struct TableNames {
    /// What they name, for messages.
    kind: &'static str,
    names: Vec<String>,
}

impl TableNames {
    /// Reads the `name` of each table, and reports missing and repeated ones.
    pub(super) fn read(kind: &'static str, sections: &[Section]) -> TableNames {
        let mut names: Vec<String> = Vec::new();
        for section in sections {
            let example = format!("my-{kind}");
            section.require("name", &format!("\"{example}\""));
            let given = section.string("name", &example);
            let name = given.unwrap_or_default();
            if name.contains(is_unprintable) {
                let message = format!(
                    "\"{}\" has characters that cannot be seen; a {kind}'s name is one line of \
                     printable text, for example \"{example}\"",
                    printable(name)
                );
                section.report("name", &message);
            }
            if given.is_some() && name.is_empty() {
                let message = format!(
                    "a {kind} needs a name that is not empty; write for example \"{example}\""
                );
                section.report("name", &message);
            } else if !name.is_empty() && names.iter().any(|other| other == name) {
                let message =
                    format!("\"{name}\" already names another {kind}; choose another name");
                section.report("name", &message);
            }
            names.push(name.to_owned());
        }
        TableNames { kind, names }
    }

    /// Index of the table that `key` of `section` refers to.
    pub(super) fn resolve(&self, section: &Section, key: &'static str) -> Option<usize> {
        let names: Vec<&str> = self.names.iter().map(String::as_str).collect();
        let example = names.first().unwrap_or(&self.kind);
        section.require(key, &format!("\"{example}\""));
        let wanted = section.string(key, example)?;
        let index = names.iter().position(|name| *name == wanted);
        // A name that could not be read may be the one that is wanted.
        if index.is_none() && !names.contains(&"") {
            let advice = match nearest(wanted, &names) {
                Some(nearest) => format!("did you mean \"{nearest}\"?"),
                None => format!("there is {}", alternatives(&quoted(&names))),
            };
            section.report(key, &format!("no {} is named \"{wanted}\"; {advice}", self.kind));
        }
        index
    }
}
