//! Scenes.

use std::hash::{DefaultHasher, Hash, Hasher};

use goldtof::scene::{self, Entry, EstimatorKind, Origin, Scene, SceneText, Setting};
use pyo3::exceptions::PyKeyError;
use pyo3::types::{PyString, PyTuple};

use crate::errors::{of_scene, of_whole_scene};
use crate::prelude::*;
use crate::values::{of_toml, to_toml};

/// A sensor and what surrounds it: what a scene file says, read and checked.
///
/// Keys are read in SI units, and set in place, as ``--set`` does; numbers for keys that take a
/// quantity are in SI units, too. If a value is refused, the scene stays as it was. Scenes are
/// equal that say the same; they can be copied and pickled.
///
/// >>> scene = Scene.parse(QUICK, "quick.toml")
/// >>> scene.name, scene.phase_steps
/// ('quick', 248)
/// >>> scene["path.distance"] = "5 m"
/// >>> scene.path_distances_m
/// [5.0]
/// >>> scene["path.distance"] *= 2
/// >>> scene["path.distance"], scene["source.mean_power"], scene["source.code.degree"]
/// (10.0, 2e-11, 5)
/// >>> scene["path.distance"] = "5 kg"
/// Traceback (most recent call last):
///     ...
/// goldtof.SceneError: Scene path.distance="5 kg": ...
#[pyclass(name = "Scene", module = "goldtof")]
#[derive(Clone)]
pub(crate) struct PyScene {
    file_name: String,
    text: String,
    settings: Vec<Setting>,
    scene: Scene,
}

impl PyScene {
    fn read(file_name: String, text: String) -> PyResult<PyScene> {
        let scene = scene::parse(&file_name, &text).map_err(of_scene)?;
        Ok(PyScene { file_name, text, settings: Vec::new(), scene })
    }

    /// The scene of what a host gets, as it is now ([`Scene::summed`]), with another estimator if one is named.
    pub(crate) fn with_estimator(&self, estimator: Option<&str>) -> PyResult<Scene> {
        let kind = match estimator {
            None => return Ok(self.summed()),
            Some("fft") => EstimatorKind::Fft,
            Some("model") => EstimatorKind::Model,
            Some(other) => {
                return Err(bad_argument(format!(
                    "there is no estimator {other:?}; there are fft and model"
                )));
            }
        };
        self.summed().with_estimator(Some(kind)).map_err(of_whole_scene)
    }

    /// [`Scene::summed`].
    pub(crate) fn summed(&self) -> Scene {
        self.scene.clone().summed()
    }

    pub(crate) fn scene(&self) -> &Scene {
        &self.scene
    }

    pub(crate) fn sensor(&self) -> Sensor {
        Sensor::new(&self.scene)
    }

    /// All that the scene says, whatever text says it.
    fn content(&self) -> String {
        format!("{:?}", Scene { origin: Origin::default(), ..self.scene.clone() })
    }

    fn entry(&self, key: &str) -> PyResult<Entry> {
        Entry::of(&self.text, &self.settings, key).map_err(PyKeyError::new_err)
    }
}

/// Numbers for a key that takes a quantity as what a scene has for them.
fn in_units(key: &str, value: toml::Value) -> PyResult<toml::Value> {
    let quantity = |number: f64| scene::quantity_text(key, number).ok().flatten();
    Ok(match value {
        toml::Value::Float(number) => quantity(number).map_or(value, toml::Value::String),
        toml::Value::Integer(number) => quantity(number as f64).map_or(value, toml::Value::String),
        toml::Value::Array(values) => {
            let values = values.into_iter().map(|value| in_units(key, value));
            toml::Value::Array(values.collect::<PyResult<_>>()?)
        }
        other => other,
    })
}

/// Text in HTML.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

/// A scene from what is pickled of it.
#[pyfunction]
pub(crate) fn _scene(
    file_name: String,
    text: String,
    settings: Vec<(String, String)>,
) -> PyResult<PyScene> {
    let settings = settings.iter().map(|(key, value)| Setting::of(key, value, "Scene"));
    let settings = settings.collect::<Result<Vec<_>, _>>().map_err(bad_argument)?;
    let scene = scene::parse_with(&file_name, &text, &settings).map_err(of_scene)?;
    Ok(PyScene { file_name, text, settings, scene })
}

