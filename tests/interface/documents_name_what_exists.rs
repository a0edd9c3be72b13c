//! What documents say of the code and of each other is there: modules, equations and
//! their tests, pages and their headings.

use std::fs;
use std::path::Path;

fn read(path: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(path);
    fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// The section of a document under a heading, to the next one.
fn section(document: &str, heading: &str) -> String {
    let document = read(document);
    let from = document.find(heading).unwrap_or_else(|| panic!("no {heading}"));
    let text = &document[from + heading.len()..];
    text[..text.find("\n## ").unwrap_or(text.len())].to_owned()
}

/// The cells of a section's tables, without their headers.
fn rows(section: &str) -> Vec<Vec<String>> {
    let lines = section.lines().filter(|line| line.starts_with("| "));
    let cells =
        lines.map(|line| line.trim_matches('|').split(" | ").map(|cell| cell.trim().to_owned()));
    cells.map(Iterator::collect).skip(1).collect()
}

/// What stands in backquotes.
fn quoted(cell: &str) -> impl Iterator<Item = &str> {
    cell.split('`').skip(1).step_by(2)
}

/// The lines that define a function or a type of this name, with the comment (and
/// attributes) right before each.
fn definitions(text: &str, name: &str) -> Vec<String> {
    let lines: Vec<&str> = text.lines().collect();
    let defines = |line: &str| {
        ["fn ", "struct "].iter().any(|keyword| {
            line.find(keyword).is_some_and(|at| {
                let rest = &line[at + keyword.len()..];
                let end = rest.find(|c: char| !c.is_alphanumeric() && c != '_');
                let before = line[..at].trim_start();
                !before.starts_with("//") && &rest[..end.unwrap_or(rest.len())] == name
            })
        })
    };
    let places = (0..lines.len()).filter(|&place| defines(lines[place]));
    let with_comment = places.map(|place| {
        // Upwards: an attribute of several lines is from where it ends to where it begins.
        let mut in_attribute = false;
        let is_before = |line: &&&str| {
            let line = line.trim();
            in_attribute |= line.ends_with(")]");
            let is_before = in_attribute || line.starts_with("///") || line.starts_with("#[");
            in_attribute &= !line.starts_with("#[");
            is_before
        };
        let comment: Vec<&str> =
            lines[..place].iter().rev().take_while(is_before).copied().collect();
        comment.into_iter().rev().collect::<Vec<_>>().join(" ")
    });
    with_comment.collect()
}

/// Whether text names an equation: "eq. 15", "eqs. 13 and 26", "eqs. 15 to 17".
fn names_equation(text: &str, number: u32) -> bool {
    text.match_indices("eq").any(|(at, _)| {
        let rest = text[at..].trim_start_matches("eqs").trim_start_matches("eq");
        let Some(rest) = rest.strip_prefix(". ") else {
            return false;
        };
        let end = rest.find(['.', ':', ')', '(', ';']).unwrap_or(rest.len());
        let words = rest[..end].split([' ', ',']);
        let mut last = None;
        let mut to = false;
        for word in words.filter(|word| !matches!(*word, "" | "and" | "///" | "of")) {
            match (word.parse::<u32>(), word) {
                (Ok(named), _) => {
                    let from = if to { last.unwrap_or(named) } else { named };
                    if (from..=named).contains(&number) {
                        return true;
                    }
                    (last, to) = (Some(named), false);
                }
                (Err(_), "to") => to = true,
                (Err(_), _) => return false,
            }
        }
        false
    })
}

#[test]
fn every_equation_is_where_the_index_says_and_has_its_test() {
    let index = rows(&section("docs/physics.md", "## Where the article's equations are"));
    assert!(index.len() > 10, "{index:?}");
    let mut indexed = Vec::new();
    for row in &index {
        let [equations, _, places, test] = &row[..] else {
            panic!("four cells: {row:?}");
        };
        let equations: Vec<u32> = equations.split(", ").map(|e| e.parse().unwrap()).collect();
        for place in quoted(places) {
            let (file, name) = place.split_once("::").unwrap();
            let found = definitions(&read(file), name);
            assert!(!found.is_empty(), "{place} does not exist");
            for equation in &equations {
                let named = found.iter().any(|comment| names_equation(comment, *equation));
                // A row of several equations needs each of them in one of its places.
                let elsewhere = quoted(places).any(|other| {
                    let (file, name) = other.split_once("::").unwrap();
                    let text = read(file);
                    definitions(&text, name).iter().any(|c| names_equation(c, *equation))
                });
                assert!(
                    named || (equations.len() > 1 && elsewhere),
                    "{place} does not name eq. {equation}: {found:?}"
                );
            }
        }
        for place in quoted(test) {
            let (file, name) = place.split_once("::").unwrap();
            let text = read(file);
            assert!(!definitions(&text, name).is_empty(), "{place} does not exist");
            assert!(text.contains("#[test]") || text.contains("proptest!"), "{place}");
        }
        indexed.extend(equations);
    }
    for equation in [5, 7, 8, 9, 11, 13, 14, 15, 16, 17, 20, 21, 23, 24, 25, 26] {
        assert!(indexed.contains(&equation), "eq. {equation} is not in the index");
    }
}

#[test]
fn equations_are_found_in_the_ways_that_people_write_them() {
    assert!(names_equation("/// (eqs. 15 to 17 in their", 16));
    assert!(names_equation("/// w of eqs. 5 and 14.", 14));
    assert!(names_equation("/// are eqs. 12 and 14, which follow from eq. 26:", 26));
    assert!(!names_equation("/// (eq. 15), 16 samples", 16));
    assert!(!names_equation("/// equals. 15 of them", 15));
}

/// The packages of the workspace, and the program's own folder.
fn packages() -> Vec<String> {
    let manifest: toml::Table = read("Cargo.toml").parse().unwrap();
    let members = manifest["workspace"]["members"].as_array().unwrap();
    let names = members.iter().map(|member| member.as_str().unwrap().to_owned());
    names.chain([String::new()]).collect()
}

#[test]
fn every_module_is_in_the_table_and_every_row_is_a_module() {
    let table = rows(&section("DESIGN.md", "## The way of a scene"));
    let named: Vec<String> = table
        .iter()
        .flat_map(|row| quoted(&row[0]).map(str::to_owned).collect::<Vec<_>>())
        .collect();
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let is_there = |name: &String| {
        packages().iter().any(|package| {
            let path = root.join(package).join("src").join(name.replace("::", "/"));
            name == package || path.is_dir() || path.with_extension("rs").is_file()
        })
    };
    for name in &named {
        assert!(is_there(name), "{name}");
    }
    for package in ["", "estimation", "hardware", "physics", "sensor", "system", "verification"] {
        let declared = read(format!("{package}/src/lib.rs").trim_start_matches('/'));
        let modules = declared.lines().filter_map(|line| {
            let line = line.trim_start_matches("pub ").trim_start_matches("pub(crate) ");
            line.strip_prefix("mod ")?.strip_suffix(';')
        });
        for module in modules {
            let is_named = |name: &String| name.split("::").next() == Some(module);
            assert!(named.iter().any(is_named), "{module} is not in DESIGN's table");
        }
    }
}

/// Every page of the guide, README, DESIGN and the rest, by its path.
fn documents() -> Vec<String> {
    let mut names: Vec<String> =
        ["README.md", "DESIGN.md", "CHANGELOG.md", "CONTRIBUTING.md"].map(str::to_owned).into();
    let others = ["hdl/README.md", "examples/own-rtl/README.md", "benches/estimators/README.md"];
    names.extend(others.map(str::to_owned));
    names.extend(pages().into_iter().map(|page| format!("docs/{page}")));
    names
}

/// The files of docs/ that are Markdown.
fn pages() -> Vec<String> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs");
    let files = fs::read_dir(folder).unwrap();
    let names = files.map(|file| file.unwrap().file_name().into_string().unwrap());
    names.filter(|name| name.ends_with(".md")).collect()
}

