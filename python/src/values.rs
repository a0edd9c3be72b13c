//! JSON as Python's own types, and Python's as TOML.

use goldtof::scene::MOST_KEY_PARTS;
use pyo3::types::{PyBool, PyFloat, PyInt, PyList, PyString, PyTuple};
use serde::Serialize;
use serde_json::Value;

use crate::prelude::*;

/// What a job reports, as the command line's JSON has it.
pub(crate) fn to_python<'py>(
    python: Python<'py>,
    report: &impl Serialize,
) -> PyResult<Bound<'py, PyAny>> {
    let value = serde_json::to_value(report).map_err(failed)?;
    of_json(python, &value)
}

fn of_json<'py>(python: Python<'py>, value: &Value) -> PyResult<Bound<'py, PyAny>> {
    Ok(match value {
        Value::Null => python.None().into_bound(python),
        Value::Bool(value) => PyBool::new(python, *value).to_owned().into_any(),
        Value::Number(number) => match (number.as_i64(), number.as_u64(), number.as_f64()) {
            (Some(number), _, _) => number.into_pyobject(python)?.into_any(),
            (_, Some(number), _) => number.into_pyobject(python)?.into_any(),
            (_, _, number) => PyFloat::new(python, number.unwrap_or(f64::NAN)).into_any(),
        },
        Value::String(text) => PyString::new(python, text).into_any(),
        Value::Array(values) => {
            let list = PyList::empty(python);
            for value in values {
                list.append(of_json(python, value)?)?;
            }
            list.into_any()
        }
        Value::Object(fields) => {
            let dict = PyDict::new(python);
            for (name, value) in fields {
                dict.set_item(name, of_json(python, value)?)?;
            }
            dict.into_any()
        }
    })
}

/// A value of a scene.
pub(crate) fn of_toml<'py>(
    python: Python<'py>,
    value: &toml::Value,
) -> PyResult<Bound<'py, PyAny>> {
    Ok(match value {
        toml::Value::Float(number) => PyFloat::new(python, *number).into_any(),
        toml::Value::Array(values) => {
            let values = values.iter().map(|value| of_toml(python, value));
            PyList::new(python, values.collect::<PyResult<Vec<_>>>()?)?.into_any()
        }
        toml::Value::Table(fields) => {
            let dict = PyDict::new(python);
            for (name, value) in fields {
                dict.set_item(name, of_toml(python, value)?)?;
            }
            dict.into_any()
        }
        // The others are as in JSON.
        other => to_python(python, other)?,
    })
}

/// A value of a scene; `place` is the key that it is for.
pub(crate) fn to_toml(value: &Bound<'_, PyAny>, place: &str) -> PyResult<toml::Value> {
    to_toml_within(value, place, MOST_KEY_PARTS)
}

/// The same, of a value that may have so many more lists and dicts within each other: one
/// that holds itself has no end.
fn to_toml_within(value: &Bound<'_, PyAny>, place: &str, levels: usize) -> PyResult<toml::Value> {
    let levels = levels.checked_sub(1).ok_or_else(|| {
        bad_argument(format!(
            "{place}: more than {MOST_KEY_PARTS} lists and dicts within each other are not a scene"
        ))
    })?;
    if let Ok(value) = value.cast::<PyBool>() {
        return Ok(toml::Value::Boolean(value.is_true()));
    }
    if let Ok(value) = value.cast::<PyString>() {
        return Ok(toml::Value::String(value.to_str()?.to_owned()));
    }
    if value.is_instance_of::<PyInt>() {
        return Ok(toml::Value::Integer(value.extract()?));
    }
    if value.is_instance_of::<PyFloat>() {
        return Ok(toml::Value::Float(value.extract()?));
    }
    if let Ok(dict) = value.cast::<PyDict>() {
        let mut table = toml::Table::new();
        for (key, value) in dict {
            let key: String =
                key.extract().map_err(|_| bad_argument(format!("{place}: keys are texts")))?;
            let place = match place {
                "" => key.clone(),
                _ => format!("{place}.{key}"),
            };
            table.insert(key, to_toml_within(&value, &place, levels)?);
        }
        return Ok(toml::Value::Table(table));
    }
    if value.is_instance_of::<PyList>() || value.is_instance_of::<PyTuple>() {
        let mut array = Vec::new();
        for value in value.try_iter()? {
            array.push(to_toml_within(&value?, place, levels)?);
        }
        return Ok(toml::Value::Array(array));
    }
    // Numbers of numpy and others of their kind.
    if let Ok(number) = value.extract::<i64>() {
        return Ok(toml::Value::Integer(number));
    }
    if let Ok(number) = value.extract::<f64>() {
        return Ok(toml::Value::Float(number));
    }
    let kind = value.get_type().name()?;
    Err(bad_argument(format!(
        "{place}: a scene has no {kind}; it has texts, numbers, True and False, lists and dicts"
    )))
}
