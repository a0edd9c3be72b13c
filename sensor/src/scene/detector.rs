//! Tables `[[detector]]`.

use super::budget;
use super::reader::Section;
use super::{JitterTail, std_of_sum, waveform};
use crate::scan::Clock;
use crate::scene::SourceIndex;

/// Largest jitter: detections of twenty of them are put in order.
const LARGEST_JITTER_CHIPS: f64 = (1_u32 << 16) as f64;
/// The counter's edges are late by at most so many chips: the sign looks back over
/// the difference of their delays, chip by chip.
const MOST_EDGE_CHIPS: f64 = (1_u32 << 16) as f64;

/// A SPAD with its counter (Table I).
#[derive(Debug, Clone)]
pub struct Detector {
    /// Name that paths refer to.
    pub name: String,
    /// Index in [`Scene::sources`](super::Scene::sources) of the source whose code the sign follows.
    pub reference: SourceIndex,
    /// Chance that an incident photon fires a ready detector, 0..=1.
    pub photon_detection_probability: f64,
    /// Avalanches without light.
    pub dark_count_rate_cps: f64,
    /// Background, in photons before the detection probability.
    pub background_rate_cps: f64,
    /// Time after an avalanche in which nothing is counted.
    pub dead_time_ps: f64,
    /// What light does within the dead time.
    pub recharge: Recharge,
    /// Chance that an avalanche causes at least one afterpulse, 0..1.
    pub afterpulsing_probability: f64,
    /// Afterpulse delay's exponential time constant, from the dead time's end.
    pub afterpulsing_time_constant_ps: f64,
    /// Width of the digital pulse that a detection makes.
    pub pulse_width_ps: f64,
    /// Constant delay from avalanche to registered time.
    pub delay_ps: f64,
    /// Standard deviations of the independent Gaussian jitters.
    pub jitter_ps: Vec<f64>,
    /// The delay that a detection has beside these.
    pub jitter_tail: JitterTail,
    /// The continuous-time counter's edges.
    pub counter: CounterTiming,
}

impl Detector {
    /// One that counts every photon at once, without noise, dead time or jitter; its pulses
    /// are of `pulse_width_ps`.
    pub fn ideal(name: &str, reference: SourceIndex, pulse_width_ps: f64) -> Detector {
        Detector {
            name: name.to_owned(),
            reference,
            photon_detection_probability: 1.0,
            dark_count_rate_cps: 0.0,
            background_rate_cps: 0.0,
            dead_time_ps: 0.0,
            recharge: Recharge::Active,
            afterpulsing_probability: 0.0,
            afterpulsing_time_constant_ps: 0.0,
            pulse_width_ps,
            delay_ps: 0.0,
            jitter_ps: Vec::new(),
            jitter_tail: JitterTail::None,
            counter: CounterTiming {
                rising_delay_ps: 0.0,
                falling_delay_ps: 0.0,
                transition_ps: 0.0,
            },
        }
    }

    /// Whether light within the dead time prolongs it.
    pub fn is_paralyzable(&self) -> bool {
        self.recharge == Recharge::Passive && self.dead_time_ps > 0.0
    }

    /// Standard deviation of all jitters together.
    pub fn jitter_std_ps(&self) -> f64 {
        std_of_sum(&self.jitter_ps)
    }
}

/// What an arrival does within the dead time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Recharge {
    /// Nothing: the detector is quenched until the dead time ends (non-paralyzable).
    Active,
    /// It begins the dead time anew, uncounted: the detector recharges slowly and fires again
    /// before its pulse has left the comparator (paralyzable).
    Passive,
}

