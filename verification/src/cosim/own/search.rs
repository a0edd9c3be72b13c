//! Finds the files of a design and makes one text of them.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::Stdio;

use super::Named;
use super::folder::check_size;
use super::other_text;
use super::preprocessed::{Preprocessed, joined};
use super::roots::Roots;
use crate::cosim::build::VERILATOR_FLAGS;
use crate::cosim::error::CosimError;
use crate::cosim::ports::{self, FoundPort};
use crate::cosim::rejected::finds_fault;
use crate::cosim::source::SourceFile;
use crate::cosim::tools::Tools;

/// The file that names the top module, so that Verilator looks for it.
const ASKING: &str = "goldtof_asks.v";
/// Folder and prefix of what Verilator writes.
const MADE: &str = "made";
const PREFIX: &str = "Vown";
/// Name of the one text that is made of a design.
const TEXT: &str = "design.sv";

/// The text of a design with the files that the tools may speak of, and remarks.
pub type Taken = (Vec<SourceFile>, Vec<String>);

/// Asks Verilator which files make up a design.
pub(super) struct FileSearch<'a> {
    tools: &'a Tools,
    top: &'a str,
    named: Named,
    roots: Roots,
}

/// What Verilator is given.
#[derive(Debug, Clone, Default)]
struct Given {
    /// Files that are compiled, in their order.
    files: Vec<PathBuf>,
    /// Files of which what is needed is taken.
    libraries: Vec<PathBuf>,
    /// Folders in which modules are looked for.
    module_folders: Vec<PathBuf>,
}

