//! What two jobs differ in, in words.

use std::collections::BTreeMap;

use serde::Serialize;
use serde_json::Value;

/// What of a job, with its scene's text or the digest of it, is another there: empty if nothing
/// is.
pub fn differences(here: &impl Serialize, there: &impl Serialize) -> Vec<String> {
    let (here, there) = (values(here), values(there));
    let differing = here.iter().filter(|(name, value)| there.get(*name) != Some(*value));
    let told = |(name, value): (&String, &Value)| match name.as_str() {
        "scene.text" | "scene.sha256" => "the scene's text is another".to_owned(),
        _ => {
            let there = there.get(name).unwrap_or(&Value::Null);
            format!("{} is {value}, there {there}", name.rsplit('.').next().unwrap_or(name))
        }
    };
    differing.map(told).collect()
}

/// The same of versions of goldtof.
pub fn other_version(here: &str, there: &str) -> Option<String> {
    (here != there).then(|| format!("the version is {here}, there {there}"))
}

/// Each value of an object with its name, those of objects in it as `scene.text`.
fn values(job: &impl Serialize) -> BTreeMap<String, Value> {
    let mut values = BTreeMap::new();
    // A job is always a JSON object.
    if let Ok(Value::Object(fields)) = serde_json::to_value(job) {
        for (name, value) in fields {
            match value {
                Value::Object(inner) => {
                    let inner = inner.into_iter();
                    values.extend(inner.map(|(of, value)| (format!("{name}.{of}"), value)));
                }
                value => _ = values.insert(name, value),
            }
        }
    }
    values
}
