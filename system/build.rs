//! Tells the program which commit it is made from.

use std::process::Command;

/// What git says, in one line; none without git or without its folder.
fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").args(arguments).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| text.trim().to_owned())
}

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    // Builds to develop with need not be made anew for each commit.
    let is_release = std::env::var("PROFILE").is_ok_and(|profile| profile == "release");
    let commit = match is_release {
        true => git(&["rev-parse", "--short=12", "HEAD"]),
        false => None,
    };
    if commit.is_some() {
        for name in ["HEAD", "logs/HEAD"] {
            if let Some(path) = git(&["rev-parse", "--git-path", name]) {
                println!("cargo::rerun-if-changed={path}");
            }
        }
    }
    let text = commit.map_or(String::new(), |commit| format!(" ({commit})"));
    println!("cargo::rustc-env=GOLDTOF_COMMIT={text}");
}
