//! A power cut leaves what is on the disk: contents that were synced, and names
//! of folders that were. A library between goldtof and the system writes down
//! what is written, synced, renamed and removed; the order is checked here.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use super::support::*;

const RECORDER: &str = r#"
#define _GNU_SOURCE
#include <dlfcn.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/syscall.h>
#include <sys/types.h>
#include <fcntl.h>
#include <unistd.h>

static void record(const char *what, const char *first, const char *second) {
    char line[2 * PATH_MAX + 32];
    int n = snprintf(line, sizeof line, "%s\t%s\t%s\n", what, first, second);
    int log = syscall(SYS_openat, AT_FDCWD, getenv("RECORD"), O_WRONLY | O_APPEND | O_CREAT, 0600);
    syscall(SYS_write, log, line, n);
    syscall(SYS_close, log);
}
static void record_open(const char *what, int fd) {
    char link[64], path[PATH_MAX];
    snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
    ssize_t n = readlink(link, path, sizeof path - 1);
    if (n > 0) { path[n] = 0; record(what, path, ""); }
}
#define NEXT(name) ((__typeof__(&name))dlsym(RTLD_NEXT, #name))
ssize_t write(int fd, const void *b, size_t n) { record_open("write", fd); return NEXT(write)(fd, b, n); }
int fsync(int fd) { int r = NEXT(fsync)(fd); record_open("sync", fd); return r; }
int rename(const char *a, const char *b) { int r = NEXT(rename)(a, b); record("rename", a, b); return r; }
int unlink(const char *a) { int r = NEXT(unlink)(a); if (r == 0) record("unlink", a, ""); return r; }
"#;

/// What happened, in order, to files below `out`.
fn record(folder: &Path, arguments: &[&str], out: &Path) -> Vec<[String; 3]> {
    let (source, library) = (folder.join("recorder.c"), folder.join("recorder.so"));
    fs::write(&source, RECORDER).unwrap();
    let mut compiler = Command::new("gcc");
    compiler.args(["-shared", "-fPIC", "-w", "-o", text(&library), text(&source)]);
    ends_with(0, &mut compiler);
    let log = folder.join("log");
    let _ = fs::remove_file(&log);
    let mut command = goldtof(arguments);
    command.env("LD_PRELOAD", &library).env("RECORD", &log);
    ends_with(0, &mut command);
    let out = text(out);
    let log = fs::read_to_string(&log).unwrap();
    let events = log.lines().map(|line| {
        let mut fields = line.split('\t').map(str::to_owned);
        std::array::from_fn(|_| fields.next().unwrap())
    });
    events.filter(|[_, path, _]| path.starts_with(out)).collect()
}

fn folder_of(path: &str) -> &str {
    text(Path::new(path).parent().unwrap())
}

/// Checks that every file has its contents on the disk before its name, and each
/// folder its names at the end; gives the names in the order they were given.
fn check(events: &[[String; 3]]) -> Vec<PathBuf> {
    let is_sync = |event: &[String; 3], path: &str| event[0] == "sync" && event[1] == path;
    let mut named = Vec::new();
    for (at, [what, path, name]) in events.iter().enumerate() {
        let changed = match what.as_str() {
            "rename" => {
                let before = events[..at].iter().rev();
                let last = before.clone().find(|[_, other, _]| other == path);
                assert!(last.is_some_and(|event| is_sync(event, path)), "{name} is not synced");
                named.push(PathBuf::from(name));
                name
            }
            "unlink" => path,
            _ => continue,
        };
        let is_hidden_one = changed.contains(".goldtof-partial");
        let mut later = events[at..].iter();
        assert!(
            is_hidden_one || later.any(|event| is_sync(event, folder_of(changed))),
            "the folder of {changed} is not synced"
        );
    }
    named
}

#[test]
fn contents_are_synced_before_names_and_names_before_the_end() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("new/out");
    let scene = folder.path().join("scene.toml");
    // The second time there is an older design, whose manifest has to go first, and the third time the same.
    for integration in ["80 us", "90 us", "90 us"] {
        integrating_for(integration, &scene);
        let older = files_below(&out);
        let events =
            record(folder.path(), &["emit", text(&scene), "--out", text(&out)], folder.path());
        let newer = files_below(&out);
        let changed = newer.iter().filter(|(path, text)| older.get(*path) != Some(text)).count();
        let named = check(&events);
        assert_eq!(named.len(), changed);
        if changed == 0 {
            assert!(events.is_empty(), "{events:?}");
            continue;
        }
        assert_eq!(named.last().unwrap(), &out.join("manifest.json"));
        let renames: Vec<usize> = (0..events.len()).filter(|&i| events[i][0] == "rename").collect();
        let manifest = *renames.last().unwrap();
        let synced = |range: std::ops::Range<usize>| {
            events[range].iter().any(|[what, path, _]| what == "sync" && path == text(&out))
        };
        for &renamed in &renames[..renames.len() - 1] {
            let folder = folder_of(&events[renamed][2]);
            let mut later = events[renamed..manifest].iter();
            assert!(
                later.any(|[what, path, _]| what == "sync" && path == folder),
                "{folder} is not synced before the manifest's name"
            );
        }
        let gone = events.iter().position(|[what, path, _]| {
            what == "unlink" && path == text(&out.join("manifest.json"))
        });
        if let Some(gone) = gone {
            assert!(synced(gone..renames[0]), "after the older manifest is gone");
        } else {
            assert!(events.iter().any(|[what, path, _]| {
                what == "sync" && path == text(&folder.path().join("new"))
            }));
        }
    }
}

#[test]
fn reports_figures_and_waveforms_are_synced_as_well() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let events = record(folder.path(), &["run", QUICK, "--out", text(&out)], &out);
    let named = check(&events);
    assert_eq!(named.last().unwrap(), &out.join("report.html"));
    assert!(named.contains(&out.join("counts.csv")));
    let waves = out.join("a.vcd");
    let arguments = ["cosim", QUICK, "--stimulus", "adversarial", "--vcd", text(&waves)];
    // Once to find out whether it can be made, and once to make it.
    let views = ["a.gtkw", "a.sucl", "a.do"].map(|name| out.join(name));
    let named = check(&record(folder.path(), &arguments, &out));
    assert_eq!(named, [&[waves][..], &views].concat());
}