impl Recharge {
    /// Each of them, under the name that scenes use.
    pub const NAMES: [(&'static str, Recharge); 2] =
        [("active", Recharge::Active), ("passive", Recharge::Passive)];
}

/// Edge timing of the article's continuous-time counter (Table I).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CounterTiming {
    /// How late the sign's rising edge comes.
    pub rising_delay_ps: f64,
    /// How late the sign's falling edge comes.
    pub falling_delay_ps: f64,
    /// Within this distance of an edge either sign is equally likely.
    pub transition_ps: f64,
}

/// Reads one detector. `reference` is the index of the source it names, if that
/// is known, `clock` is for the default pulse width, and `wavelength_nm` is that source's.
pub(super) fn read(
    section: Section,
    reference: Option<usize>,
    clock: Option<Clock>,
    wavelength_nm: Option<f64>,
) -> Option<Detector> {
    let name = section.get("name").and_then(|name| name.get_ref().as_str());
    let from_budget_cps = budget::read_background(&section, wavelength_nm);
    let background_rate_cps = section.quantity("background_rate");
    let dead_time_ps = section.quantity("dead_time");
    let recharge = section.choice("recharge", &Recharge::NAMES);
    // One that cannot be read is complained about already.
    let has_dead_time = dead_time_ps.is_none_or(|dead_time_ps| dead_time_ps > 0.0);
    let (afterpulsing_probability, afterpulsing_time_constant_ps) =
        read_afterpulsing(&section, has_dead_time);
    let pulse_width_ps = section.quantity("pulse_width");
    let photon_detection_probability = section.number("photon_detection_probability");
    let dark_count_rate_cps = section.quantity("dark_count_rate");
    let delay_ps = section.quantity("delay");
    let jitter_ps = read_jitter(&section, clock);
    let jitter_tail = read_tail(&section, clock);
    let counter = read_counter(&section, clock);
    section.finish();
    let dead_time_ps = dead_time_ps?;
    Some(Detector {
        name: name?.to_owned(),
        reference: SourceIndex(reference?),
        photon_detection_probability: photon_detection_probability?,
        dark_count_rate_cps: dark_count_rate_cps?,
        background_rate_cps: from_budget_cps.or(background_rate_cps)?,
        dead_time_ps,
        recharge: recharge?,
        afterpulsing_probability,
        afterpulsing_time_constant_ps,
        pulse_width_ps: match pulse_width_ps {
            Some(width) => width,
            None => (0.5 * dead_time_ps).max(clock?.sample_period_ps()),
        },
        delay_ps: delay_ps?,
        jitter_ps,
        jitter_tail,
        counter: counter?,
    })
}

/// Probability and time constant in picoseconds; (0, 0) for no afterpulsing.
///
/// An avalanche begets -ln(1 - p) afterpulses on average. Without a dead time all
/// of them are avalanches, so that from one each on their number has no mean;
/// with one, those within it are lost, and no rate goes beyond one per dead time.
fn read_afterpulsing(detector: &Section, has_dead_time: bool) -> (f64, f64) {
    let Some(section) = detector.section("afterpulsing") else {
        return (0.0, 0.0);
    };
    let probability = section.number("probability");
    let time_constant = section.quantity("time_constant");
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
    (probability.unwrap_or_default(), time_constant.unwrap_or_default())
}

/// Standard deviations in picoseconds; those of 0 are dropped.
fn read_jitter(detector: &Section, clock: Option<Clock>) -> Vec<f64> {
    const KEY: &str = "jitter";
    let jitter_ps: Vec<f64> = detector
        .quantities(KEY, "[\"53.5 ps\", \"4 ps\"]")
        .into_iter()
        .filter(|&deviation| deviation > 0.0)
        .collect();
    let together_ps = std_of_sum(&jitter_ps);
    check_chips(detector, KEY, together_ps, LARGEST_JITTER_CHIPS, clock);
    jitter_ps
}

/// The tail of the jitter, no longer than the longest jitter reaches.
fn read_tail(detector: &Section, clock: Option<Clock>) -> JitterTail {
    let (tail, length_ps) = waveform::read_tail(detector);
    let key = match tail {
        JitterTail::Measured(_) => "jitter_histogram",
        _ => "jitter_tail",
    };
    check_chips(detector, key, length_ps, LARGEST_JITTER_CHIPS, clock);
    tail
}

/// Reports a time of more than `most` chips.
fn check_chips(
    section: &Section,
    key: &'static str,
    time_ps: f64,
    most: f64,
    clock: Option<Clock>,
) {
    let most_ps = clock.map(|clock| clock.ps(most));
    if let Some(most_ps) = most_ps.filter(|&most_ps| time_ps > most_ps)
        && let Some(value) = section.get(key)
    {
        let message = format!(
            "{} is more than {most} chips; write at most \"{} ns\"",
            section.excerpt(value),
            (most_ps / 1e3).floor()
        );
        section.report_at(key, value, &message);
    }
}

fn read_counter(detector: &Section, clock: Option<Clock>) -> Option<CounterTiming> {
    let section = detector.section_or_defaults("counter");
    let time = |key| {
        let time_ps = section.quantity(key);
        check_chips(&section, key, time_ps.unwrap_or_default(), MOST_EDGE_CHIPS, clock);
        time_ps
    };
    let [rising, falling, transition] = ["rising_delay", "falling_delay", "transition"].map(time);
    section.finish();
    Some(CounterTiming {
        rising_delay_ps: rising?,
        falling_delay_ps: falling?,
        transition_ps: transition?,
    })
}
