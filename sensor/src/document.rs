//! JSON documents: what every one of them begins with, and what else it holds.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};

use crate::scene::{Scene, SceneReference};
use crate::version::VERSION;

/// What a JSON document holds behind its head.
pub trait Body: Serialize {
    /// Which document it is; its schema is `docs/json/NAME.schema.json`.
    const NAME: &'static str;
}

impl<B: Body> Body for &B {
    const NAME: &'static str = B::NAME;
}

/// A JSON document: the head that all have, and the body of its kind.
///
/// Names say what a number is and end in its unit (`true_distance_m`, `frame_time_s`,
/// `result_latency_clocks`); shares end in `_fraction`, what is in standard deviations in
/// `_in_std`, 95 % confidence intervals in `_ci95`. Counts of things are the things' name
/// (`clocks`, `phase_steps`). Signed numbers are signed. A field that has no value is null.
///
/// ```
/// # mod goldtof {
/// #     pub use goldtof_sensor::*;
/// # }
/// # std::env::set_current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))?;
/// use std::path::Path;
///
/// use goldtof::document::{Body, Document};
///
/// #[derive(serde::Serialize)]
/// struct Found {
///     distance_m: f64,
/// }
///
/// impl Body for Found {
///     const NAME: &'static str = "found";
/// }
///
/// let scene = goldtof::scene::load(Path::new("scenes/quick.toml"))?;
/// let document = Document::new(Found { distance_m: 3.2 }, "my-program", Some(&scene));
/// let json = serde_json::to_value(&document)?;
/// assert_eq!(json["document"], "found");
/// assert_eq!(json["scene"]["name"], "quick");
/// assert_eq!(json["distance_m"], 3.2);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Document<B> {
    /// Which document this is: the schema's name.
    pub document: Cow<'static, str>,
    /// Version of goldtof, with its commit where that is known.
    pub goldtof: Cow<'static, str>,
    /// The command that made it.
    pub command: String,
    /// The scene that it is of; null where there is none.
    pub scene: Option<SceneReference>,
    /// What it holds.
    #[serde(flatten)]
    pub body: B,
}

impl<B: Body> Document<B> {
    /// A document that `command` made of a scene.
    pub fn new(body: B, command: impl Into<String>, scene: Option<&Scene>) -> Document<B> {
        Document {
            document: Cow::Borrowed(B::NAME),
            goldtof: Cow::Borrowed(VERSION),
            command: command.into(),
            scene: scene.map(Scene::reference),
            body,
        }
    }
}
