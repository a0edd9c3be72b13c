//! A sensor at a serial port.

use std::sync::Mutex;
use std::time::{Duration, Instant};

use goldtof_device::{Device, DeviceError, Feed, Line, Scan, Scans, What, hexadecimal};
use goldtof_wire::{Content, Event, Frame, Identity, Tally};
use pyo3::exceptions::{PyConnectionError, PyTimeoutError};

use crate::errors::of_scene;
use crate::prelude::*;

/// How often signals are looked for.
const LOOK: Duration = Duration::from_millis(50);

/// A sensor at a serial port, which a thread reads whatever Python does: what has come is kept.
#[pyclass(name = "_Device", module = "goldtof._goldtof")]
pub(crate) struct PyDevice {
    identity: Identity,
    /// Of the scene, if it is known.
    sensor: Option<Sensor>,
    open: Mutex<Option<Open>>,
}

struct Open {
    feed: Feed,
    scans: Scans,
    tally: Tally,
    /// The reason, once it is gone.
    gone: Option<String>,
}

impl Open {
    /// The scan that the next news completes, if any comes within this time.
    fn next(&mut self, within: Duration) -> Option<Scan> {
        let news = self.feed.next(within)?;
        self.tally = news.tally;
        match news.what {
            What::Event(Event::Frame(Frame::Results(frame))) => {
                self.scans.take(&frame, news.time_s)
            }
            What::Event(Event::Lost(_)) => {
                self.scans.lost();
                None
            }
            // Answers to requests that were sent twice; and nothing opens it again.
            What::Event(Event::Frame(_)) | What::Back => None,
            What::Gone(error) => {
                self.gone = Some(error.to_string());
                None
            }
        }
    }
}

/// What goes wrong, as Python says it.
fn of_device(error: DeviceError) -> PyErr {
    match error {
        DeviceError::Unplugged(_) => PyConnectionError::new_err(error.to_string()),
        DeviceError::Silent => PyTimeoutError::new_err(error.to_string()),
        _ => failed(error),
    }
}

impl PyDevice {
    /// Does something with the device, if it was not closed.
    fn with<T>(&self, job: impl FnOnce(&mut Open) -> PyResult<T>) -> PyResult<T> {
        let mut open = self.open.lock().map_err(failed)?;
        job(open.as_mut().ok_or_else(|| failed("the device was closed"))?)
    }
}

#[pymethods]
impl PyDevice {
    /// Opens a port, and asks what is there; another scene's device is refused.
    #[new]
    #[pyo3(signature = (port, *, scene=None, baud=3_000_000))]
    fn new(
        python: Python<'_>,
        port: String,
        scene: Option<PathBuf>,
        baud: u32,
    ) -> PyResult<PyDevice> {
        let line = Line { port, baud, scene };
        let opened: Result<(Device<_>, Identity), DeviceError> = python.detach(|| line.open());
        let (device, identity) = opened.map_err(of_device)?;
        let sensor = line.scene.as_ref().map(Sensor::load).transpose().map_err(of_scene)?;
        let open = Open {
            feed: Feed::start(device, identity, None),
            scans: Scans::new(identity),
            tally: Tally::default(),
            gone: None,
        };
        Ok(PyDevice { identity, sensor, open: Mutex::new(Some(open)) })
    }

