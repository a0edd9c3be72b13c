//! Builds Verilog into a program that clocks it, once.
//!
//! A build's identity is the hash of everything that goes into it: Verilog,
//! C++, flags and the tools' versions.

use std::ffi::{OsStr, OsString};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

pub use super::cache::{cache_dir, file_identity, hash, once, set_cache_dir, write};
use super::drivers;
use super::error::CosimError;
use super::image::ProgramImage;
use super::low_half;
use super::ports;
use super::rejected::{in_build, in_users_terms, rejection};
use super::source::{RTL, SourceFile, is_users};
use super::tools::Tools;
use super::undefined;
use crate::rtl::blocks::ScanRegisters;
use crate::sensor::interface::Interface;
use crate::sensor::layout::Layout;

const TESTBENCH: &str = include_str!("../../../testbench/cosim.cpp");
/// What every testbench includes: the talk with its caller.
const PROCESS: &str = include_str!("../../../testbench/process.h");
const PROGRAM: &str = "sensor";
const RUNTIME_OBJECT: &str = "runtime.o";
/// The one unit that the compiler gets.
const UNIT: &str = "all.cc";
/// What the compiler makes of it.
const MODEL_OBJECT: &str = "model.o";
/// The elaborated design, as Verilator writes it.
const ELABORATED: &str = "elaborated.xml";
/// What Verilator is told of the scan's counters.
const CONFIGURATION: &str = "counters.vlt";
/// `--x-initial unique` starts registers at random, so that a missing reset is
/// a mismatch and not luck, and `--x-assign unique` does so with every x. Lint is the emitter's own tests' business; a user's
/// RTL is judged by what it does. But what fails when it is elaborated has failed,
/// and of two modules with one name, or two drivers of a net, nobody knows which was
/// meant.
pub(super) const VERILATOR_FLAGS: &[&str] = &[
    "--cc",
    "-O3",
    "--no-timing",
    "--x-assign",
    "unique",
    "--x-initial",
    "unique",
    "-Wno-fatal",
    "-Wno-lint",
    "-Wno-style",
    "-Werror-USERFATAL",
    "-Werror-USERERROR",
    "-Werror-MODDUP",
    "-Werror-MULTIDRIVEN",
];
/// What a board needs beside: a model may drive a pin from within.
pub(super) const BOARD_FLAG: &str = "-Wno-ASSIGNIN";
/// What lock-step needs beside: a model that tells its state.
const SAVABLE: &str = "--savable";

/// Parts of Verilator's run-time library that a single-threaded model needs.
const RUNTIME: &[&str] = &["verilated.cpp", "verilated_save.cpp", "verilated_threads.cpp"];
/// What a unit includes of it before all else.
const RUNTIME_HEADER: &str = "#include \"verilated.h\"\n#include \"verilated_save.h\"\n";

/// A built model, ready to be started.
#[derive(Debug, Clone)]
pub struct Built {
    /// Where the cache keeps it.
    pub path: PathBuf,
    /// The program, as it was checked.
    pub image: Arc<ProgramImage>,
    /// Whether the Verilog is the user's own.
    pub is_users: bool,
    /// The scan's counters, if it has been built so that they can be moved on.
    pub registers: Option<ScanRegisters>,
}

/// Builds a model, or finds it built.
///
/// # Errors
/// When a tool is missing or fails, when the Verilog does not compile or its ports
/// do not fit the interface, or when the cache cannot be written.
pub fn build(
    top: &str,
    sources: &[SourceFile],
    interface: &Interface,
    cache: &Path,
) -> Result<Built, CosimError> {
    build_with(top, sources, interface, None, cache)
}

/// Builds a model whose scan's counters can be moved on.
///
/// # Errors
/// As [`build`].
pub fn build_with(
    top: &str,
    sources: &[SourceFile],
    interface: &Interface,
    registers: Option<&ScanRegisters>,
    cache: &Path,
) -> Result<Built, CosimError> {
    let tools = Tools::find(cache)?;
    let header = ports::header(top, &Layout::of(interface), registers);
    let mut parts =
        vec![tools.versions.as_str(), TESTBENCH, PROCESS, undefined::TEXT, &header, top];
    parts.extend([SAVABLE, drivers::VERSION, undefined::VERSION, env!("CARGO_PKG_VERSION")]);
    let clock = low_half::identity(top);
    parts.extend(clock.iter().map(String::as_str));
    parts.extend(VERILATOR_FLAGS);
    parts.extend(tools.compiler_flags.iter().map(String::as_str));
    for source in sources {
        parts.extend([source.name.as_str(), source.text.as_str()]);
    }
    let name = format!("model-{}", hash(&parts));
    let bytes = once(cache, &name, PROGRAM, |folder| {
        let runtime = Runtime::of(&tools, cache)?;
        verilate(&tools, top, sources, interface, registers, folder)?;
        write(&folder.join(ports::HEADER), &header)?;
        low_half::write_header(folder, top, interface)?;
        undefined::mark(folder, top)?;
        write(&folder.join("process.h"), PROCESS)?;
        write(&folder.join("cosim.cpp"), TESTBENCH)?;
        write(&folder.join(undefined::HEADER), undefined::TEXT)?;
        let header = ["-include", undefined::HEADER].map(OsStr::new);
        link(&tools, folder, &header, Some(&runtime)).map_err(|error| rejection(error, sources))
    })?;
    let path = cache.join(name).join(PROGRAM);
    let image = ProgramImage::new(&bytes).map_err(CosimError::memory(&path))?;
    Ok(Built {
        path,
        image: Arc::new(image),
        is_users: is_users(sources),
        registers: registers.cloned(),
    })
}

