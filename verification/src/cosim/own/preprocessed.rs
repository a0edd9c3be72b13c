//! One text of a design, as Verilator's preprocessor writes it.

use std::collections::BTreeMap;
use std::path::PathBuf;

use super::roots::Roots;
use crate::cosim::source::RTL;

/// A design without macros and includes.
pub(super) struct Preprocessed {
    /// Its text; `line directives name the files that it is from.
    pub(super) text: String,
    /// The files' names in these directives, and the files.
    pub(super) names: BTreeMap<String, PathBuf>,
    /// What was included.
    pub(super) included: Vec<Included>,
}

/// A file that another one includes.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Included {
    pub(super) file: PathBuf,
    pub(super) by: PathBuf,
}

/// Makes one text of what `verilator -E` wrote.
///
/// Verilator lets every file begin with implicit nets, whatever the one before it said;
/// in one text that has to be said. Files get names without folders, as those of a build
/// have.
pub(super) fn joined(written: &str, roots: &Roots) -> Preprocessed {
    let mut made = Preprocessed {
        text: String::with_capacity(written.len()),
        names: BTreeMap::new(),
        included: Vec::new(),
    };
    let mut open: Vec<PathBuf> = Vec::new();
    for line in written.split_inclusive('\n') {
        let directive = directive(line)
            .and_then(|(number, name, level)| Some((number, name, level, roots.origin(name)?)));
        let Some((number, name, level, file)) = directive else {
            made.text += line;
            continue;
        };
        match level {
            1 => {
                match open.last() {
                    Some(by) => made.included.push(Included { file: file.clone(), by: by.clone() }),
                    None => made.text += "`default_nettype wire\n",
                }
                open.push(file.clone());
            }
            2 => drop(open.pop()),
            _ => {}
        }
        // Not one that would be compiled by itself.
        let plain = format!("{}.in", name[RTL.len() + 1..].replace('/', "."));
        made.text += &format!("`line {number} \"{RTL}/{plain}\" {level}\n");
        made.names.insert(plain, file);
    }
    made
}

/// Line, file and level of a `line directive: 1 enters a file, 2 leaves it.
fn directive(line: &str) -> Option<(u64, &str, u32)> {
    let rest = line.strip_prefix("`line ")?;
    let (number, rest) = rest.split_once(" \"")?;
    let (name, level) = rest.rsplit_once("\" ")?;
    Some((number.parse().ok()?, name, level.trim_end().parse().ok()?))
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    #[test]
    fn files_and_what_they_include_are_told_apart() {
        let mut roots = Roots::new().unwrap();
        roots.of_folder(Path::new("my rtl")).unwrap();
        roots.of_folder(Path::new("inc")).unwrap();
        let written = "`line 1 \"rtl/0/a.v\" 1\n`line 1 \"rtl/1/p.vh\" 1\nx\n\
                       `line 2 \"rtl/1/p.vh\" 2\n`line 2 \"rtl/0/a.v\" 0\ny\n\
                       `line 3 \"rtl/0/a.v\" 2\n`line 1 \"rtl/0/b.v\" 1\nz\n\
                       `line 9 \"odd\" 0\n`line 2 \"rtl/0/b.v\" 2\n";
        let made = joined(written, &roots);
        let included = Included { file: "inc/p.vh".into(), by: "my rtl/a.v".into() };
        assert_eq!(made.included, [included]);
        assert_eq!(made.text.matches("`default_nettype wire").count(), 2);
        assert!(made.text.contains("`line 2 \"rtl/0.a.v.in\" 0\ny\n"));
        assert!(made.text.contains("`line 9 \"odd\" 0\n"));
        let names: Vec<&String> = made.names.keys().collect();
        assert_eq!(names, ["0.a.v.in", "0.b.v.in", "1.p.vh.in"]);
        assert_eq!(made.names["0.b.v.in"], Path::new("my rtl/b.v"));
    }
}
