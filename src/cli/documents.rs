//! JSON Schemas of every document, in `docs/json`, made from the types that are printed.

use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use schemars::transform::transform_subschemas;
use schemars::{Schema, SchemaGenerator};
use serde_json::{Value, json};

use crate::document::{Body, Document};

/// Lists the schemas of some documents.
macro_rules! schemas_of {
    ($($document:ty,)*) => { vec![$(schema::<$document>()),*] };
}

/// Name and text of the schema of each document.
pub fn schemas() -> Vec<(&'static str, String)> {
    schemas_of![
        crate::board::BoardReport,
        super::calibrate::Calibration,
        crate::code::CodesReport,
        crate::study::architectures::Comparison,
        crate::cosim::Report,
        crate::deliver::Emission,
        super::estimate::Estimates,
        crate::study::limits::Limits,
        super::failure::Failure,
        crate::study::fidelity::FidelityReport,
        crate::grade::Grade,
        crate::image::ImageReport,
        super::manual::Completions,
        super::manual::Pages,
        super::new::Made,
        crate::plan::overview::Overview,
        crate::simulate::pulses::PulsesReport,
        crate::replay::ReplayReport,
        crate::study::reproduce::Reproduction,
        crate::run::Run,
        crate::simulate::repeat::Simulation,
        crate::simulate::track::TrackReport,
        crate::study::stress::StressReport,
        super::stress::CaseList,
        super::sweep::SweepReport,
        crate::study::sweep::SweepOptions,
        crate::shard::Shard,
        super::shards::ShardDone,
        super::shards::MissingShards,
    ]
}

fn schema<B: Body + JsonSchema>() -> (&'static str, String) {
    let generator: SchemaGenerator =
        SchemaSettings::draft2020_12().for_serialize().into_generator();
    let mut schema = generator.into_root_schema_for::<Document<B>>();
    close(&mut schema);
    schema.insert("title".to_owned(), json!(format!("goldtof: {}", B::NAME)));
    if let Some(name) = schema.pointer_mut("/properties/document") {
        *name = json!({
            "const": B::NAME,
            "description": "Which document this is: the schema's name.",
        });
    }
    // Neither numbers without a value nor keys that are not text are in a schema.
    let text = serde_json::to_string_pretty(&schema).unwrap_or_default();
    (B::NAME, text + "\n")
}

/// Objects have no properties but those that are named, and descriptions no links that
/// lead into the source.
fn close(schema: &mut Schema) {
    let has_names = schema.get("properties").is_some_and(Value::is_object);
    if has_names && schema.get("additionalProperties").is_none() {
        schema.insert("additionalProperties".to_owned(), json!(false));
    }
    if let Some(description) = schema.get("description").and_then(Value::as_str) {
        let plain = without_links(description);
        schema.insert("description".to_owned(), json!(plain));
    }
    transform_subschemas(&mut close, schema);
}

/// Rustdoc's `[`path`]` as `path`, without link definitions and examples in Rust.
fn without_links(text: &str) -> String {
    let text = text.split_once("```").map_or(text, |(before, _)| before);
    let lines = text.lines().filter(|line| !line.starts_with("[`"));
    let text = lines.collect::<Vec<_>>().join("\n");
    text.replace("[`", "`").replace("`]", "`").trim().to_owned()
}
