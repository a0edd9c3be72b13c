//! Scenes from files and texts, with keys set otherwise.

use std::ffi::c_char;
use std::path::Path;
use std::sync::Mutex;

use goldtof::scene::{self, Scene, SceneText, Setting};
use goldtof::sensor::Sensor;

use crate::border::{free, handle, locked, new_handle, status_of, text};
use crate::status::{Failure, Status};

/// A scene, and what it was read from.
pub(crate) struct OpenScene {
    name: String,
    text: String,
    settings: Vec<Setting>,
    scene: Scene,
}

/// A scene.
pub struct SceneHandle(Mutex<OpenScene>);

handle!(SceneHandle, OpenScene);

impl OpenScene {
    fn read(name: String, text: String) -> Result<OpenScene, Failure> {
        let scene = scene::parse(&name, &text).map_err(Failure::invalid)?;
        Ok(OpenScene { name, text, settings: Vec::new(), scene })
    }

    fn set(&mut self, assignments: &str) -> Result<(), Failure> {
        let mut settings = self.settings.clone();
        for assignment in assignments.split('\n') {
            settings.push(assignment.parse().map_err(Failure::invalid)?);
        }
        self.scene =
            scene::parse_with(&self.name, &self.text, &settings).map_err(Failure::invalid)?;
        self.settings = settings;
        Ok(())
    }

    pub(crate) fn sensor(&self) -> Sensor {
        Sensor::new(&self.scene)
    }
}

/// Reads and checks the scene in a file; null if it cannot be used.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn goldtof_scene_load(path: *const c_char) -> *mut SceneHandle {
    new_handle(|| {
        // SAFETY: the caller's word.
        let path = unsafe { text(path, "the path") }?;
        let read = SceneText::read(Path::new(path), &[]).map_err(Failure::invalid)?;
        let scene = read.scene().map_err(Failure::invalid)?;
        let (text, settings) = (read.text, read.settings);
        Ok(OpenScene { name: path.to_owned(), text, settings, scene })
    })
}

/// Reads and checks a scene's text, TOML as in a file; null if it cannot be used. `name`
/// is what errors call the file; without its ending it is the scene's name.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn goldtof_scene_parse(
    name: *const c_char,
    toml: *const c_char,
) -> *mut SceneHandle {
    new_handle(|| {
        // SAFETY: the caller's word.
        let (name, toml) = unsafe { (text(name, "the name")?, text(toml, "the scene's text")?) };
        OpenScene::read(name.to_owned(), toml.to_owned())
    })
}

/// Overrides a key of the text, as `--set` does: `path.distance=5 m`; or several, each on
/// a line. If one cannot be, the scene stays as it is.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn goldtof_scene_set(
    scene: *mut SceneHandle,
    assignment: *const c_char,
) -> Status {
    status_of(|| {
        // SAFETY: the caller's word.
        let (mut scene, assignment) =
            unsafe { (locked(scene, "scene")?, text(assignment, "the assignment")?) };
        scene.set(assignment)
    })
}

/// Ends a scene. Models and scoreboards that were made of it stay.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn goldtof_scene_free(scene: *mut SceneHandle) {
    // SAFETY: the caller's word.
    unsafe { free(scene) }
}
