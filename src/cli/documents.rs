//! JSON Schemas of every document, in `docs/json`, made from the types that are printed.

use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use schemars::transform::transform_subschemas;
use schemars::{Schema, SchemaGenerator};
use serde_json::{Value, json};

use crate::document::{Body, Document};
use crate::documents::documents;

/// Names the documents that the program alone has, and lists the schemas of all.
macro_rules! schemas_of {
    (own { $($own:ty = $name:literal;)* } others { $($document:ty;)* }) => {
        documents! { $($own = $name;)* }

        /// Name and text of the schema of each document.
        pub fn schemas() -> Vec<(&'static str, String)> {
            vec![$(schema::<$own>(),)* $(schema::<$document>()),*]
        }
    };
}

schemas_of! {
    own {
        super::calibrate::Calibration = "calibrate";
        super::estimate::Estimates<'_> = "estimate";
        super::failure::Failure = "error";
        super::manual::Completions = "completions";
        super::manual::Pages = "man";
        super::new::Made = "new";
        super::shards::MissingShards = "merge-missing";
        super::shards::ShardDone = "shard-done";
        super::stress::CaseList = "stress-list";
        super::sweep::SweepReport<'_> = "sweep";
    }
    others {
        crate::board::BoardReport;
        crate::code::CodesReport;
        crate::cosim::Report;
        crate::deliver::Emission;
        crate::grade::Grade;
        crate::image::ImageReport;
        crate::plan::overview::Overview;
        crate::replay::ReplayReport;
        crate::run::Run;
        crate::shard::Shard;
        crate::simulate::pulses::PulsesReport;
        crate::simulate::repeat::Simulation;
        crate::simulate::track::TrackReport;
        crate::study::architectures::ArchitectureComparison;
        crate::study::fidelity::FidelityReport;
        crate::study::limits::Limits;
        crate::study::reproduce::Reproduction;
        crate::study::stress::StressReport;
        crate::study::sweep::SweepOptions;
    }
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
