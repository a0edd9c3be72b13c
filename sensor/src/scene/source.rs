//! Tables `[[source]]`, with their codes, and `[[path]]`.

use crate::scene::{DetectorIndex, SourceIndex};
use std::sync::Arc;

use super::budget;
use super::movement;
use super::names::Names;
use super::reader::Section;
use super::waveform;
use super::{Path, Source, SourceClock};
use crate::code::{Code, CodeSpec, Family};
use crate::light::{self, round_trip_ps};
use crate::scan::Clock;

pub(super) fn read(section: Section, clock: Option<Clock>) -> Option<Source> {
    let name = section.get("name").and_then(|name| name.get_ref().as_str());
    let code = section.section("code").and_then(read_code);
    let wavelength_nm = section.quantity("wavelength");
    let mean_power_w = section.quantity("mean_power");
    let extinction_ratio = section.number("extinction_ratio");
    let response = waveform::read_laser(&section, clock);
    let offset = section.quantity("clock_offset");
    let drift_per_s = section.quantity("clock_drift");
    section.finish();
    Some(Source {
        name: name?.to_owned(),
        code: Arc::new(code?),
        wavelength_nm: wavelength_nm?,
        mean_power_w: mean_power_w?,
        extinction_ratio: extinction_ratio?,
        response,
        clock: SourceClock { offset: offset?, drift_per_s: drift_per_s? },
    })
}

pub(super) fn read_path(
    section: Section,
    sources: &Names,
    detectors: &Names,
    clock: Option<Clock>,
) -> Option<Path> {
    let source = sources.resolve(&section, "source");
    let detector = detectors.resolve(&section, "detector");
    let distance_m = section.quantity("distance");
    let delay_ps = section.quantity("delay");
    match (section.get("distance"), section.get("delay")) {
        (Some(_), Some(_)) => section
            .report("delay", "the path has a distance already; give one of `distance` and `delay`"),
        (None, None) => section.complain(
            "neither `distance` nor `delay` is given; write for example distance = \"3.2 m\"",
        ),
        _ => {}
    }
    let transmission = section.number("transmission");
    let link = budget::read_link(&section, distance_m.or(delay_ps.map(light::distance_m)));
    let movement = movement::read(&section, clock);
    section.finish();
    Some(Path {
        source: SourceIndex(source?),
        detector: DetectorIndex(detector?),
        delay_ps: delay_ps.or(distance_m.map(round_trip_ps))?,
        transmission: link.or(transmission)?,
        movement,
    })
}

fn read_code(section: Section) -> Option<Code> {
    let family = section.choice("family", &Family::NAMES);
    let interleave = section.count("interleave");
    let spec = CodeSpec {
        // The other keys are read even if the family is not known.
        family: family.unwrap_or(Family::Gold),
        degree: section.count("degree"),
        index: section.integer("index"),
        interleave: interleave.unwrap_or(0),
        polynomials: read_polynomials(&section),
        seeds: read_seeds(&section),
        allow_non_preferred: section.boolean("allow_non_preferred"),
        chips: section.string("chips", "0110").map(str::to_owned),
    };
    let misread = [
        (section.get("degree").is_some(), spec.degree.is_some()),
        (section.get("interleave").is_some(), interleave.is_some()),
        (section.get("index").is_some(), spec.index.is_some()),
        (section.get("polynomials").is_some(), spec.polynomials.is_some()),
        (section.get("seeds").is_some(), spec.seeds.is_some()),
        (section.get("allow_non_preferred").is_some(), spec.allow_non_preferred.is_some()),
        (section.get("chips").is_some(), spec.chips.is_some()),
    ]
    .into_iter()
    .any(|(given, read)| given && !read);
    let code = match family {
        // What could not be read has been reported, and would be again.
        None => None,
        Some(_) if misread => None,
        Some(_) => {
            spec.build().map_err(|error| section.report(error.key(), &error.to_string())).ok()
        }
    };
    section.finish();
    code
}

/// `[[11, 2, 0], [11, 8, 5, 2, 0]]`; `None` if not given or wrong.
fn read_polynomials(section: &Section) -> Option<Vec<Vec<u32>>> {
    const KEY: &str = "polynomials";
    const EXAMPLE: &str = "[[11, 2, 0], [11, 8, 5, 2, 0]]";
    section
        .array(KEY, EXAMPLE)?
        .iter()
        .map(|polynomial| {
            section
                .array_of(KEY, polynomial, EXAMPLE)?
                .iter()
                .map(|exponent| {
                    let exponent = section.integer_of(KEY, exponent)?;
                    u32::try_from(exponent).ok()
                })
                .collect()
        })
        .collect()
}

/// `["111", "101"]`; `None` if not given or wrong.
fn read_seeds(section: &Section) -> Option<Vec<String>> {
    const KEY: &str = "seeds";
    section
        .array(KEY, "[\"11111\", \"11111\"]")?
        .iter()
        .map(|seed| section.string_of(KEY, seed, "11111").map(str::to_owned))
        .collect()
}
