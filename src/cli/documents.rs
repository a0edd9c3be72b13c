//! JSON Schemas of every document, in `docs/json`, made from the types that are printed.

use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use schemars::transform::transform_subschemas;
use schemars::{Schema, SchemaGenerator};
use serde_json::{Value, json};

use super::calibrate::Calibration;
use super::estimate::Estimates;
use super::failure::Failure;
use super::manual::{Completions, Pages};
use super::merge::MissingShards;
use super::new::Made;
use super::shards::ShardDone;
use super::stress::CaseList;
use super::sweep::SweepReport;
use crate::code::CodesReport;
use crate::cosim;
use crate::deliver::Emission;
use crate::document::{Body, Document};
use crate::grade::Grade;
use crate::image::ImageReport;
use crate::plan::overview::Overview;
use crate::replay::ReplayReport;
use crate::run::Run;
use crate::shard::Shard;
use crate::simulate::pulses::PulsesReport;
use crate::simulate::repeat::Simulation;
use crate::study::architectures::Comparison;
use crate::study::fidelity::FidelityReport;
use crate::study::limits::Limits;
use crate::study::reproduce::Reproduction;
use crate::study::stress::StressReport;
use crate::study::sweep::SweepOptions;

/// Name and text of the schema of each document.
pub fn schemas() -> Vec<(&'static str, String)> {
    vec![
        schema::<Calibration>(),
        schema::<CodesReport>(),
        schema::<Comparison>(),
        schema::<cosim::Report>(),
        schema::<Emission>(),
        schema::<Estimates>(),
        schema::<Limits>(),
        schema::<Failure>(),
        schema::<FidelityReport>(),
        schema::<Grade>(),
        schema::<ImageReport>(),
        schema::<Completions>(),
        schema::<Pages>(),
        schema::<Made>(),
        schema::<Overview>(),
        schema::<PulsesReport>(),
        schema::<ReplayReport>(),
        schema::<Reproduction>(),
        schema::<Run>(),
        schema::<Simulation>(),
        schema::<StressReport>(),
        schema::<CaseList>(),
        schema::<SweepReport>(),
        schema::<SweepOptions>(),
        schema::<Shard>(),
        schema::<ShardDone>(),
        schema::<MissingShards>(),
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
