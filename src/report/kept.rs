//! What theory tells the report, kept from run to run: it depends on the scene and the program alone.

use std::cell::LazyCell;
use std::fmt::Debug;
use std::path::Path;

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::cosim::build::{hash, once, write};
use crate::scene::Scene;

/// File of the cache's folder.
const THEORY: &str = "theory.json";

/// What the cache has of a scene's theory, as `program` told it, or `theory` tells, which is kept. `program`
/// changes with whatever changes it, and a scene's key is all that it says. What JSON does not hold to the last
/// bit is not kept, nor is anything in a cache that cannot be had: theory is asked then.
pub(crate) fn kept<T: Data>(
    cache: &Path,
    program: &str,
    scene: &Scene,
    theory: impl FnOnce() -> T,
) -> T {
    let name = format!("theory-{}", hash(&["theory", program, &format!("{scene:?}")]));
    let told = LazyCell::new(theory);
    let found = once(cache, &name, THEORY, |folder| {
        write(&folder.join(THEORY), &text(&*told).unwrap_or_default())
    });
    let read = found.ok().and_then(|text| serde_json::from_slice(&text).ok());
    read.unwrap_or_else(|| T::clone(&told))
}

/// What may be kept.
pub(crate) trait Data: Serialize + DeserializeOwned + Debug + Clone {}

impl<T: Serialize + DeserializeOwned + Debug + Clone> Data for T {}

/// As JSON, if that holds it.
fn text<T: Data>(told: &T) -> Option<String> {
    let text = serde_json::to_string(told).ok()?;
    let read: T = serde_json::from_str(&text).ok()?;
    (format!("{read:?}") == format!("{told:?}")).then_some(text)
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;
    use std::fs;
    use std::path::PathBuf;
    use std::sync::atomic::{AtomicU32, Ordering};
    use std::thread;

    use super::*;
    use crate::report::curves::IntegrationCurves;
    use crate::scene::load_with;
    use crate::sensor::Sensor;

    fn scene(settings: &[&str]) -> Scene {
        let settings: Vec<_> = settings.iter().map(|text| text.parse().unwrap()).collect();
        load_with(Path::new("scenes/quick.toml"), &settings).unwrap()
    }

    /// The theory of a scene, and whether it was worked out.
    fn ask(cache: &Path, program: &str, scene: &Scene) -> (String, bool) {
        let asked = Cell::new(false);
        let told = kept(cache, program, scene, || {
            asked.set(true);
            IntegrationCurves::of_first_paths(&Sensor::new(scene))
        });
        (format!("{told:?}"), asked.get())
    }

    fn files(cache: &Path) -> Vec<PathBuf> {
        let folders = fs::read_dir(cache).unwrap().map(|entry| entry.unwrap().path());
        folders.map(|folder| folder.join(THEORY)).filter(|file| file.is_file()).collect()
    }

    #[test]
    fn theory_is_told_again_to_the_last_bit_until_scene_or_program_change() {
        let cache = tempfile::tempdir().unwrap();
        let (quick, farther) = (scene(&[]), scene(&["path.distance=3.3 m"]));
        let (told, asked) = ask(cache.path(), "one", &quick);
        assert!(asked && told.contains("bound_m") && told.contains("bias_m"), "{told}");
        assert_eq!(ask(cache.path(), "one", &quick), (told.clone(), false));
        // Nothing but the program tells them apart.
        assert_eq!(ask(cache.path(), "another", &quick), (told.clone(), true));
        let (of_farther, asked) = ask(cache.path(), "one", &farther);
        assert!(asked && of_farther != told);
        assert_eq!(ask(cache.path(), "one", &quick), (told, false));
        assert_eq!(files(cache.path()).len(), 3);
    }

    #[test]
    fn a_torn_or_changed_file_is_found_and_made_anew() {
        let cache = tempfile::tempdir().unwrap();
        let quick = scene(&[]);
        let (told, _) = ask(cache.path(), "one", &quick);
        let file = &files(cache.path())[0];
        let whole = fs::read(file).unwrap();
        let half = &whole[..whole.len() / 2];
        let other = String::from_utf8(whole.clone()).unwrap().replacen("1.", "2.", 1);
        for spoilt in [half, &[], other.as_bytes()] {
            assert_ne!(spoilt, whole);
            fs::write(file, spoilt).unwrap();
            assert_eq!(ask(cache.path(), "one", &quick), (told.clone(), true));
            assert_eq!(fs::read(file).unwrap(), whole);
            assert_eq!(ask(cache.path(), "one", &quick), (told.clone(), false));
        }
    }

    #[test]
    fn two_runs_at_once_ask_theory_once() {
        let cache = tempfile::tempdir().unwrap();
        let (quick, asked) = (scene(&[]), AtomicU32::new(0));
        let ask = || {
            kept(cache.path(), "one", &quick, || {
                asked.fetch_add(1, Ordering::Relaxed);
                vec![0.1_f64, -0.0, 1e-300]
            })
        };
        thread::scope(|scope| {
            let told: Vec<_> = (0..4).map(|_| scope.spawn(ask)).collect();
            for told in told {
                assert_eq!(format!("{:?}", told.join().unwrap()), "[0.1, -0.0, 1e-300]");
            }
        });
        assert_eq!(asked.into_inner(), 1);
    }

    #[test]
    fn what_json_does_not_hold_and_what_has_no_cache_is_asked_each_time() {
        let cache = tempfile::tempdir().unwrap();
        let quick = scene(&[]);
        let nowhere = cache.path().join("file");
        fs::write(&nowhere, "").unwrap();
        for (cache, told) in [(cache.path(), f64::NAN), (&nowhere, 1.0)] {
            let asked = Cell::new(0);
            for _ in 0..2 {
                let found = kept(cache, "one", &quick, || {
                    asked.set(asked.get() + 1);
                    Some(told)
                });
                assert_eq!(format!("{found:?}"), format!("{:?}", Some(told)));
            }
            assert_eq!(asked.get(), 2);
        }
    }
}