/// A model of lanes and what drives it.
pub(super) struct LanesUnit<'a> {
    /// Name and text of the module, if Verilator is to make the model.
    pub(super) verilog: Option<(&'a str, &'a str)>,
    /// What else the compiler is told.
    pub(super) flags: &'a [&'a str],
    /// The testbench.
    pub(super) testbench: &'a str,
    /// Name and text of the header that the testbench includes.
    pub(super) header: (&'a str, &'a str),
}

/// Builds a model of lanes, or finds it built; gives its identity too.
pub(super) fn build_lanes(unit: &LanesUnit, cache: &Path) -> Result<(Built, String), CosimError> {
    let tools = Tools::find(cache)?;
    let mut parts = vec![
        tools.versions.as_str(),
        unit.testbench,
        PROCESS,
        unit.header.1,
        unit.verilog.map_or("", |(_, text)| text),
        env!("CARGO_PKG_VERSION"),
    ];
    parts.extend(unit.flags);
    parts.extend(VERILATOR_FLAGS);
    parts.extend(tools.compiler_flags.iter().map(String::as_str));
    let identity = hash(&parts);
    let name = format!("lanes-{identity}");
    let bytes = once(cache, &name, PROGRAM, |folder| {
        let runtime = match unit.verilog {
            Some((module, text)) => {
                let file = format!("{module}.v");
                write(&folder.join(&file), text)?;
                tools.verilator.run(|command| {
                    command
                        .current_dir(folder)
                        .args(VERILATOR_FLAGS)
                        .args(["--top-module", module, "--Mdir", "."])
                        .arg(&file)
                })?;
                Some(Runtime::of(&tools, cache)?)
            }
            None => None,
        };
        write(&folder.join(unit.header.0), unit.header.1)?;
        write(&folder.join("process.h"), PROCESS)?;
        write(&folder.join("lanes.cpp"), unit.testbench)?;
        let flags: Vec<&OsStr> = unit.flags.iter().map(OsStr::new).collect();
        link(&tools, folder, &flags, runtime.as_ref())
    })?;
    let path = cache.join(name).join(PROGRAM);
    let image = ProgramImage::new(&bytes).map_err(CosimError::memory(&path))?;
    let built = Built {
        path,
        image: Arc::new(image),
        // Lanes that halt say so in their own words.
        is_users: false,
        registers: None,
    };
    Ok((built, identity))
}

/// A board's model and what plays at its pins.
pub(crate) struct BoardUnit<'a> {
    /// The top module.
    pub(crate) top: &'a str,
    /// Verilog of the board and of its surroundings.
    pub(crate) sources: &'a [SourceFile],
    /// Macros of the Verilog.
    pub(crate) defines: &'a [String],
    /// What the compiler is told.
    pub(crate) flags: &'a [String],
    /// The testbench.
    pub(crate) testbench: &'a str,
    /// Name and text of the header that the testbench includes.
    pub(crate) header: (&'a str, &'a str),
}