    /// What the device says of itself.
    #[getter]
    fn identity<'py>(&self, python: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let Identity { content, layout, .. } = self.identity;
        let told = PyDict::new(python);
        let content = match content {
            Content::Counts => "counts",
            Content::Rows => "histogram",
            Content::Peaks => "peaks",
        };
        told.set_item("content", content)?;
        told.set_item("scene_sha256_begins", hexadecimal(&self.identity.scene))?;
        told.set_item("detectors", self.identity.detectors)?;
        told.set_item("phase_steps", self.identity.steps)?;
        told.set_item("first_step", self.identity.first_step)?;
        told.set_item("parallel", self.identity.parallel)?;
        told.set_item("samples_per_chip", self.identity.samples_per_chip)?;
        told.set_item("chip_period_s", f64::from(self.identity.chip_period_fs) * 1e-15)?;
        told.set_item("code_chips", self.identity.code_chips)?;
        told.set_item("count_bits", layout.count_bits)?;
        Ok(told)
    }

    /// The next scan that comes whole: ``scan``, ``time_s``, and of the detector ``phase_step``, ``signed`` and, where
    /// the hardware sends it, ``total``; of a histogram ``bins``.
    fn _scan<'py>(
        &self,
        python: Python<'py>,
        detector: usize,
        timeout_s: f64,
    ) -> PyResult<Bound<'py, PyDict>> {
        let timeout = Duration::try_from_secs_f64(timeout_s).map_err(bad_argument)?;
        let begun = Instant::now();
        let scan = loop {
            // Results that came before the device was gone are given first.
            let found =
                python.detach(|| self.with(|open| Ok((open.next(LOOK), open.gone.clone()))))?;
            match found {
                (Some(scan), _) => break scan,
                (None, Some(reason)) => return Err(PyConnectionError::new_err(reason)),
                (None, None) => {}
            }
            python.check_signals()?;
            if begun.elapsed() > timeout {
                return Err(PyTimeoutError::new_err(format!(
                    "no whole scan came in {timeout_s} s"
                )));
            }
        };
        let all = scan.detectors.len();
        let Some(of) = scan.detectors.into_iter().nth(detector) else {
            return Err(bad_argument(format!("detector {detector}: the device has {all}, from 0")));
        };
        let told = PyDict::new(python);
        told.set_item("scan", scan.number)?;
        told.set_item("time_s", scan.time_s)?;
        if self.identity.content == Content::Rows {
            let bins: Vec<u64> = of.counts.iter().map(|count| count.unsigned_abs()).collect();
            told.set_item("bins", PyArray1::from_vec(python, bins))?;
            return Ok(told);
        }
        told.set_item("phase_step", PyArray1::from_vec(python, of.phase_steps))?;
        told.set_item("signed", PyArray1::from_vec(python, of.counts))?;
        if !of.totals.is_empty() {
            told.set_item("total", PyArray1::from_vec(python, of.totals))?;
        }
        Ok(told)
    }

    /// How much has come so far, and how much has not.
    #[getter]
    fn tally<'py>(&self, python: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let tally = python.detach(|| self.with(|open| Ok(open.tally)))?;
        let told = PyDict::new(python);
        told.set_item("bytes", tally.bytes)?;
        told.set_item("frames", tally.frames)?;
        told.set_item("results", tally.results)?;
        told.set_item("doubled", tally.doubled)?;
        told.set_item("torn", tally.torn)?;
        told.set_item("lost_frames", tally.lost_frames)?;
        told.set_item("lost_results", tally.lost_results)?;
        told.set_item("uncertain", tally.uncertain)?;
        told.set_item("dropped", tally.dropped)?;
        Ok(told)
    }

    /// The register at a byte address.
    fn read(&self, python: Python<'_>, address: u16) -> PyResult<u32> {
        python.detach(|| self.with(|open| open.feed.read(address).map_err(of_device)))
    }

    /// Writes the register at a byte address; taps that make no code of the scene's kind only by ``force``.
    #[pyo3(signature = (address, data, *, force=false))]
    fn write(&self, python: Python<'_>, address: u16, data: u32, force: bool) -> PyResult<()> {
        let doubt = |sensor: &Sensor| sensor.interface().doubt(address.into(), data);
        if let Some(doubt) = self.sensor.as_ref().filter(|_| !force).and_then(doubt) {
            return Err(bad_argument(format!("{doubt}; force=True writes it all the same")));
        }
        python.detach(|| self.with(|open| open.feed.write(address, data).map_err(of_device)))
    }

    /// Gives the port back.
    fn close(&self, python: Python<'_>) -> PyResult<()> {
        python.detach(|| {
            *self.open.lock().map_err(failed)? = None;
            Ok(())
        })
    }
}
