//! Tables `[[detector]]`.

use super::read::Clock;
use super::reader::{Bounds, Section};
use super::units::Quantity;
use super::{CounterTiming, Detector};

/// Longest afterpulsing time constant: a simulation starts thirty of them early.
const LONGEST_TIME_CONSTANT_PS: f64 = 1e10;
/// Largest jitter: detections of twenty of them are put in order.
const LARGEST_JITTER_CHIPS: f64 = (1_u32 << 16) as f64;

/// Reads one detector. `reference` is the index of the source it names, if that
/// is known, and `clock` is for the default pulse width.
pub(super) fn read(
    section: Section,
    reference: Option<usize>,
    clock: Option<Clock>,
) -> Option<Detector> {
    let name = section.get("name").and_then(|name| name.get_ref().as_str());
    let time = |key, example| section.quantity(key, Quantity::Time, Bounds::NotNegative, example);
    let rate = |key, example| section.quantity(key, Quantity::Rate, Bounds::NotNegative, example);
    let photon_detection_probability =
        section.number("photon_detection_probability", Bounds::Share, "0.31");
    let dark_count_rate_cps = rate("dark_count_rate", "71 kcps").unwrap_or(0.0);
    let background_rate_cps = rate("background_rate", "1 Mcps").unwrap_or(0.0);
    let dead_time_ps = time("dead_time", "14 ns");
    let has_dead_time = match dead_time_ps {
        Some(dead_time_ps) => dead_time_ps > 0.0,
        // One that cannot be read is complained about already.
        None => section.get("dead_time").is_some(),
    };
    let dead_time_ps = dead_time_ps.unwrap_or(0.0);
    let (afterpulsing_probability, afterpulsing_time_constant_ps) =
        read_afterpulsing(&section, has_dead_time);
    let pulse_width_ps = section.quantity("pulse_width", Quantity::Time, Bounds::Positive, "7 ns");
    let delay_ps = time("delay", "1.75 ns").unwrap_or(0.0);
    let jitter_ps = read_jitter(&section, clock);
    let counter = read_counter(&section);
    section.finish();
    Some(Detector {
        name: name?.to_owned(),
        reference: reference?,
        photon_detection_probability: photon_detection_probability.unwrap_or(1.0),
        dark_count_rate_cps,
        background_rate_cps,
        dead_time_ps,
        afterpulsing_probability,
        afterpulsing_time_constant_ps,
        pulse_width_ps: match pulse_width_ps {
            Some(width) => width,
            None => (0.5 * dead_time_ps).max(clock?.phase_step_ps()),
        },
        delay_ps,
        jitter_ps,
        counter,
    })
}

/// Probability and time constant in picoseconds; (0, 0) for no afterpulsing.
///
/// An avalanche begets -ln(1 - p) afterpulses on average. Without a dead time all
/// of them are avalanches, so that from one each on their number has no mean;
/// with one, those within it are lost, and no rate goes beyond one per dead time.
fn read_afterpulsing(detector: &Section, has_dead_time: bool) -> (f64, f64) {
    const EXAMPLE: &str = "{ probability = 0.137, time_constant = \"5 ns\" }";
    let Some(section) = detector.section("afterpulsing", EXAMPLE) else {
        return (0.0, 0.0);
    };
    section.require("probability", "0.137");
    section.require("time_constant", "\"5 ns\"");
    let probability = section.number("probability", Bounds::ProperShare, "0.137");
    let time_constant = section.quantity("time_constant", Quantity::Time, Bounds::Positive, "5 ns");
    if time_constant.is_some_and(|constant| constant > LONGEST_TIME_CONSTANT_PS)
        && let Some(value) = section.get("time_constant")
    {
        let message = format!(
            "{} is longer than any simulation could begin early enough for; write at most \"10 ms\"",
            section.excerpt(value)
        );
        section.report_at("time_constant", value, &message);
    }
    if let Some(probability) = probability
        && !has_dead_time
        && -(-probability).ln_1p() >= 1.0
    {
        let message = format!(
            "with {probability} and no dead time every avalanche begets {:.2} others on average, \
             without end; use less than 0.632 (1 - 1/e), or give the detector a dead_time",
            -(-probability).ln_1p()
        );
        section.report("probability", &message);
    }
    section.finish();
    (
        probability.unwrap_or_default(),
        time_constant.unwrap_or_default(),
    )
}

/// Standard deviations in picoseconds; those of 0 are dropped.
fn read_jitter(detector: &Section, clock: Option<Clock>) -> Vec<f64> {
    const KEY: &str = "jitter";
    let jitter_ps: Vec<f64> = detector
        .array(KEY, "[\"53.5 ps\", \"4 ps\"]")
        .into_iter()
        .flat_map(|array| array.iter())
        .filter_map(|value| {
            detector.quantity_of(KEY, value, Quantity::Time, Bounds::NotNegative, "53.5 ps")
        })
        .filter(|&deviation| deviation > 0.0)
        .collect();
    let together_ps = jitter_ps.iter().map(|s| s * s).sum::<f64>().sqrt();
    let most_ps = clock.map(|clock| LARGEST_JITTER_CHIPS * clock.chip_period_ps);
    if let Some(most_ps) = most_ps.filter(|&most_ps| together_ps > most_ps)
        && let Some(value) = detector.get(KEY)
    {
        let message = format!(
            "{} is more than {LARGEST_JITTER_CHIPS} chips in all; write at most \"{} ns\"",
            detector.excerpt(value),
            (most_ps / 1e3).floor()
        );
        detector.report_at(KEY, value, &message);
    }
    jitter_ps
}

fn read_counter(detector: &Section) -> CounterTiming {
    const EXAMPLE: &str = "{ rising_delay = \"340 ps\", falling_delay = \"390 ps\" }";
    let mut counter = CounterTiming {
        rising_delay_ps: 0.0,
        falling_delay_ps: 0.0,
        transition_ps: 0.0,
    };
    if let Some(section) = detector.section("counter", EXAMPLE) {
        let time = |key, example| {
            section
                .quantity(key, Quantity::Time, Bounds::NotNegative, example)
                .unwrap_or(0.0)
        };
        counter = CounterTiming {
            rising_delay_ps: time("rising_delay", "340 ps"),
            falling_delay_ps: time("falling_delay", "390 ps"),
            transition_ps: time("transition", "1.5 ps"),
        };
        section.finish();
    }
    counter
}
