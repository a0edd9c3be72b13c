//! Lists of files and options, as simulators take them with `-f`.

use std::path::{Path, PathBuf};

use super::{Named, check_define};
use crate::cosim::error::CosimError;
use crate::files::read_regular;
use crate::printable::printable;

/// Largest list that is read.
const MOST_BYTES: u64 = 4 << 20;
/// Lists within lists: more are a circle.
const MOST_NESTED: usize = 32;
/// Options that say nothing of what the design is: warnings, versions of the language
/// (Verilator reads all as SystemVerilog), time scales.
const WITHOUT_EFFECT: [&str; 14] = [
    "-W",
    "-sv",
    "-sverilog",
    "-g2",
    "-v2k",
    "+v2k",
    "+systemverilogext+",
    "+verilog2001ext+",
    "+verilog1995ext+",
    "+nospecify",
    "+notimingcheck",
    "-timescale=",
    "--timescale",
    "-quiet",
];

/// Adds what a list names. Its paths are relative to its own folder or, where there is
/// nothing, to the present one.
///
/// # Errors
/// When it cannot be read, or says what is not understood, with its line.
pub fn read(path: &Path, named: &mut Named) -> Result<(), CosimError> {
    let base = path.parent().unwrap_or(Path::new(""));
    List { path, base }.read(named, 0)
}

/// A list that is being read.
struct List<'a> {
    path: &'a Path,
    /// What its paths are relative to.
    base: &'a Path,
}

/// A word of a list, and where it stands.
#[derive(Debug, PartialEq, Eq)]
struct Word {
    text: String,
    line: usize,
    column: usize,
}

impl List<'_> {
    fn read(&self, named: &mut Named, depth: usize) -> Result<(), CosimError> {
        let text = read_regular(self.path, MOST_BYTES)
            .map_err(|source| CosimError::Unreadable { path: self.path.to_owned(), source })?;
        let words = words(&text).map_err(|(at, reason)| self.error(&at, reason))?;
        let mut words = words.into_iter();
        while let Some(word) = words.next() {
            let text = word.text.as_str();
            let mut argument = || {
                words
                    .next()
                    .ok_or_else(|| self.error(&word, format!("{text} needs a name behind it")))
            };
            match text {
                "-f" | "-F" | "-file" => {
                    let nested = self.path(&argument()?)?;
                    if depth == MOST_NESTED {
                        let reason = format!("more than {MOST_NESTED} lists within each other");
                        return Err(self.error(&word, reason));
                    }
                    let own = nested.parent().unwrap_or(Path::new(""));
                    let base = if text == "-F" { own } else { self.base };
                    List { path: &nested, base }.read(named, depth + 1)?;
                }
                "-v" => named.libraries.push(self.path(&argument()?)?),
                "-y" => named.module_folders.push(self.path(&argument()?)?),
                "-I" => named.include_folders.push(self.path(&argument()?)?),
                "-D" => {
                    let define = argument()?;
                    self.define(&define, &define.text, named)?;
                }
                _ if text.starts_with(['-', '+']) => self.option(&word, named)?,
                _ => named.files.push(self.path(&word)?),
            }
        }
        Ok(())
    }

    /// An option that is one word.
    fn option(&self, word: &Word, named: &mut Named) -> Result<(), CosimError> {
        let text = word.text.as_str();
        let parts = |rest: &'_ str| -> Vec<String> {
            let parts = rest.split('+').filter(|part| !part.is_empty());
            parts.map(str::to_owned).collect()
        };
        if let Some(rest) = text.strip_prefix("+incdir+") {
            for part in parts(rest) {
                named.include_folders.push(self.path(&word.with(part))?);
            }
        } else if let Some(rest) = text.strip_prefix("+define+") {
            for part in parts(rest) {
                self.define(word, &part, named)?;
            }
        } else if let Some(rest) = text.strip_prefix("+libext+") {
            let endings = parts(rest);
            if let Some(odd) = endings.iter().find(|ending| !ending.starts_with('.')) {
                let reason = format!("{odd:?} is not an ending; write +libext+.v+.sv");
                return Err(self.error(word, reason));
            }
            named.endings.extend(endings);
        } else if let Some(rest) = text.strip_prefix("-I").filter(|rest| !rest.is_empty()) {
            named.include_folders.push(self.path(&word.with(rest.to_owned()))?);
        } else if let Some(rest) = text.strip_prefix("-D").filter(|rest| !rest.is_empty()) {
            self.define(word, rest, named)?;
        } else if WITHOUT_EFFECT.iter().any(|start| text.starts_with(start)) {
            named.remarks.push(format!(
                "{}:{}: {} has no effect here",
                self.path.display(),
                word.line,
                printable(text)
            ));
        } else {
            let reason = format!(
                "the option {text:?} is not understood; what is: files, -f, -F, -v, -y, -I, -D, \
                 +incdir+, +define+, +libext+"
            );
            return Err(self.error(word, reason));
        }
        Ok(())
    }

    fn define(&self, word: &Word, define: &str, named: &mut Named) -> Result<(), CosimError> {
        check_define(define).map_err(|reason| self.error(word, reason))?;
        named.defines.push(define.to_owned());
        Ok(())
    }

    /// A path of the list: where it leads from the list's base, or from the present
    /// folder.
    fn path(&self, word: &Word) -> Result<PathBuf, CosimError> {
        let text = expanded(&word.text).map_err(|reason| self.error(word, reason))?;
        let from_base = self.base.join(&text);
        if from_base.exists() {
            return Ok(from_base);
        }
        let from_here = PathBuf::from(&text);
        if from_here.exists() {
            return Ok(from_here);
        }
        let reason = format!(
            "{text:?} is neither there from the list's folder nor from the present one; paths are \
             relative to the folder of the list"
        );
        Err(self.error(word, reason))
    }

    fn error(&self, word: &Word, reason: String) -> CosimError {
        CosimError::FileList {
            path: self.path.to_owned(),
            line: word.line,
            column: word.column,
            reason: printable(&reason).into_owned(),
        }
    }
}