/// Builds a board, or finds it built.
pub(crate) fn build_board(unit: &BoardUnit, cache: &Path) -> Result<Built, CosimError> {
    let plain = Tools::find(cache)?;
    // It runs for millions of clocks: half of their time for half a second of the compiler's.
    let tools = plain.optimising("-O3");
    let mut parts = vec![tools.versions.as_str(), unit.top, unit.testbench, unit.header.1];
    parts.push(env!("CARGO_PKG_VERSION"));
    parts.extend(VERILATOR_FLAGS);
    let flags = unit.defines.iter().chain(unit.flags).chain(&tools.compiler_flags);
    parts.extend(flags.map(String::as_str));
    parts.extend(unit.sources.iter().flat_map(|source| [&*source.name, &*source.text]));
    let name = format!("board-{}", hash(&parts));
    let bytes = once(cache, &name, PROGRAM, |folder| {
        let rtl = folder.join(RTL);
        fs::create_dir(&rtl).map_err(CosimError::cache(&rtl))?;
        for source in unit.sources {
            write(&rtl.join(&source.name), &source.text)?;
        }
        let verilated = tools.verilator.run(|command| {
            command
                .current_dir(folder)
                .args(VERILATOR_FLAGS)
                .args([BOARD_FLAG, "--top-module", unit.top, "--Mdir", "."])
                .arg(format!("-I{RTL}"))
                .args(unit.defines.iter().map(|define| format!("-D{define}")))
                .args(unit.sources.iter().filter(|s| s.is_compiled()).map(in_build))
        });
        verilated.map_err(|error| rejection(error, unit.sources))?;
        write(&folder.join(unit.header.0), unit.header.1)?;
        // Behind the model's own units.
        write(&folder.join("bench.cpp"), unit.testbench)?;
        let flags: Vec<&OsStr> = unit.flags.iter().map(OsStr::new).collect();
        // A header is of one level of optimisation, and another for boards costs what it saves in four of them.
        let runtime = Runtime { object: library(&plain, cache)?, header: None };
        link(&tools, folder, &flags, Some(&runtime)).map_err(|error| rejection(error, unit.sources))
    })?;
    let path = cache.join(name).join(PROGRAM);
    let image = ProgramImage::new(&bytes).map_err(CosimError::memory(&path))?;
    let (image, is_users) = (Arc::new(image), is_users(unit.sources));
    Ok(Built { path, image, is_users, registers: None })
}

/// Verilator's run-time library: the same for every model, and most of the compiler's work.
struct Runtime {
    /// As object files.
    object: Vec<u8>,
    /// Its headers beside a precompiled one, which saves half of the compiler's work on a model of usual
    /// size. None before a cache's first model, for which it would cost twice what it saves, and
    /// where it cannot be made: what is wrong there is told when the model is compiled.
    header: Option<PathBuf>,
}

impl Runtime {
    fn of(tools: &Tools, cache: &Path) -> Result<Runtime, CosimError> {
        let is_made = cache.join(library_name(tools)).exists();
        let header = is_made.then(|| precompiled(tools, cache)).flatten();
        Ok(Runtime { object: library(tools, cache)?, header })
    }
}

fn library_name(tools: &Tools) -> String {
    entry_name("runtime", tools, RUNTIME)
}

fn library(tools: &Tools, cache: &Path) -> Result<Vec<u8>, CosimError> {
    once(cache, &library_name(tools), RUNTIME_OBJECT, |folder| {
        let all: String = RUNTIME.iter().map(|name| format!("#include \"{name}\"\n")).collect();
        write(&folder.join("runtime.cpp"), &all)?;
        let include = include_flags(tools)?;
        tools.compiler.run(|command| {
            command.current_dir(folder).args(&tools.compiler_flags).args(include).args([
                "-c",
                "runtime.cpp",
                "-o",
                RUNTIME_OBJECT,
            ])
        })?;
        Ok(())
    })
}

/// Name in the cache of what these tools make of some texts.
fn entry_name(kind: &str, tools: &Tools, texts: &[&str]) -> String {
    let mut parts = vec![tools.versions.as_str(), kind];
    parts.extend(texts);
    parts.extend(tools.compiler_flags.iter().map(String::as_str));
    format!("{kind}-{}", hash(&parts))
}

/// The headers of Verilator's run-time library, precompiled.
fn precompiled(tools: &Tools, cache: &Path) -> Option<PathBuf> {
    let name = entry_name("header", tools, &[RUNTIME_HEADER]);
    let made = once(cache, &name, "runtime.h.gch", |folder| {
        write(&folder.join("runtime.h"), RUNTIME_HEADER)?;
        let include = include_flags(tools)?;
        tools.compiler.run(|command| {
            command
                .args(&tools.compiler_flags)
                .args(include)
                .args(["-pthread", "-x", "c++-header"])
                .arg(folder.join("runtime.h"))
                .arg("-o")
                .arg(folder.join("runtime.h.gch"))
        })?;
        Ok(())
    });
    made.ok().map(|_| cache.join(name).join("runtime.h"))
}

