//! Links, pipes and files that somebody else has put where goldtof's own go.

use std::fs;
use std::os::unix::fs::{PermissionsExt as _, chown, symlink};
use std::os::unix::process::CommandExt as _;
use std::path::Path;
use std::process::Command;

use super::support::*;

fn pipe(path: &Path) {
    assert!(Command::new("mkfifo").arg(path).status().unwrap().success());
}

/// Puts something in the place of a path.
type Plant<'a> = &'a dyn Fn(&Path);

/// As [`goldtof`], but ended after a minute: nothing here may wait for anyone.
fn bounded(arguments: &[&str]) -> Command {
    let mut command = Command::new("timeout");
    command.arg("60").arg(env!("CARGO_BIN_EXE_goldtof"));
    command.args(arguments);
    command
}

#[test]
fn a_hidden_name_that_leads_elsewhere_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let victim = folder.path().join("victim");
    fs::write(&victim, "precious").unwrap();
    let plants: [(&str, Plant); 4] = [
        ("a symbolic link", &|at| symlink(&victim, at).unwrap()),
        ("a symbolic link", &|at| symlink("../elsewhere", at).unwrap()),
        ("a hard link", &|at| fs::hard_link(&victim, at).unwrap()),
        ("a pipe", &|at| pipe(at)),
    ];
    for (number, (kind, plant)) in plants.into_iter().enumerate() {
        let out = folder.path().join(number.to_string());
        for (command, name) in [("run", "counts.csv"), ("emit", "sensor_top.v")] {
            let out = out.join(command);
            fs::create_dir_all(&out).unwrap();
            let hidden = out.join(format!(".{name}.goldtof-partial"));
            plant(&hidden);
            let told = ends_with(2, &mut bounded(&[command, QUICK, "--out", text(&out)]));
            let expected = format!("{name}: cannot write the file: {}: ", hidden.display());
            assert!(told.contains(&expected) && told.contains(kind), "{told}");
            assert!(!out.join(name).exists());
        }
        assert!(!out.join("elsewhere").exists() && !folder.path().join("elsewhere").exists());
    }
    assert_eq!(fs::read_to_string(&victim).unwrap(), "precious");
}

#[test]
fn files_of_the_output_folder_replace_links_and_leave_their_targets() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    fs::create_dir_all(&out).unwrap();
    let victim = folder.path().join("victim");
    fs::write(&victim, "precious").unwrap();
    for name in ["sensor_top.v", "sensor_top.xdc", "manifest.json"] {
        symlink(&victim, out.join(name)).unwrap();
    }
    symlink("../nowhere", out.join("sensor_top.sdc")).unwrap();
    fs::hard_link(&victim, out.join("sensor_top.f")).unwrap();
    // The folder itself may be a link: that is the user's wish.
    let link = folder.path().join("link");
    symlink("out", &link).unwrap();
    ends_with(0, &mut bounded(&["emit", QUICK, "--out", text(&link)]));
    assert_eq!(files_below(&out), emitted(QUICK));
    assert!(fs::read_dir(&out).unwrap().all(|e| !e.unwrap().file_type().unwrap().is_symlink()));
    assert_eq!(fs::read_to_string(&victim).unwrap(), "precious");
    assert!(!folder.path().join("nowhere").exists());
}

#[test]
fn pipes_and_devices_under_our_names_are_named_and_not_waited_for() {
    for name in ["manifest.json", "sensor_top.v", "sensor_top.core"] {
        let folder = tempfile::tempdir().unwrap();
        pipe(&folder.path().join(name));
        let out = text(folder.path());
        let told = ends_with(2, &mut bounded(&["emit", QUICK, "--out", out]));
        let expected = format!("{name}: cannot write the file: a pipe is there");
        assert!(told.contains(&expected), "{told}");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("elsewhere")).unwrap();
    symlink("elsewhere", folder.path().join("rtl")).unwrap();
    let told = ends_with(2, &mut bounded(&["run", QUICK, "--out", text(folder.path())]));
    assert!(told.contains("rtl: cannot make the folder: a symbolic link"), "{told}");
    assert!(files_below(&folder.path().join("elsewhere")).is_empty());
}