/// The detector of a name, or the only one.
pub(crate) fn detector_of(scene: &Scene, name: Option<&str>) -> PyResult<DetectorIndex> {
    let known = || {
        let names: Vec<String> =
            scene.detectors.iter().map(|detector| format!("{:?}", detector.name)).collect();
        names.join(", ")
    };
    match name {
        None if scene.detectors.len() == 1 => Ok(DetectorIndex(0)),
        None => {
            Err(bad_argument(format!("the scene has several detectors; name one: {}", known())))
        }
        Some(name) => {
            let place = scene.detectors.iter().position(|d| d.name == name);
            place.map(DetectorIndex).ok_or_else(|| {
                bad_argument(format!("the scene has no detector {name:?}; it has {}", known()))
            })
        }
    }
}

#[pymethods]
impl PyScene {
    /// Reads and checks the scene in a file.
    #[staticmethod]
    fn load(path: PathBuf) -> PyResult<PyScene> {
        let read = SceneText::read(&path, &[]).map_err(of_scene)?;
        let scene = read.scene().map_err(of_scene)?;
        let file_name = path.to_string_lossy().into_owned();
        Ok(PyScene { file_name, text: read.text, settings: read.settings, scene })
    }

    /// Reads and checks a scene's text, TOML as in a file; ``name`` is what errors call
    /// the file, and without its ending it is the scene's name.
    #[staticmethod]
    #[pyo3(signature = (text, name="scene.toml"))]
    fn parse(text: String, name: &str) -> PyResult<PyScene> {
        PyScene::read(name.to_owned(), text)
    }

    /// A scene from dicts, lists, texts and numbers, as the TOML of a file has them.
    ///
    /// >>> import tomllib
    /// >>> Scene.from_dict(tomllib.loads(QUICK), "quick.toml").phase_steps
    /// 248
    #[staticmethod]
    #[pyo3(signature = (tables, name="scene.toml"))]
    fn from_dict(tables: &Bound<'_, PyDict>, name: &str) -> PyResult<PyScene> {
        let value = to_toml(tables.as_any(), "")?;
        let text = toml::to_string(&value).map_err(bad_argument)?;
        PyScene::read(name.to_owned(), text)
    }

    /// Another scene with the same text and settings.
    fn copy(&self) -> PyScene {
        self.clone()
    }

    fn __copy__(&self) -> PyScene {
        self.clone()
    }

    fn __deepcopy__(&self, _memo: &Bound<'_, PyAny>) -> PyScene {
        self.clone()
    }