fn verilate(
    tools: &Tools,
    top: &str,
    sources: &[SourceFile],
    interface: &Interface,
    registers: Option<&ScanRegisters>,
    folder: &Path,
) -> Result<(), CosimError> {
    if let Some(registers) = registers {
        write(&folder.join(CONFIGURATION), &ports::configuration(registers))?;
    }
    let rtl = folder.join(RTL);
    fs::create_dir(&rtl).map_err(CosimError::cache(&rtl))?;
    for source in sources {
        write(&rtl.join(&source.name), &source.text)?;
    }
    // From within the folder: what is found follows from the sources alone, and the
    // file names in what the tool and the model say are short and known.
    let verilated = tools.verilator.run(|command| {
        command
            .current_dir(folder)
            .args(VERILATOR_FLAGS)
            .args([SAVABLE, "--top-module", top, "--Mdir", "."])
            .arg(format!("-I{RTL}"))
            .args(registers.map(|_| CONFIGURATION))
            // Headers are there to be included.
            .args(sources.iter().filter(|s| s.is_compiled()).map(in_build))
    });
    verilated.map_err(|error| rejection(error, sources))?;
    let header = folder.join(format!("V{top}.h"));
    let text = fs::read_to_string(&header).map_err(CosimError::cache(&header))?;
    let differences = ports::differences(&interface.ports(), &ports::verilated_ports(&text));
    if !differences.is_empty() {
        return Err(CosimError::Ports { top: top.to_owned(), differences });
    }
    if is_users(sources) { check_drivers(tools, top, sources, folder) } else { Ok(()) }
}

/// Refuses nets of several drivers.
fn check_drivers(
    tools: &Tools,
    top: &str,
    sources: &[SourceFile],
    folder: &Path,
) -> Result<(), CosimError> {
    let faults = elaborated(tools, top, sources, folder)?.map(|xml| drivers::faults(&xml));
    let faults = faults.unwrap_or_default();
    if faults.is_empty() {
        return Ok(());
    }
    let output = in_users_terms(&faults.join("\n"), sources);
    Err(CosimError::Rejected { tool: "goldtof", output })
}

/// The elaborated design in XML, of sources that lie in a folder; none of a version of
/// Verilator that does not write it.
pub(super) fn elaborated(
    tools: &Tools,
    top: &str,
    sources: &[SourceFile],
    folder: &Path,
) -> Result<Option<String>, CosimError> {
    let written = tools.verilator.run(|command| {
        command
            .current_dir(folder)
            .args(VERILATOR_FLAGS.iter().filter(|&&flag| flag != "--cc"))
            .args(["--xml-only", "--xml-output", ELABORATED, "--top-module", top, "--Mdir", "."])
            .arg(format!("-I{RTL}"))
            .args(sources.iter().filter(|s| s.is_compiled()).map(in_build))
    });
    match written {
        Ok(_) => {
            let path = folder.join(ELABORATED);
            fs::read_to_string(&path).map(Some).map_err(CosimError::cache(&path))
        }
        // It sees two assignments here, and not where it makes a model.
        Err(CosimError::ToolFailed { ref output, .. }) if !output.contains(&format!("{RTL}/")) => {
            Ok(None)
        }
        Err(error) => Err(rejection(error, sources)),
    }
}

/// Compiles the model and the testbench as one unit, so that the compiler sees
/// through the calls between them, and links it. Neither names the folder, and they are two
/// commands, so that a compiler cache recognises the unit from another folder.
fn link(
    tools: &Tools,
    folder: &Path,
    flags: &[&OsStr],
    runtime: Option<&Runtime>,
) -> Result<(), CosimError> {
    let mut units: Vec<String> = fs::read_dir(folder)
        .map_err(CosimError::cache(folder))?
        .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
        .filter(|name| name.ends_with(".cpp"))
        .collect();
    units.sort();
    let all: String = units.iter().map(|name| format!("#include \"{name}\"\n")).collect();
    write(&folder.join(UNIT), &all)?;
    let mut objects = vec![MODEL_OBJECT];
    let mut include = Vec::new();
    if let Some(runtime) = runtime {
        // The bytes that were checked, and not what the cache has by now.
        let object = folder.join(RUNTIME_OBJECT);
        fs::write(&object, &runtime.object).map_err(CosimError::cache(&object))?;
        objects.push(RUNTIME_OBJECT);
        include.extend(include_flags(tools)?);
        // A compiler takes a precompiled header as the first alone.
        let header = runtime.header.iter().map(|header| header.as_os_str().to_owned());
        include.extend(header.flat_map(|header| ["-include".into(), header]));
    }
    tools.compiler.run(|command| {
        command
            .current_dir(folder)
            .args(&tools.compiler_flags)
            .args(["-I", "."])
            .args(include)
            .args(flags)
            .args(["-pthread", "-c", UNIT, "-o", MODEL_OBJECT])
    })?;
    tools.compiler.run(|command| {
        command
            .current_dir(folder)
            .args(&tools.compiler_flags)
            .args(objects)
            .args(["-o", PROGRAM, "-pthread"])
    })?;
    Ok(())
}

fn include_flags(tools: &Tools) -> Result<[OsString; 2], CosimError> {
    let include = tools.include()?;
    Ok([&include, &include.join("vltstd")].map(|folder| include_flag(folder)))
}

fn include_flag(folder: &Path) -> OsString {
    let mut flag = OsString::from("-I");
    flag.push(folder);
    flag
}
