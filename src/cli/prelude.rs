//! What commands are made with.

pub(super) use std::path::{Path, PathBuf};

pub(super) use clap::Args;
pub(super) use serde::Serialize;

pub(super) use super::common::{
    CheckArgument, Command, SceneArgument, ShardArguments, ShardOrder, parse_shard, warn,
};
pub(super) use super::forecast::Forecast;
pub(super) use super::output::{CommandOutput, Ending, terminal_width};
pub(super) use super::provenance::typed_command;
pub(super) use super::shards::InShards;
pub(super) use crate::files::OutputFolder;
pub(super) use crate::printable::{printable, printable_lines, printable_path};
pub(super) use crate::scene::SceneReference;
pub(super) use crate::sensor::Sensor;
pub(super) use crate::shard::{Job, JobPart, PartResults, Results};
