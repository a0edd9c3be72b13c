//! Tables `[[source]]`, with their codes, and `[[path]]`.

use crate::scene::{DetectorIndex, SourceIndex};
use std::sync::Arc;

use super::budget;
use super::declare::*;
use super::movement;
use super::names::TableNames;
use super::waveform;
use super::{Path, Source, SourceClock};
use crate::code::{Code, CodeSpec, Family, MAX_DEGREE, MAX_INTERLEAVE, MIN_DEGREE};
use crate::light::{self, round_trip_ps};
use crate::scan::Clock;

tables! {
    SOURCE = "source" {
        name = words("a text that is not empty", Form::Text), Needed, "\"laser\"";
            "what paths and detectors call it";
        code = table("source.code"), Needed, "{ family = \"gold\", degree = 11 }";
            "the code that it repeats without end";
        wavelength = quantity(Wavelength, "1 nm", "1 mm"), Or("783 nm"), "783 nm";
            "vacuum wavelength"
            "soft X-rays to far infrared: what photon counters exist for";
        mean_power = quantity(Power, "0 W", "1000 W"),
            Or("0 W: a source without light, for work on the hardware alone"), "4 pW";
            "optical power averaged over the code, at the source"
            "no laser is keyed chip by chip at more";
        extinction_ratio = ratio(1.0, 1e15), Or("\"inf\": no light in the off-state"), "10";
            "on-rate over off-rate, or \"inf\""
            "1 is light without a code; beyond 10^15 a double no longer tells the off-light \
             from none: write \"inf\"";
        clock_offset = quantity(ClockOffset, "-1000 ppm", "1000 ppm"),
            Or("0 ppm: it shares the detectors' clock"), "20 ppm";
            "how much faster than the detectors' its clock is; none for a reference"
            "ten times what the cheapest quartz may be off";
        clock_drift = quantity(ClockDrift, "-10 ppm/s", "10 ppm/s"), Or("0 ppm/s"), "0.1 ppm/s";
            "how much faster it gets"
            "a quartz that is heated by some degrees a second";
        rise_time = quantity(Time, "0 s", "1 ms"), Or("0 s"), "300 ps";
            "from 10 to 90 % of the light when it turns on, in a straight line, half of it at \
             the chip's edge"
            "no more than 80 % of a chip: an edge ends before the next one begins";
        fall_time = quantity(Time, "0 s", "1 ms"), Or("0 s"), "500 ps";
            "from 90 to 10 % when it turns off"
            "as for `rise_time`";
        duty_cycle_distortion = quantity(Time, "-5 ms", "5 ms"), Or("0 s"), "100 ps";
            "how much longer the light of a run of on-chips lasts than the chips, half of it before \
             and half after; the mean power is kept"
            "its edges come one after the other: beside rise and fall time less than a chip";
        impulse_response = words("rows of a time in ps and an amplitude, as CSV text", Form::Text),
            Otherwise("none"), "\"0,0.1\\n100,0.6\\n200,0.3\"";
            "in place of edges what a flash without width becomes, as measured, in equal \
             steps; its mean time is the chip's";
    }

    CODE = "source.code" {
        family = choice(const { &names(&Family::NAMES) }), Needed, "\"gold\"";
            "family of the code";
        degree = integer(MIN_DEGREE as i64, MAX_DEGREE as i64),
            Otherwise("none: Gold codes and m-sequences need it"), "11";
            "degree n of the polynomials: 2^n - 1 chips"
            "shorter ones make no Gold code; codes are kept in memory, chip by chip";
        index = integer(-2, (1 << MAX_DEGREE) - 2), Otherwise("0"), "0";
            "code of the Gold set, -2 to 2^n - 2"
            "codes of the largest set";
        interleave = integer(0, MAX_INTERLEAVE as i64), Or("0"), "1";
            "interleaving depth nu: 2^nu times as many chips"
            "codes are kept in memory, chip by chip";
        polynomials = integer(0, MAX_DEGREE as i64),
            Otherwise("a preferred pair; for an m-sequence its first polynomial"), "2";
            "lists of exponents, [[11, 2, 0], [11, 8, 5, 2, 0]]"
            "as for `degree`";
        seeds = words("a list of texts of n digits 0 and 1", Form::Texts),
            Otherwise("all ones"), "[\"11111\", \"11111\"]";
            "first n chips of each m-sequence";
        allow_non_preferred = BOOLEAN, Otherwise("false"), "true";
            "whether a pair that is not preferred may make a Gold set";
        chips = words("a text of digits 0 and 1", Form::Digits),
            Otherwise("none: family \"chips\" needs it"), "\"0110\"";
            "one period of the code, first chip first";
    }

    PATH = "path" {
        source = words("the name of a source", Form::Text), Needed, "\"laser\"";
            "where the light comes from";
        detector = words("the name of a detector", Form::Text), Needed, "\"spad\"";
            "where it arrives";
        distance = quantity(Distance, "0 m", "1500000 km"),
            Otherwise("none: `delay` stands for it"), "3.2 m";
            "half the optical path"
            "four times as far as the moon; as for `delay`";
        delay = quantity(Time, "0 s", "10.01 s"),
            Otherwise("none: `distance` stands for it"), "21.35 ns";
            "time of flight"
            "a double keeps 2 fs there, 0.3 um of distance";
        transmission = number(0.0, 1.0), Or("1"), "0.5";
            "share of the source's photons that arrive"
            "a share";
        link = table("path.link"),
            Otherwise("none: `transmission` stands for it"),
            "{ reflectance = 0.5, aperture = \"20 mm\" }";
            "in place of `transmission` what it follows from, at the path's distance";
        velocity = quantity(Speed, "-299 km/s", "299 km/s"),
            Or("0 m/s: the path stands still"), "1.5 m/s";
            "change of the distance; positive is away from the sensor"
            "a thousandth of the speed of light: no relativity is modelled";
        fluctuation = table("path.fluctuation"),
            Otherwise("none"), "{ std = \"2 mm\", correlation_time = \"1 ms\" }";
            "what the distance does at random beside that";
    }
}

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
    sources: &TableNames,
    detectors: &TableNames,
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
    let before = section.complaints();
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
    // What could not be read has been reported, and would be again.
    let is_read = section.complaints() == before;
    let built = is_read.then(|| spec.build());
    let code = built.and_then(|built| {
        built.map_err(|error| section.report(error.key(), &error.to_string())).ok()
    });
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