/// Targets of the links of a text, outside of its fenced blocks.
fn links(text: &str) -> Vec<String> {
    let outside = text.split("```").step_by(2).collect::<String>();
    let targets = outside.split("](").skip(1);
    let targets = targets.filter_map(|rest| rest.split_once(')').map(|(target, _)| target));
    targets.map(str::to_owned).collect()
}

/// What a heading's link is, as GitHub and mdBook make it.
fn anchor(heading: &str) -> String {
    let kept = heading.trim_start_matches('#').trim().to_lowercase();
    let kept = kept.chars().filter_map(|c| match c {
        ' ' | '-' => Some('-'),
        c if c.is_alphanumeric() || c == '_' => Some(c),
        _ => None,
    });
    kept.collect()
}

#[test]
fn links_between_documents_lead_somewhere() {
    let mut followed = 0;
    for name in documents() {
        let folder = Path::new(&name).parent().unwrap().to_owned();
        for link in links(&read(&name)) {
            if link.starts_with("http") {
                continue;
            }
            let (file, heading) = link.split_once('#').unwrap_or((&link, ""));
            let target = match file {
                "" => Path::new(&name).to_owned(),
                file => folder.join(file),
            };
            let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(&target);
            assert!(path.exists(), "{name}: {link}");
            if !heading.is_empty() {
                let text = read(target.to_str().unwrap());
                let headings = text.lines().filter(|line| line.starts_with('#'));
                let is_there = headings.map(anchor).any(|anchor| anchor == heading);
                assert!(is_there, "{name}: {link}");
            }
            followed += 1;
        }
    }
    assert!(followed > 60, "{followed}");
}

/// mdBook makes no page of a file that its summary does not name.
#[test]
fn the_summary_has_every_page_once() {
    let mut named = links(&read("docs/SUMMARY.md"));
    let mut there = pages();
    there.retain(|page| page != "SUMMARY.md");
    named.sort();
    there.sort();
    assert_eq!(named, there);
    for page in there {
        let text = read(&format!("docs/{page}"));
        assert!(text.starts_with("# "), "{page} has no title");
    }
}