impl<'a> FileSearch<'a> {
    /// Of a design whose top module is `top`.
    ///
    /// # Errors
    /// When a file is too large, or a folder is not there.
    pub(super) fn new(
        tools: &'a Tools,
        top: &'a str,
        named: Named,
    ) -> Result<FileSearch<'a>, CosimError> {
        check_size(Path::new(""), &named.files)?;
        check_size(Path::new(""), &named.libraries)?;
        check_folders(&named.module_folders)?;
        Ok(FileSearch { tools, top, named, roots: Roots::new()? })
    }

    /// The design's text, and the top module's ports.
    ///
    /// Modules of a folder that is searched are first looked for by the names of its
    /// files, as `-y` does: what is not needed is then not even read. If that does not
    /// lead to a design, all files are taken, but for those that cannot be read as Verilog.
    pub(super) fn find(mut self) -> Result<(Taken, Vec<FoundPort>), CosimError> {
        let mut given = Given {
            files: self.named.files.clone(),
            libraries: self.named.libraries.clone(),
            module_folders: self.named.module_folders.clone(),
        };
        if self.named.searched.is_empty() {
            let ports = match (self.verilate(&given), self.top_in_module_folders()) {
                (Err(CosimError::NoTop { .. }), Some(top)) => {
                    given.libraries.push(top);
                    self.verilate(&given)?
                }
                (ports, _) => ports?,
            };
            return Ok((self.take(&given)?, ports));
        }
        let by_name = self.by_name(&given)?;
        let refused = match by_name.map(|given| Ok((self.verilate(&given)?, given))) {
            Some(Ok((ports, given))) => {
                self.check_unique()?;
                return Ok((self.take(&given)?, ports));
            }
            Some(Err(error @ CosimError::Rejected { .. })) => Some(error),
            Some(Err(error)) => return Err(error),
            None => None,
        };
        match (self.with_all(given), refused) {
            // A needed file that is not Verilog is what is wrong, and not that it is missing.
            (Err(CosimError::Rejected { .. } | CosimError::NoTop { .. }), Some(first)) => {
                Err(first)
            }
            (found, _) => found,
        }
    }

    /// The file of a folder for modules (`-y`) that is called as the top module, which
    /// Verilator does not look for there.
    fn top_in_module_folders(&self) -> Option<PathBuf> {
        let endings = self.endings();
        let mut places = self.named.module_folders.iter().flat_map(|folder| {
            let names = endings.iter().map(|ending| format!("{}{ending}", self.top));
            names.map(|name| folder.join(name))
        });
        places.find(|place| place.is_file())
    }

    fn endings(&self) -> Vec<String> {
        let mut endings = vec![".v".to_owned(), ".sv".to_owned()];
        endings.extend(self.named.endings.iter().cloned());
        endings
    }

    /// The folder's modules by the names of their files, if there is one for the top.
    fn by_name(&self, given: &Given) -> Result<Option<Given>, CosimError> {
        let is_top = |path: &&PathBuf| path.file_stem().is_some_and(|stem| stem == self.top);
        let tops: Vec<&PathBuf> = self.named.searched.iter().filter(is_top).collect();
        let top = match tops[..] {
            [] if given.files.is_empty() => return Ok(None),
            [] => None,
            [top] => Some(top.clone()),
            [first, second, ..] => return Err(self.ambiguous(first, second)),
        };
        let mut given = given.clone();
        given.files.extend(top);
        let mut folders: Vec<PathBuf> = Vec::new();
        for file in &self.named.searched {
            let folder = file.parent().unwrap_or(Path::new(""));
            if !folders.iter().any(|known| known == folder) {
                folders.push(folder.to_owned());
            }
        }
        given.module_folders.extend(folders);
        Ok(Some(given))
    }

    /// Refuses a design of which a module was found by the name of its file where there
    /// are two of that name.
    fn check_unique(&self) -> Result<(), CosimError> {
        let mut stems: BTreeMap<&std::ffi::OsStr, &PathBuf> = BTreeMap::new();
        let read = self.files_read()?;
        for path in &self.named.searched {
            let stem = path.file_stem().unwrap_or_default();
            if let Some(other) = stems.insert(stem, path)
                && (read.contains(other) || read.contains(path))
            {
                return Err(self.ambiguous(other, path));
            }
        }
        Ok(())
    }

    fn ambiguous(&self, first: &Path, second: &Path) -> CosimError {
        CosimError::Ambiguous {
            what: format!("module {}", first.file_stem().unwrap_or_default().to_string_lossy()),
            first: first.to_owned(),
            second: second.to_owned(),
        }
    }

    /// All files, packages first; without those that Verilator cannot parse, as long as it
    /// does without them.
    fn with_all(mut self, given: Given) -> Result<(Taken, Vec<FoundPort>), CosimError> {
        let mut searched = self.named.searched.clone();
        searched.sort_by_key(|path| {
            let name = path.file_stem().unwrap_or_default().to_string_lossy().to_lowercase();
            !(name.contains("pkg") || name.contains("package"))
        });
        let mut first_refusal = None;
        loop {
            let mut tried = given.clone();
            // In their order, which Verilator does not keep of libraries. What the top module
            // does not need is not elaborated.
            tried.files.extend(searched.iter().cloned());
            match self.verilate(&tried) {
                Ok(ports) => {
                    let mut taken = self.take(&tried)?;
                    for left in self.named.searched.iter().filter(|f| !searched.contains(f)) {
                        taken.1.push(format!(
                            "{} is not needed, and no Verilog that Verilator reads: left out",
                            left.display()
                        ));
                    }
                    return Ok((taken, ports));
                }
                Err(CosimError::Rejected { tool, output }) => {
                    let blamed = |file: &PathBuf| {
                        output.lines().any(|line| {
                            line.starts_with("%Error: ")
                                && line["%Error: ".len()..]
                                    .strip_prefix(&*file.display().to_string())
                                    .is_some_and(|rest| {
                                        rest.starts_with(':') && is_about_text(rest)
                                    })
                        })
                    };
                    let before = searched.len();
                    searched.retain(|file| !blamed(file));
                    let error = CosimError::Rejected { tool, output };
                    if searched.len() == before || searched.is_empty() {
                        return Err(first_refusal.unwrap_or(error));
                    }
                    first_refusal.get_or_insert(error);
                }
                Err(error) => return Err(first_refusal.unwrap_or(error)),
            }
        }
    }

    /// Lets Verilator read and elaborate what it is given; the top module's ports.
    fn verilate(&mut self, given: &Given) -> Result<Vec<FoundPort>, CosimError> {
        let asks = format!("module goldtof_asks; {} asked(); endmodule\n", self.top);
        let path = self.roots.path().join(ASKING);
        fs::write(&path, asks).map_err(CosimError::cache(&path))?;
        let mut arguments = self.options()?;
        for file in &given.files {
            arguments.push(self.roots.of_file(file)?);
        }
        for file in &given.libraries {
            arguments.extend(["-v".to_owned(), self.roots.of_file(file)?]);
        }
        for folder in &given.module_folders {
            arguments.extend(["-y".to_owned(), self.roots.of_folder(folder)?]);
        }
        let verilated = self.tools.verilator.run(|command| {
            command
                .current_dir(self.roots.path())
                .args(VERILATOR_FLAGS)
                .args(["--top-module", self.top, "--prefix", PREFIX, "--Mdir", MADE])
                .arg(format!("+libext+{}", self.endings().join("+")))
                .args(&arguments)
                .arg(ASKING)
        });
        verilated.map_err(|error| self.rejected(error))?;
        let header = self.roots.path().join(MADE).join(format!("{PREFIX}.h"));
        let text = fs::read_to_string(&header).map_err(CosimError::cache(&header))?;
        Ok(ports::verilated_ports(&text))
    }

    /// Folders to include from, and macros.
    fn options(&mut self) -> Result<Vec<String>, CosimError> {
        let mut options = Vec::new();
        for folder in &self.include_folders() {
            options.push(format!("-I{}", self.roots.of_folder(folder)?));
        }
        let defines = self.named.defines.iter();
        options.extend(defines.map(|define| format!("-D{define}")));
        options.extend(self.named.flags.iter().map(|flag| (*flag).to_owned()));
        Ok(options)
    }

    /// Where included files are looked for: where the user says, then beside every file
    /// that is named.
    fn include_folders(&self) -> Vec<PathBuf> {
        let mut folders = self.named.include_folders.clone();
        for file in self.named.files.iter().chain(&self.named.libraries) {
            let folder = file.parent().unwrap_or(Path::new(""));
            if !folders.iter().any(|known| known == folder) {
                folders.push(folder.to_owned());
            }
        }
        folders
    }

    /// The files that Verilator has read.
    fn files_read(&self) -> Result<Vec<PathBuf>, CosimError> {
        let path = self.roots.path().join(MADE).join(format!("{PREFIX}__verFiles.dat"));
        let text = fs::read_to_string(&path).map_err(CosimError::cache(&path))?;
        let names = text.lines().filter(|line| line.starts_with('S')).filter_map(|line| {
            let (_, name) = line.trim_end().strip_suffix('"')?.rsplit_once('"')?;
            self.roots.origin(name)
        });
        Ok(names.collect())
    }

    /// The text of the files that Verilator has read.
    fn take(&mut self, given: &Given) -> Result<Taken, CosimError> {
        let mut files: Vec<PathBuf> = given.files.clone();
        files.extend(given.libraries.iter().cloned());
        let mut text = self.preprocess(&files)?;
        let endings = self.endings();
        // What is neither named nor included was found by its name.
        let is_found = |path: &PathBuf| {
            let name = path.to_string_lossy();
            !files.contains(path)
                && endings.iter().any(|ending| name.ends_with(ending))
                && !text.included.iter().any(|include| include.file == *path)
        };
        let found: Vec<PathBuf> = self.files_read()?.into_iter().filter(is_found).collect();
        if !found.is_empty() {
            files.extend(found);
            text = self.preprocess(&files)?;
        }
        self.check_includes(&text)?;
        let origin = match (&given.files[..], &given.libraries[..]) {
            ([first, ..], _) | ([], [first, ..]) => first.clone(),
            ([], []) => PathBuf::from(TEXT),
        };
        let mut sources =
            vec![SourceFile { name: TEXT.to_owned(), text: text.text, origin: Some(origin) }];
        self.named.remarks.extend(text.names.values().filter_map(|file| {
            let text = fs::read(file).ok()?;
            other_text::remark(file, &String::from_utf8_lossy(&text))
        }));
        sources.extend(text.names.into_iter().map(|(name, file)| SourceFile {
            name,
            text: String::new(),
            origin: Some(file),
        }));
        Ok((sources, std::mem::take(&mut self.named.remarks)))
    }

    /// Refuses a file that was included from another folder than its includer's, where
    /// that has a file of the same name, and the user has not said which.
    fn check_includes(&self, text: &Preprocessed) -> Result<(), CosimError> {
        for include in &text.included {
            let (Some(name), Some(by)) = (include.file.file_name(), include.by.parent()) else {
                continue;
            };
            let beside = by.join(name);
            let folder = include.file.parent().unwrap_or(Path::new(""));
            let is_asked = self.named.include_folders.iter().any(|f| f == folder)
                && self.named.searched.is_empty();
            if beside != include.file && beside.is_file() && !is_asked {
                return Err(CosimError::Ambiguous {
                    what: format!("`include in {}", include.by.display()),
                    first: include.file.clone(),
                    second: beside,
                });
            }
        }
        Ok(())
    }

    fn preprocess(&mut self, files: &[PathBuf]) -> Result<Preprocessed, CosimError> {
        let mut arguments = self.options()?;
        for folder in &self.named.module_folders {
            arguments.push(format!("-I{}", self.roots.of_folder(folder)?));
        }
        for file in files {
            arguments.push(self.roots.of_file(file)?);
        }
        let path = self.roots.path().join(TEXT);
        let out = File::create(&path).map_err(CosimError::cache(&path))?;
        let done = self.tools.verilator.run_into(
            |command| {
                command
                    .current_dir(self.roots.path())
                    .args(["-E", "-Wno-fatal", "-Wno-lint", "-Wno-style"])
                    .args(&arguments)
            },
            Stdio::from(out),
        );
        done.map_err(|error| self.rejected(error))?;
        let bytes = fs::read(&path).map_err(CosimError::cache(&path))?;
        Ok(joined(&String::from_utf8_lossy(&bytes), &self.roots))
    }

    /// Verilator's refusal in the user's terms.
    fn rejected(&self, error: CosimError) -> CosimError {
        let CosimError::ToolFailed { tool, status, output, .. } = &error else {
            return error;
        };
        if !finds_fault(*status, output, |line| line.starts_with("%Error")) {
            return error;
        }
        let asked = format!("Cannot find file containing module: '{}'", self.top);
        let not_top = format!("Specified --top-module '{}' was not found", self.top);
        let no_top = output
            .lines()
            .any(|line| line.contains(&not_top) || line.contains(ASKING) && line.contains(&asked));
        if no_top {
            return CosimError::NoTop { top: self.top.to_owned() };
        }
        CosimError::Rejected { tool, output: self.roots.in_users_terms(output) }
    }
}

/// Whether an error is about a file's text alone, and not about what else there is.
fn is_about_text(told: &str) -> bool {
    ["syntax error", "not defined", "Unsupported", "include file", "Unterminated"]
        .iter()
        .any(|part| told.contains(part))
}

/// Refuses a folder that is not there: a tool would say nothing of it.
pub(super) fn check_folders(folders: &[PathBuf]) -> Result<(), CosimError> {
    for folder in folders {
        let found = fs::metadata(folder).and_then(|found| match found.is_dir() {
            true => Ok(()),
            false => Err(std::io::Error::other("it is not a folder")),
        });
        found.map_err(|source| CosimError::Unreadable { path: folder.clone(), source })?;
    }
    Ok(())
}
