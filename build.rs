//! Tells release builds which commit they are of: git's, or what packagers set
//! `GOLDTOF_COMMIT` to.
//!
//! Builds for development do not ask git: they would be built anew after every commit.
//! Outside of a git checkout, or without git, there is no commit to tell.

use std::process::Command;

fn main() {
    println!("cargo::rerun-if-env-changed=GOLDTOF_COMMIT");
    println!("cargo::rerun-if-changed=build.rs");
    let package = env!("CARGO_PKG_VERSION");
    let version = match commit() {
        Some(commit) => format!("{package} ({commit})"),
        None => package.to_owned(),
    };
    println!("cargo::rustc-env=GOLDTOF_VERSION={version}");
}

/// The commit, if there is one to tell; with `-modified` if files differ from it.
fn commit() -> Option<String> {
    if let Ok(commit) = std::env::var("GOLDTOF_COMMIT") {
        return Some(commit).filter(|commit| !commit.is_empty());
    }
    if std::env::var("PROFILE").as_deref() != Ok("release") {
        return None;
    }
    // A package that lies in somebody else's repository is not of their commit.
    git(&["ls-files", "--error-unmatch", "Cargo.toml"])?;
    let log = git(&["rev-parse", "--git-path", "logs/HEAD"])?;
    for watched in [log.as_str(), "src", "macros/src", "fft/src", "Cargo.toml"] {
        println!("cargo::rerun-if-changed={watched}");
    }
    let commit = git(&["rev-parse", "--short=10", "HEAD"])?;
    let changes = git(&["status", "--porcelain", "--untracked-files=no"])?;
    let modified = if changes.is_empty() { "" } else { "-modified" };
    Some(format!("{commit}{modified}"))
}

/// What git says; none if it fails.
fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").args(arguments).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| text.trim().to_owned())
}