impl Word {
    /// Another text in its place.
    fn with(&self, text: String) -> Word {
        Word { text, ..*self }
    }
}

/// The words of a list, without comments: `//` and `#` at the start of a word to the end
/// of the line, and `/* */`. Quotation marks keep spaces, and so does a backslash.
fn words(text: &str) -> Result<Vec<Word>, (Word, String)> {
    let mut words: Vec<Word> = Vec::new();
    let mut is_comment = false;
    for (number, line) in text.lines().enumerate() {
        let mut characters = line.chars().enumerate().peekable();
        let mut word: Option<Word> = None;
        let mut quote: Option<char> = None;
        while let Some((at, c)) = characters.next() {
            let next = characters.peek().map(|&(_, next)| next);
            if is_comment {
                if c == '*' && next == Some('/') {
                    characters.next();
                    is_comment = false;
                }
                continue;
            }
            let begins = word.is_none() && quote.is_none();
            match c {
                _ if quote == Some(c) => quote = None,
                '/' if begins && next == Some('*') => {
                    characters.next();
                    is_comment = true;
                }
                '/' if begins && next == Some('/') => break,
                '#' if begins => break,
                c if c.is_whitespace() && quote.is_none() => words.extend(word.take()),
                _ => {
                    let word = word.get_or_insert_with(|| Word {
                        text: String::new(),
                        line: number + 1,
                        column: at + 1,
                    });
                    match c {
                        '"' if quote.is_none() => quote = Some(c),
                        '\\' if next.is_some() => {
                            word.text.extend(characters.next().map(|(_, next)| next));
                        }
                        _ => word.text.push(c),
                    }
                }
            }
        }
        if let (Some(_), Some(word)) = (quote, word.take_if(|_| quote.is_some())) {
            return Err((word, "the quotation mark is not closed in its line".to_owned()));
        }
        words.extend(word);
    }
    Ok(words)
}