#[test]
fn waveforms_go_through_a_pipe_that_is_read_and_wait_for_no_reader() {
    let folder = tempfile::tempdir().unwrap();
    let waves = folder.path().join("a.vcd");
    pipe(&waves);
    let arguments = ["cosim", QUICK, "--stimulus", "adversarial", "--vcd", text(&waves)];
    let told = ends_with(2, &mut bounded(&arguments));
    assert!(told.contains("nobody reads this pipe"), "{told}");
    // All is read, and so much kept as a pipe holds while nobody looks.
    let keep = "exec < \"$0\"; head -c 10; cat > /dev/null";
    let reader = start(Command::new("timeout").args(["60", "sh", "-c", keep, text(&waves)]));
    ends_with(0, &mut bounded(&arguments));
    let read = reader.wait_with_output().unwrap();
    assert!(String::from_utf8_lossy(&read.stdout).starts_with("$timescale"));
}

fn cosim(cache: &Path) -> Command {
    let mut command = bounded(&["cosim", QUICK, "--stimulus", "adversarial", "--quiet"]);
    command.env("GOLDTOF_CACHE_DIR", cache);
    command
}

#[test]
fn a_cache_that_others_can_write_to_or_own_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let cache = folder.path().join("outer/cache");
    fs::create_dir_all(&cache).unwrap();
    let set = |path: &Path, mode| {
        fs::set_permissions(path, fs::Permissions::from_mode(mode)).unwrap();
    };
    let refused = |reason: &str| {
        let told = ends_with(2, &mut cosim(&cache));
        assert!(told.contains("cannot keep built models here"), "{told}");
        assert!(told.contains(reason) && told.contains("GOLDTOF_CACHE_DIR"), "{told}");
        assert!(fs::read_dir(&cache).unwrap().next().is_none());
    };
    let outer = folder.path().join("outer");
    for path in [&cache, &outer] {
        for mode in [0o777, 0o775, 0o702] {
            set(path, mode);
            refused("others can write there");
        }
        set(path, 0o755);
    }
    // Only root can give a folder away.
    for path in [&cache, &outer] {
        if chown(path, Some(12_345), None).is_ok() {
            refused("belongs to user 12345");
            chown(path, Some(0), None).unwrap();
        }
    }
}

#[test]
fn a_model_of_another_user_and_a_lock_that_is_a_link_are_refused() {
    let cache = cache_without_models();
    let victim = cache.path().join("victim");
    fs::write(&victim, "precious").unwrap();
    ends_with(0, &mut cosim(cache.path()));
    let model = entries(cache.path(), "model-").remove(0);
    let library = model.join("sensor");
    if chown(&library, Some(12_345), None).is_ok() {
        let told = ends_with(2, &mut cosim(cache.path()));
        assert!(told.contains("belongs to user 12345"), "{told}");
        chown(&library, Some(0), None).unwrap();
    }
    fs::remove_dir_all(&model).unwrap();
    let lock = model.with_extension("lock");
    for plant in ["link", "pipe"] {
        fs::remove_file(&lock).unwrap();
        match plant {
            "link" => symlink(&victim, &lock).unwrap(),
            _ => pipe(&lock),
        }
        let told = ends_with(2, &mut cosim(cache.path()));
        assert!(told.contains(".lock") && told.contains("remove it"), "{told}");
    }
    assert_eq!(fs::read_to_string(&victim).unwrap(), "precious");
}

#[test]
fn without_a_home_the_temporary_folder_is_no_cache() {
    let folder = tempfile::tempdir().unwrap();
    let open = |path: &Path| fs::set_permissions(path, fs::Permissions::from_mode(0o755)).unwrap();
    open(folder.path());
    let program = folder.path().join("program");
    super::support::program(&program, fs::File::open(env!("CARGO_BIN_EXE_goldtof")).unwrap());
    let scene = folder.path().join("quick.toml");
    fs::copy(QUICK, &scene).unwrap();
    let temporary = folder.path().join("tmp");
    fs::create_dir_all(temporary.join("goldtof")).unwrap();
    let mut command = Command::new(&program);
    command.args(["cosim", text(&scene)]).current_dir(folder.path());
    for name in ["HOME", "XDG_CACHE_HOME", "GOLDTOF_CACHE_DIR"] {
        command.env_remove(name);
    }
    command.env("TMPDIR", &temporary);
    // A user that the system does not know has no home at all; only root can be another.
    if rustix::process::geteuid().is_root() {
        command.uid(54_321).gid(54_321);
        let told = ends_with(2, &mut command);
        assert!(told.contains("the user has no home; set GOLDTOF_CACHE_DIR"), "{told}");
    }
    assert!(fs::read_dir(temporary.join("goldtof")).unwrap().next().is_none());
}
