//! No module needs one that needs it: read from what the sources name, `pub use` followed to
//! where a thing is defined. A module's own submodules are part of it, so that what they take
//! from it counts for nothing.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// From the crate's root to a module, or to what is in one.
type Names = Vec<String>;

/// What a module's text names.
#[derive(Default)]
struct Module {
    /// What it hands on under a name, or has imported under one.
    aliases: BTreeMap<String, Names>,
    /// What it has under a name from other packages: cargo keeps watch there.
    outside: BTreeSet<String>,
    /// Modules all of whose names it takes, or hands on.
    globs: Vec<Names>,
    /// All that it takes from elsewhere.
    needs: Vec<Names>,
    /// The words of its text.
    words: BTreeSet<String>,
}

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
}

/// Where a file is in the tree of modules; `None` of the program and of tests.
fn place(file: &Path, root: &Path) -> Option<Names> {
    let inside = file.strip_prefix(root).unwrap().with_extension("");
    let mut names: Names = inside.iter().map(|part| part.to_str().unwrap().to_owned()).collect();
    match names.last().map(String::as_str) {
        Some("main" | "tests") => return None,
        Some("mod" | "lib") => {
            names.pop();
        }
        _ => {}
    }
    Some(names)
}

/// The words and signs of a source, without comments, texts and the tests at its end.
fn tokens(source: &str) -> Vec<String> {
    let source = source.split("#[cfg(test)]\nmod tests").next().unwrap();
    let mut tokens: Vec<String> = Vec::new();
    let mut rest = source;
    while let Some(first) = rest.chars().next() {
        let is_word = |c: char| c.is_alphanumeric() || c == '_';
        let length = if rest.starts_with("//") {
            rest.find('\n').unwrap_or(rest.len())
        } else if let Some(raw) = rest.strip_prefix("r#\"") {
            raw.find("\"#").unwrap() + 5
        } else if let Some(text) = rest.strip_prefix('"') {
            end_of_text(text) + 2
        } else if let Some(quoted) = rest.strip_prefix('\'') {
            length_of_quoted(quoted)
        } else if is_word(first) {
            let length = rest.find(|c| !is_word(c)).unwrap_or(rest.len());
            tokens.push(rest[..length].to_owned());
            length
        } else if rest.starts_with("::") {
            tokens.push("::".to_owned());
            2
        } else {
            if !first.is_whitespace() {
                tokens.push(first.to_string());
            }
            first.len_utf8()
        };
        rest = &rest[length..];
    }
    tokens
}

/// Where a text ends whose opening quotation mark is behind.
fn end_of_text(text: &str) -> usize {
    let mut is_escaped = false;
    for (at, c) in text.char_indices() {
        match c {
            '"' if !is_escaped => return at,
            '\\' => is_escaped = !is_escaped,
            _ => is_escaped = false,
        }
    }
    panic!("a text without an end: {text}");
}

/// Length of a character in quotation marks, or of the mark before a lifetime.
fn length_of_quoted(quoted: &str) -> usize {
    let mut chars = quoted.chars();
    match chars.next() {
        Some('\\') => quoted[2..].find('\'').unwrap() + 4,
        Some(c) if chars.next() == Some('\'') => c.len_utf8() + 2,
        _ => 1,
    }
}

/// The paths of a `use` from `at` on, each with its name, and where it ends.
fn tree(tokens: &[String], mut at: usize, before: &Names) -> (Vec<(Names, String)>, usize) {
    let mut path = before.clone();
    let mut name = None;
    loop {
        match tokens[at].as_str() {
            "{" => {
                let mut all = Vec::new();
                at += 1;
                while tokens[at] != "}" {
                    let (some, end) = tree(tokens, at, &path);
                    all.extend(some);
                    at = end + usize::from(tokens[end] == ",");
                }
                return (all, at + 1);
            }
            "as" => {
                name = Some(tokens[at + 1].clone());
                at += 2;
            }
            "," | ";" | "}" => break,
            "::" | "self" if path.len() > before.len() || !before.is_empty() => at += 1,
            "::" => at += 1,
            word => {
                path.push(word.to_owned());
                at += 1;
            }
        }
    }
    let name = name.or_else(|| path.last().cloned()).unwrap_or_default();
    (vec![(path, name)], at)
}

/// A path as it is written in module `here`, from the crate's root; `None` if it leads out of
/// the crate.
fn from_root(path: &[String], here: &Names, modules: &BTreeSet<Names>) -> Option<Names> {
    let mut from = here.clone();
    let mut rest = path;
    match rest.first()?.as_str() {
        "crate" => {
            from.clear();
            rest = &rest[1..];
        }
        "self" => rest = &rest[1..],
        "super" => {
            while rest.first().is_some_and(|name| name == "super") {
                from.pop();
                rest = &rest[1..];
            }
        }
        first => {
            let inner = [&here[..], &[first.to_owned()]].concat();
            modules.contains(&inner).then_some(())?;
        }
    }
    Some([&from[..], rest].concat())
}

