//! Tables `[[source]]`, with their codes, and `[[path]]`.

use crate::scene::{DetectorIndex, SourceIndex};
use std::sync::Arc;

use toml::de::DeValue;

use super::budget;
use super::keys::SOURCE;
use super::movement;
use super::names::Names;
use super::reader::Section;
use super::waveform;
use super::{Path, Source, SourceClock};
use crate::code::{Code, CodeSpec, Family};
use crate::light::{self, round_trip_ps};
use crate::scan::Clock;

const CODE_EXAMPLE: &str = "{ family = \"gold\", degree = 11 }";

/// That of the article's laser.
const DEFAULT_WAVELENGTH_NM: f64 = 783.0;

pub(super) fn read(section: Section, clock: Option<Clock>) -> Option<Source> {
    section.require("code");
    let name = section.get("name").and_then(|name| name.get_ref().as_str());
    let code = section.section("code", CODE_EXAMPLE).and_then(read_code);
    let quantity = |name, default| match section.get(name) {
        None => Some(default),
        Some(_) => section.quantity(name),
    };
    let wavelength_nm = quantity("wavelength", DEFAULT_WAVELENGTH_NM);
    let mean_power_w = quantity("mean_power", 0.0);
    let extinction_ratio = read_extinction_ratio(&section);
    let response = waveform::read_laser(&section, clock);
    let source_clock = SourceClock {
        offset: section.quantity("clock_offset").unwrap_or(0.0),
        drift_per_s: section.quantity("clock_drift").unwrap_or(0.0),
    };
    section.finish();
    Some(Source {
        name: name?.to_owned(),
        code: Arc::new(code?),
        wavelength_nm: wavelength_nm?,
        mean_power_w: mean_power_w?,
        extinction_ratio,
        response,
        clock: source_clock,
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
        transmission: link.or(transmission).unwrap_or(1.0),
        movement,
    })
}

/// On-rate over off-rate: a number, or "inf", which is the default.
fn read_extinction_ratio(section: &Section) -> f64 {
    const NAME: &str = "extinction_ratio";
    let key = SOURCE.key(NAME);
    let Some(value) = section.get(NAME) else {
        return f64::INFINITY;
    };
    let ratio: Option<f64> = match value.get_ref() {
        DeValue::String(text) if text == "inf" => return f64::INFINITY,
        DeValue::Float(digits) => digits.as_str().parse().ok(),
        DeValue::Integer(digits) => digits.to_string().parse().ok(),
        _ => None,
    };
    let shown = section.excerpt(value);
    let message = match ratio {
        Some(ratio) if key.holds(ratio) || ratio == f64::INFINITY => return ratio,
        Some(_) => key.outside(&shown),
        None => format!("{shown} is no ratio; write for example {}", key.example),
    };
    section.report_at(NAME, value, &format!("{message}, or \"inf\""));
    f64::INFINITY
}

fn read_code(section: Section) -> Option<Code> {
    section.require("family");
    let family = section.choice("family", &Family::NAMES);
    let number = |key| {
        let number = section.integer(key)?;
        u32::try_from(number).ok()
    };
    let interleave = number("interleave");
    let spec = CodeSpec {
        // The other keys are read even if the family is not known.
        family: family.unwrap_or(Family::Gold),
        degree: number("degree"),
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
    .any(|(given, read)| given != read);
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
