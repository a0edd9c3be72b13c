//! Photons that an instrument recorded.

use std::fs::File;
use std::io::{BufReader, Cursor, Read};

use goldtof::replay::{ReplayOptions, replay, report};
use goldtof_tags::{Channel, Format, Tag, TagReader};

use crate::prelude::*;

/// A file, or the bytes of pairs.
type Input = Box<dyn Read + Send>;

fn opened(path: Option<PathBuf>, pairs: Option<Vec<u8>>) -> PyResult<TagReader<Input>> {
    let (input, name, format): (Input, String, Option<Format>) = match (path, pairs) {
        (Some(path), None) => {
            let name = path.display().to_string();
            let file = File::open(&path).map_err(|error| failed(format!("{name}: {error}")))?;
            (Box::new(BufReader::with_capacity(1 << 20, file)), name, None)
        }
        (_, pairs) => {
            let pairs = Cursor::new(pairs.unwrap_or_default());
            (Box::new(pairs), "arrays".to_owned(), Some(Format::Pairs))
        }
    };
    TagReader::new(input, &name, format).map_err(failed)
}

/// What a recording says, as ``goldtof replay --json`` has it, with the bins of each histogram as
/// ``bins`` of each detector.
#[pyfunction]
#[pyo3(signature = (scene, *, path=None, pairs=None, photons, epoch, epoch_periods))]
pub(crate) fn _replay<'py>(
    python: Python<'py>,
    scene: &PyScene,
    path: Option<PathBuf>,
    pairs: Option<Vec<u8>>,
    photons: Vec<String>,
    epoch: &str,
    epoch_periods: u64,
) -> PyResult<Bound<'py, PyAny>> {
    let sensor = scene.sensor();
    let epoch: Channel = epoch.parse().map_err(|told: String| bad_argument(told))?;
    if epoch_periods == 0 {
        return Err(bad_argument("epoch_periods is at least 1"));
    }
    let options = ReplayOptions::named(sensor.scene(), &photons, epoch, epoch_periods);
    let options = options.map_err(|error| bad_argument(error.to_string()))?;
    let mut reader = opened(path, pairs)?;
    let (told, replayed) = wait_for(python, None, move |_| {
        let replayed = replay(&sensor, &mut reader, &options, |_| ()).map_err(failed)?;
        let (told, _) = report(&sensor, &replayed).map_err(failed)?;
        Ok((told, replayed))
    })?;
    let told = to_python(python, &told)?;
    let detectors = told.get_item("detectors")?;
    for (number, one) in replayed.histograms.iter().enumerate() {
        let bins = PyArray1::from_slice(python, one.histogram.bins());
        detectors.get_item(number)?.set_item("bins", bins)?;
    }
    Ok(told)
}

/// Times and channels of a file of time tags: ``ticks`` since its beginning (uint64), ``channels`` (int16:
/// inputs from 1 up, 0 of sync, markers below 0), ``tick_s``, and ``kind``, the instrument and mode.
#[pyfunction]
pub(crate) fn read_tags(python: Python<'_>, path: PathBuf) -> PyResult<Bound<'_, PyDict>> {
    let mut reader = opened(Some(path), None)?;
    let (ticks, channels, tick_ps, kind) = wait_for(python, None, move |_| {
        let (mut ticks, mut channels, mut tags) = (Vec::new(), Vec::new(), Vec::new());
        while reader.read(&mut tags).map_err(failed)? {
            ticks.extend(tags.iter().map(|tag: &Tag| tag.ticks));
            channels.extend(tags.iter().map(|tag| match tag.channel {
                Channel::Sync => 0,
                Channel::Input(number) => number as i16,
                Channel::Marker(number) => -i16::from(number),
            }));
        }
        Ok((ticks, channels, reader.tick_ps(), reader.kind()))
    })?;
    let told = PyDict::new(python);
    told.set_item("ticks", PyArray1::from_vec(python, ticks))?;
    told.set_item("channels", PyArray1::from_vec(python, channels))?;
    told.set_item("tick_s", tick_ps * 1e-12)?;
    told.set_item("kind", kind)?;
    Ok(told)
}
