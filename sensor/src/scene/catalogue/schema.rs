//! The keys as a JSON Schema, for editors.

use serde_json::{Map, Value, json};

use super::TABLES;
use crate::scene::keys::{Absent, Form, Key, KeyKind, KeyTable};
use crate::scene::units::{self, Quantity};

/// Tables at the root, whether there may be several, and whether one must be there.
const ROOT: [(&str, bool, bool); 8] = [
    ("clock", false, true),
    ("source", true, true),
    ("detector", true, true),
    ("path", true, false),
    ("scan", false, true),
    ("estimate", false, false),
    ("hardware", false, false),
    ("array", false, false),
];

/// `docs/scene.schema.json`: what a scene may have, by which editors complete and check
/// it. Bounds of quantities are in the descriptions: a schema knows no units.
pub fn schema() -> String {
    let mut properties = Map::new();
    for (name, is_list, is_needed) in ROOT {
        let table = of_table(table(name));
        let value = match is_list {
            true if is_needed => json!({ "type": "array", "items": table, "minItems": 1 }),
            true => json!({ "type": "array", "items": table }),
            false => table,
        };
        properties.insert(name.to_owned(), value);
    }
    let needed: Vec<&str> =
        ROOT.iter().filter(|(_, _, is_needed)| *is_needed).map(|(name, _, _)| *name).collect();
    let schema = json!({
        "$schema": "http://json-schema.org/draft-07/schema#",
        "title": "goldtof scene",
        "description": "Codes, clock, lasers, paths, detectors and scan of a light-ranging sensor. \
                        Made from the keys declared in sensor/src/scene; docs/scene.md says the same in words.",
        "type": "object",
        "properties": properties,
        "required": needed,
        "additionalProperties": false,
    });
    // A map of texts and numbers can always be written.
    serde_json::to_string_pretty(&schema).unwrap_or_default() + "\n"
}

/// The table of a path.
///
/// # Panics
/// If there is none, which a test of the schema would have shown.
fn table(path: &str) -> &'static KeyTable {
    let found = TABLES.iter().find(|table| table.path == path);
    found.unwrap_or_else(|| unreachable!("there is no table of keys \"{path}\""))
}

fn of_table(table: &KeyTable) -> Value {
    let properties: Map<String, Value> =
        table.keys().map(|key| (key.name.to_owned(), of_key(key))).collect();
    let needed: Vec<&str> = table
        .keys()
        .filter(|key| matches!(key.absent, Absent::Needed))
        .map(|key| key.name)
        .collect();
    let mut schema = json!({
        "type": "object",
        "properties": properties,
        "required": needed,
        "additionalProperties": false,
    });
    // One of two ways, and not both.
    let ways: [&[&str]; 2] = match table.path {
        "path" => [&["distance"], &["delay"]],
        "scan.steps" => [&["first", "count"], &["around", "halfwidth"]],
        _ => return schema,
    };
    schema["oneOf"] = ways.map(|keys| json!({ "required": keys })).into_iter().collect();
    schema
}

fn of_key(key: &Key) -> Value {
    let mut value = of_value(key);
    for _ in 0..key.lists() {
        value = json!({ "type": "array", "items": value });
    }
    let default = match key.absent {
        Absent::Needed => key.when_left_out().to_owned(),
        _ => format!("when left out: {}", key.when_left_out()),
    };
    let meaning = format!("{}; {}; {default}", key.meaning, key.range());
    value["description"] = Value::String(meaning);
    if let Some(example) = example(key) {
        value["examples"] = json!([example]);
    }
    value
}

/// The key's example as JSON has it.
fn example(key: &Key) -> Option<Value> {
    let line = format!("v = {}", key.example_toml());
    let table: toml::Table = line.parse().ok()?;
    serde_json::to_value(table.get("v")?).ok()
}

fn of_value(key: &Key) -> Value {
    match key.kind {
        // `around` may be a time of flight too.
        KeyKind::Quantity { quantity, .. } if key.name == "around" => {
            text_of(&[quantity, Quantity::Time])
        }
        KeyKind::Quantity { quantity, .. } => text_of(&[quantity]),
        KeyKind::Number { least, most, or_inf: true } => json!({
            "anyOf": [
                { "type": "number", "minimum": least, "maximum": most },
                { "const": "inf" },
            ],
        }),
        KeyKind::Number { least, most, .. } => {
            json!({ "type": "number", "minimum": least, "maximum": most })
        }
        KeyKind::Integer { least, most } => {
            json!({ "type": "integer", "minimum": least, "maximum": most })
        }
        KeyKind::Words(_, form) => of_form(form),
    }
}

fn of_form(form: Form) -> Value {
    let digits = json!({ "type": "string", "pattern": "^[01]+$" });
    match form {
        Form::Text => json!({ "type": "string", "minLength": 1 }),
        Form::Digits => digits,
        Form::Texts => json!({ "type": "array", "items": digits }),
        Form::Choice(choices) => json!({ "enum": choices }),
        Form::Boolean => json!({ "type": "boolean" }),
        Form::Table(path) => of_table(table(path)),
        Form::AllOr(path) => json!({ "anyOf": [{ "const": "all" }, of_table(table(path))] }),
    }
}

/// A text of a number and a unit of one of these kinds.
fn text_of(quantities: &[Quantity]) -> Value {
    let units: Vec<&str> = quantities.iter().flat_map(|&q| units::names(q)).collect();
    let number = r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?";
    let pattern = format!(r"^\s*{number}\s*({})\s*$", units.join("|"));
    json!({ "type": "string", "pattern": pattern })
}
