//! What arguments may be, and what is said of those that may not.

use goldtof::cosim::engine::Engine;
use goldtof::simulate::Tier;
use pyo3::prelude::*;
use serde::Serialize;

use crate::errors::bad_argument;

/// One of several, by the name that it has in JSON.
pub(crate) fn named<T: Copy + Serialize>(all: &[T], name: &str, what: &str) -> PyResult<T> {
    let name_of = |one: &T| match serde_json::to_value(one) {
        Ok(serde_json::Value::String(name)) => name,
        _ => String::new(),
    };
    all.iter().copied().find(|one| name_of(one) == name).ok_or_else(|| {
        let names: Vec<String> = all.iter().map(name_of).collect();
        bad_argument(format!("there is no {what} {name:?}; there are {}", names.join(", ")))
    })
}

/// Bounds of the command line.
pub(crate) const MOST_REPETITIONS: u64 = 1_000_000;
pub(crate) const MOST_CLOCKS: u64 = 1 << 50;

pub(crate) fn within(value: u64, most: u64, what: &str) -> PyResult<()> {
    match (1..=most).contains(&value) {
        true => Ok(()),
        false => Err(bad_argument(format!("{what} is {value}, and has to be 1 to {most}"))),
    }
}

pub(crate) fn tier(name: &str) -> PyResult<Tier> {
    named(&Tier::ALL, name, "fidelity")
}

pub(crate) fn engine(name: &str) -> PyResult<Engine> {
    match name {
        "auto" => Ok(Engine::Auto),
        "lanes" => Ok(Engine::Lanes),
        "lockstep" => Ok(Engine::Lockstep),
        _ => Err(bad_argument(format!(
            "there is no engine {name:?}; there are auto, lanes and lockstep"
        ))),
    }
}
