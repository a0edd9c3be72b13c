//! Folders of the user's under short names of ours.
//!
//! A tool is started in a folder that has nothing but a link to each folder that it may
//! look into. So whatever characters a path has, the tool sees plain names; it finds
//! nothing by accident in the folder that goldtof was started in; and what is built does
//! not depend on where the files lie.

use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};

use crate::cosim::error::CosimError;
use crate::cosim::source::RTL;
use crate::interrupt::Unfinished;
use crate::printable::is_unprintable;

/// A folder to start tools in, with its links.
pub(super) struct Roots {
    folder: Unfinished,
    shown: Vec<PathBuf>,
    numbers: HashMap<PathBuf, usize>,
}

impl Roots {
    /// An empty one.
    pub(super) fn new() -> Result<Roots, CosimError> {
        let made = tempfile::Builder::new().prefix("goldtof-").tempdir().and_then(|folder| {
            let kept = Unfinished::new(&folder.keep());
            fs::create_dir(kept.path().join(RTL))?;
            Ok(kept)
        });
        let folder = made.map_err(CosimError::cache(std::env::temp_dir()))?;
        Ok(Roots { folder, shown: Vec::new(), numbers: HashMap::new() })
    }

    /// Where tools are started.
    pub(super) fn path(&self) -> &Path {
        self.folder.path()
    }

    /// A folder's name for the tools.
    pub(super) fn of_folder(&mut self, folder: &Path) -> Result<String, CosimError> {
        let number = match self.numbers.get(folder) {
            Some(&number) => number,
            None => {
                let number = self.shown.len();
                let link = self.path().join(RTL).join(number.to_string());
                let target = match folder.as_os_str().is_empty() {
                    true => Path::new("."),
                    false => folder,
                };
                std::path::absolute(target)
                    .and_then(|target| std::os::unix::fs::symlink(target, &link))
                    .map_err(CosimError::cache(&link))?;
                self.shown.push(folder.to_owned());
                self.numbers.insert(folder.to_owned(), number);
                number
            }
        };
        Ok(format!("{RTL}/{number}"))
    }

    /// A file's name for the tools.
    ///
    /// # Errors
    /// When the file's own name is one that a tool would not take for a name.
    pub(super) fn of_file(&mut self, file: &Path) -> Result<String, CosimError> {
        let folder = file.parent().unwrap_or(Path::new(""));
        let refused = |reason| CosimError::FileName {
            folder: folder.to_owned(),
            name: file.file_name().unwrap_or_default().to_owned(),
            reason,
        };
        let name = file.file_name().and_then(|name| name.to_str());
        let Some(name) = name else {
            return Err(refused("it is not UTF-8"));
        };
        if name.contains(is_unprintable) {
            return Err(refused("it holds a character that cannot be seen"));
        }
        if name.contains(['"', '\\']) {
            return Err(refused("it holds a quotation mark or a backslash"));
        }
        Ok(format!("{}/{name}", self.of_folder(folder)?))
    }

    /// The file that a tool's name stands for.
    pub(super) fn origin(&self, name: &str) -> Option<PathBuf> {
        let (number, rest) = name.strip_prefix(RTL)?.strip_prefix('/')?.split_once('/')?;
        Some(self.shown.get(number.parse::<usize>().ok()?)?.join(rest))
    }

    /// A tool's words, with the user's own names of folders.
    pub(super) fn in_users_terms(&self, text: &str) -> String {
        let prefix = format!("{RTL}/");
        let mut told = String::new();
        let mut rest = text;
        while let Some(at) = rest.find(&prefix) {
            let (before, after) = rest.split_at(at);
            told += before;
            let is_part = before.ends_with(|c: char| c.is_alphanumeric() || "/._-".contains(c));
            let name = &after[prefix.len()..];
            let digits = name.bytes().take_while(u8::is_ascii_digit).count();
            let number = name[..digits].parse().ok();
            let shown = number.and_then(|number: usize| self.shown.get(number));
            match shown {
                Some(shown) if !is_part && name[digits..].starts_with('/') => {
                    // As joining a path does: nothing before a file of the present folder.
                    told += &shown.join("").display().to_string();
                    rest = &name[digits + 1..];
                }
                _ => {
                    told += &prefix;
                    rest = name;
                }
            }
        }
        told + rest
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_tools_and_of_the_user_are_each_others() {
        let mut roots = Roots::new().unwrap();
        let odd = Path::new("my \"odd\" \\folder/a.v");
        assert_eq!(roots.of_file(odd).unwrap(), "rtl/0/a.v");
        assert_eq!(roots.of_file(Path::new("b.v")).unwrap(), "rtl/1/b.v");
        assert_eq!(roots.of_folder(Path::new("my \"odd\" \\folder")).unwrap(), "rtl/0");
        assert_eq!(roots.origin("rtl/0/a.v").unwrap(), odd);
        assert_eq!(roots.origin("rtl/7/a.v"), None);
        assert_eq!(
            roots.in_users_terms("%Error: rtl/0/a.v:3: rtl/1/b.v, xrtl/0/a.v rtl/9/c rtl/"),
            "%Error: my \"odd\" \\folder/a.v:3: b.v, xrtl/0/a.v rtl/9/c rtl/"
        );
        for name in ["a\nb.v", "a\"b.v", "a\\b.v"] {
            assert!(roots.of_file(Path::new(name)).is_err());
        }
    }
}