/// A text with `$NAME`, `${NAME}` and `$(NAME)` replaced by the environment's.
fn expanded(text: &str) -> Result<String, String> {
    let mut told = String::new();
    let mut rest = text;
    while let Some(at) = rest.find('$') {
        told += &rest[..at];
        let behind = &rest[at + 1..];
        let (name, after) = match behind.chars().next() {
            Some(open @ ('{' | '(')) => {
                let close = if open == '{' { '}' } else { ')' };
                behind[1..].split_once(close).ok_or_else(|| format!("${open} is not closed"))?
            }
            _ => {
                let is_name = |c: char| c.is_ascii_alphanumeric() || c == '_';
                behind.split_at(behind.find(|c| !is_name(c)).unwrap_or(behind.len()))
            }
        };
        let value = std::env::var(name).map_err(|_| {
            format!("the environment has no variable {name:?}, which {text:?} asks for")
        })?;
        told += &value;
        rest = after;
    }
    Ok(told + rest)
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    fn texts(list: &str) -> Vec<String> {
        let words = words(list).unwrap();
        words.into_iter().map(|word| word.text).collect()
    }

    #[test]
    fn words_end_at_spaces_and_comments_are_none() {
        let list = "a.v b.v // c.v\n# d.v\n/* e.v\nf.v */ g.v a//h.v\n\"my i.v\" my\\ j.v";
        assert_eq!(texts(list), ["a.v", "b.v", "g.v", "a//h.v", "my i.v", "my j.v"]);
        let places = words("  a.v\n x b.v").unwrap();
        let places: Vec<_> = places.iter().map(|w| (w.line, w.column)).collect();
        assert_eq!(places, [(1, 3), (2, 2), (2, 4)]);
        assert!(words("\"a.v\nb.v").is_err());
    }

    fn read_text(folder: &Path, list: &str) -> Result<Named, String> {
        let path = folder.join("list.f");
        fs::write(&path, list).unwrap();
        let mut named = Named::default();
        read(&path, &mut named).map(|()| named).map_err(|error| error.to_string())
    }

    #[test]
    fn every_option_has_its_place() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        for name in ["rtl", "inc", "inc2", "lib", "sub"] {
            fs::create_dir(at(name)).unwrap();
        }
        for name in ["rtl/a.v", "rtl/b c.sv", "lib.v", "sub/d.v"] {
            fs::write(at(name), "").unwrap();
        }
        fs::write(at("sub/nested.f"), "d.v +define+NESTED\n").unwrap();
        let list = "rtl/a.v \"rtl/b c.sv\" -v lib.v -y lib +libext+.v+.vlib\n\
                    +incdir+inc+inc2 -Irtl +define+A+B=2 -D C -DD=x -F sub/nested.f -Wall\n";
        let named = read_text(folder.path(), list).unwrap();
        assert_eq!(named.files, [at("rtl/a.v"), at("rtl/b c.sv"), at("sub/d.v")]);
        assert_eq!(named.libraries, [at("lib.v")]);
        assert_eq!(named.module_folders, [at("lib")]);
        assert_eq!(named.include_folders, [at("inc"), at("inc2"), at("rtl")]);
        assert_eq!(named.endings, [".v", ".vlib"]);
        assert_eq!(named.defines, ["A", "B=2", "C", "D=x", "NESTED"]);
        assert_eq!(named.remarks.len(), 1);
    }

    #[test]
    fn what_is_not_understood_is_named_with_its_place() {
        let folder = tempfile::tempdir().unwrap();
        for (list, place, part) in [
            ("\n  missing.v", ":2:3: ", "neither there"),
            ("+frobnicate+1", ":1:1: ", "is not understood"),
            ("-y", ":1:1: ", "needs a name"),
            ("+define+1A", ":1:1: ", "defines no macro"),
            ("+libext+v", ":1:1: ", "is not an ending"),
            ("$NO_SUCH_VARIABLE_HERE/a.v", ":1:1: ", "no variable"),
            ("-f list.f", ":1:1: ", "lists within each other"),
        ] {
            let told = read_text(folder.path(), list).unwrap_err();
            assert!(told.contains(place) && told.contains(part), "{told}");
        }
    }
}