    fn __reduce__<'py>(&self, python: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let maker = python.import("goldtof._goldtof")?.getattr("_scene")?;
        let settings: Vec<_> = self.settings.iter().map(Setting::key_and_value).collect();
        (maker, (&self.file_name, &self.text, settings)).into_pyobject(python)
    }

    fn __eq__(&self, other: &Bound<'_, PyAny>) -> bool {
        let other = other.cast::<PyScene>();
        other.is_ok_and(|other| self.content() == other.borrow().content())
    }

    /// Of what the scene says now: it is another one when a key is set.
    fn __hash__(&self) -> u64 {
        let mut hasher = DefaultHasher::new();
        self.content().hash(&mut hasher);
        hasher.finish()
    }

    fn __getitem__<'py>(&self, python: Python<'py>, key: &str) -> PyResult<Bound<'py, PyAny>> {
        match self.entry(key)?.value {
            Some(value) => of_toml(python, &value),
            None => Ok(python.None().into_bound(python)),
        }
    }

    /// What is known of a key: its ``value`` in SI units, or its default (None where other keys
    /// decide), its ``unit`` as UDUNITS writes it (None if it is not a quantity), its ``meaning``.
    ///
    /// >>> Scene.parse(QUICK, "quick.toml").about("source.mean_power")
    /// {'value': 2e-11, 'unit': 'W', 'meaning': 'optical power averaged over the code, at the source'}
    fn about<'py>(&self, python: Python<'py>, key: &str) -> PyResult<Bound<'py, PyDict>> {
        let Entry { value, unit, meaning } = self.entry(key)?;
        let about = PyDict::new(python);
        about.set_item("value", value.map(|value| of_toml(python, &value)).transpose()?)?;
        about.set_item("unit", unit)?;
        about.set_item("meaning", meaning)?;
        Ok(about)
    }

    fn __setitem__(&mut self, key: &str, value: &Bound<'_, PyAny>) -> PyResult<()> {
        let value = in_units(key, to_toml(value, key)?)?;
        let setting = Setting::of(key, &value.to_string(), "Scene").map_err(bad_argument)?;
        let mut settings = self.settings.clone();
        settings.push(setting);
        self.scene = scene::parse_with(&self.file_name, &self.text, &settings).map_err(of_scene)?;
        self.settings = settings;
        Ok(())
    }

    fn __repr__(&self, python: Python<'_>) -> PyResult<String> {
        let name = PyString::new(python, &self.scene.name).repr()?;
        let detectors = self.scene.detectors.len();
        Ok(format!(
            "<goldtof.Scene {name}: {} phase steps, {detectors} detector{}>",
            self.scene.scan.steps,
            if detectors == 1 { "" } else { "s" }
        ))
    }

    fn _repr_html_(&self) -> String {
        let scene = &self.scene;
        let names = |names: Vec<&str>| names.join(", ");
        let paths = scene.paths.iter().map(|path| {
            format!(
                "{} to {}, {} m",
                scene.sources[path.source].name,
                scene.detectors[path.detector].name,
                path.distance_m()
            )
        });
        let rows = [
            ("sources", names(scene.sources.iter().map(|source| source.name.as_str()).collect())),
            ("detectors", names(scene.detectors.iter().map(|spad| spad.name.as_str()).collect())),
            ("paths", paths.collect::<Vec<_>>().join("; ")),
            ("chip period", format!("{} ns", scene.chip_period_ps * 1e-3)),
            ("samples of a chip", scene.samples_per_chip.to_string()),
            ("phase steps", scene.scan.steps.to_string()),
            ("integration", format!("{} us", scene.timing().integration_ps() * 1e-6)),
            ("set since it was read", names(self.settings().iter().map(String::as_str).collect())),
        ];
        let rows = rows.iter().filter(|(_, value)| !value.is_empty()).map(|(name, value)| {
            format!("<tr><th style=\"text-align:left\">{name}</th><td>{}</td></tr>", escaped(value))
        });
        format!(
            "<table><caption>{}</caption><tbody>{}</tbody></table>",
            escaped(&scene.name),
            rows.collect::<String>()
        )
    }

    /// The scene's name: the file's, without its ending.
    #[getter]
    fn name(&self) -> &str {
        &self.scene.name
    }

    /// The text that the scene was read from, without what was set since.
    #[getter]
    fn text(&self) -> &str {
        &self.text
    }

    /// Overridden keys, in order: ``path.distance="5 m"``.
    #[getter]
    fn settings(&self) -> Vec<String> {
        self.scene.origin.settings.clone()
    }

    /// Phase steps of a scan.
    #[getter]
    fn phase_steps(&self) -> u64 {
        self.scene.scan.steps
    }

    /// Samples of a chip.
    #[getter]
    fn samples_per_chip(&self) -> u32 {
        self.scene.samples_per_chip
    }

    /// Period of a chip, which is one clock of the hardware.
    #[getter]
    fn chip_period_s(&self) -> f64 {
        self.scene.chip_period_ps * 1e-12
    }

    /// Integration of a phase step.
    #[getter]
    fn integration_s(&self) -> f64 {
        self.scene.timing().integration_ps() * 1e-12
    }

    /// Clocks of a scan; with `parallel` steps at once fewer than all steps' together.
    #[getter]
    fn scan_clocks(&self) -> u64 {
        self.sensor().interface().scan_clocks()
    }

    /// Names of the sources.
    #[getter]
    fn sources(&self) -> Vec<String> {
        let sources = self.scene.sources.iter();
        sources.map(|source| source.name.clone()).collect()
    }

    /// Names of the detectors.
    #[getter]
    fn detectors(&self) -> Vec<String> {
        let detectors = self.scene.detectors.iter();
        detectors.map(|detector| detector.name.clone()).collect()
    }

    /// Distance (half the optical path) of each path, at the start of a scan.
    #[getter]
    fn path_distances_m(&self) -> Vec<f64> {
        let paths = self.scene.paths.iter();
        paths.map(goldtof::scene::Path::distance_m).collect()
    }

    /// Name and bits of each port of the hardware but the clock, in the Verilog's order.
    #[getter]
    fn ports(&self) -> Vec<(String, u32)> {
        let ports = self.sensor().interface().ports().into_iter();
        let ports = ports.filter(|port| port.name != "i_clk");
        ports.map(|port| (port.name, port.width)).collect()
    }

    /// Clocks from a group's last sample word to its first result, in the emitted design.
    #[getter]
    fn result_latency_clocks(&self) -> u32 {
        self.sensor().interface().result_latency_clocks
    }
}