fn read(source: &str, here: &Names, modules: &BTreeSet<Names>) -> Module {
    let tokens = tokens(source);
    let mut module = Module::default();
    let mut at = 0;
    while at < tokens.len() {
        let begins_path = ["crate", "super", "self"].contains(&tokens[at].as_str())
            && tokens.get(at + 1).is_some_and(|next| next == "::");
        // `use<>` says which lifetimes a type captures.
        if tokens[at] == "use" && tokens[at + 1] != "<" {
            let hands_on = at > 0 && (tokens[at - 1] == "pub" || tokens[at - 1] == ")");
            let (paths, end) = tree(&tokens, at + 1, &Names::new());
            for (path, name) in paths {
                let Some(mut path) = from_root(&path, here, modules) else {
                    module.outside.insert(name);
                    continue;
                };
                if name == "*" {
                    path.pop();
                    module.globs.push(path);
                    continue;
                }
                if !hands_on {
                    module.needs.push(path.clone());
                }
                module.aliases.insert(name, path);
            }
            at = end;
        } else if begins_path {
            let mut path = vec![tokens[at].clone()];
            while tokens.get(at + 1).is_some_and(|next| next == "::")
                && tokens[at + 2].starts_with(|c: char| c.is_alphabetic())
            {
                path.push(tokens[at + 2].clone());
                at += 2;
            }
            module.needs.extend(from_root(&path, here, modules));
            at += 1;
        } else {
            at += 1;
        }
    }
    module.words = tokens.into_iter().collect();
    module
}

/// The module that defines what a path leads to; `None` if another package does. Of a door's
/// function and a module of another package with one name the module is taken.
fn defined_in(path: &Names, modules: &BTreeMap<Names, Module>) -> Option<Names> {
    let mut path = path.clone();
    for _ in 0..20 {
        let depth =
            (0..=path.len()).rev().find(|&depth| modules.contains_key(&path[..depth])).unwrap();
        let (module, rest) = path.split_at(depth);
        if rest.first().is_some_and(|name| modules[module].outside.contains(name)) {
            return None;
        }
        let next = rest.first().and_then(|name| modules[module].aliases.get(name));
        match next {
            Some(next) => path = [&next[..], &rest[1..]].concat(),
            None => return Some(module.to_vec()),
        }
    }
    panic!("{path:?} leads round and round");
}

/// The modules that every module needs. Of a module all of whose names it takes, those are
/// needed that hand a name on to it that its text has.
fn arrows(modules: &BTreeMap<Names, Module>) -> BTreeMap<&Names, BTreeSet<Names>> {
    let through = |glob: &Names, words: &BTreeSet<String>| {
        let from = defined_in(glob, modules).map(|there| &modules[&there]);
        let named = from.into_iter().flat_map(|from| &from.aliases);
        let used = named.filter(|(name, _)| words.contains(*name)).map(|(_, path)| path);
        let all = from.into_iter().flat_map(|from| &from.globs);
        [glob].into_iter().chain(used).chain(all).cloned().collect::<Vec<_>>()
    };
    let needs = |(here, module): (&Names, &Module)| {
        let globs = module.globs.iter().flat_map(|glob| through(glob, &module.words));
        let paths = module.needs.iter().cloned().chain(globs);
        let needed = paths.filter_map(|path| defined_in(&path, modules));
        needed.filter(|there| !here.starts_with(there)).collect()
    };
    modules.iter().map(|entry| (entry.0, needs(entry))).collect()
}

/// The modules of some sources, each with its place, that are in circles or between them.
fn in_circles(sources: &[(Names, String)]) -> Vec<String> {
    let places: BTreeSet<Names> = sources.iter().map(|(place, _)| place.clone()).collect();
    let modules: BTreeMap<Names, Module> = sources
        .iter()
        .map(|(place, source)| (place.clone(), read(source, place, &places)))
        .collect();
    let mut left = arrows(&modules);
    // What needs nothing that is left, or what nothing needs, is in no circle.
    loop {
        let before = left.len();
        let places: BTreeSet<Names> = left.keys().map(|&place| place.clone()).collect();
        left.retain(|_, needs| needs.iter().any(|need| places.contains(need)));
        let needed: BTreeSet<Names> = left.values().flatten().cloned().collect();
        left.retain(|place, _| needed.contains(*place));
        if left.len() == before {
            break;
        }
    }
    left.keys().map(|place| place.join("::")).collect()
}

#[test]
fn no_module_needs_one_that_needs_it() {
    let mut modules = 0;
    // Between packages cargo keeps watch.
    for package in ["", "estimation", "hardware", "physics", "sensor", "system", "verification"] {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join(package).join("src");
        let mut files = Vec::new();
        sources(&root, &mut files);
        let sources: Vec<(Names, String)> = files
            .iter()
            .filter_map(|file| Some((place(file, &root)?, fs::read_to_string(file).unwrap())))
            .collect();
        modules += sources.len();
        assert_eq!(in_circles(&sources), Vec::<String>::new(), "{package}");
    }
    assert!(modules > 300, "{modules}");
}

#[test]
fn circles_are_found_through_names_that_are_handed_on() {
    let scene = |c: &str| {
        let sources = [
            (&[][..], "pub mod a; pub mod b;"),
            (&["a"], "mod c;\npub use self::c::Of as A;\nuse crate::b::{self, B};"),
            (&["a", "c"], c),
            (&["d"], "pub use crate::b::{B, D};"),
            (&["b"], "fn f() -> super::a::A { \"use crate::a::x;\" } // use crate::a::y;"),
        ];
        let owned = sources.map(|(place, text)| {
            let place = place.iter().map(|&name| name.to_owned()).collect();
            (place, text.to_owned())
        });
        in_circles(&owned)
    };
    assert_eq!(scene("use super::A; struct Of;"), Vec::<String>::new());
    assert_eq!(scene("use crate::{b::B as X, a};"), ["a::c", "b"]);
    // Through a module that hands names on, those that are used.
    assert_eq!(scene("use crate::b::*; struct Of;"), ["a::c", "b"]);
    assert_eq!(scene("use crate::d::*; struct Of(B);"), ["a::c", "b"]);
    assert_eq!(scene("use crate::d::*; struct Of(C);"), Vec::<String>::new());
    assert_eq!(scene("fn g() { crate::b::B::new('\"') }"), ["a::c", "b"]);
}
