//! Tables `[[detector]]`.

use super::budget;
use super::declare::*;
use super::{JitterTail, Scene, sampler, std_of_sum, waveform};
use crate::scan::{Clock, Sampler};
use crate::scene::{Architecture, DetectorIndex, SourceIndex};

/// Largest jitter: detections of twenty of them are put in order.
const LARGEST_JITTER_CHIPS: f64 = (1_u32 << 16) as f64;
/// The counter's edges are late by at most so many chips: the sign looks back over
/// the difference of their delays, chip by chip.
const MOST_EDGE_CHIPS: f64 = (1_u32 << 16) as f64;

/// What a counter's edge may be late.
const EDGE: KeyKind = quantity(Quantity::Time, "0 s", "1 ms");

tables! {
    /// A SPAD with its counter (Table I).
    #[derive(Debug, Clone)]
    pub struct Detector {
        /// Name that paths refer to.
        name: String,
        /// Index in [`Scene::sources`](super::Scene::sources) of the source whose code the sign
        /// follows.
        reference: SourceIndex,
        /// Background, in photons before the detection probability.
        background_rate_cps: f64,
        /// Chance that an avalanche causes at least one afterpulse, 0..1.
        afterpulsing_probability: f64,
        /// Afterpulse delay's exponential time constant, from the dead time's end.
        afterpulsing_time_constant_ps: f64,
        /// Width of the digital pulse that a detection makes.
        pulse_width_ps: f64,
        /// Standard deviations of the independent Gaussian jitters.
        jitter_ps: Vec<f64>,
        /// The delay that a detection has beside these.
        jitter_tail: JitterTail,
        /// The continuous-time counter's edges.
        counter: CounterTiming,
        /// When the hardware samples its pulses.
        sampler: Sampler,
        /// What its avalanches cause at its neighbours.
        crosstalk: Option<Crosstalk>,
        /// Dark counts of each cell, where they are not spread evenly.
        cell_dark_count_rates_cps: Vec<f64>,
        /// What an avalanche of a cell causes at another one of the same detector.
        cell_crosstalk: Option<Crosstalk>,
    }
    of DETECTOR = "detector" {
        name = words("a text that is not empty", Form::Text), Needed, "\"spad\"";
            "what paths call it";
        reference = words("the name of a source", Form::Text), Needed, "\"laser\"";
            "source whose code the sign follows";
        photon_detection_probability => photon_detection_probability: f64 = number(0.0, 1.0), Or("1"), "0.31";
            "chance that an incident photon fires a ready detector"
            "a probability";
        dark_count_rate => dark_count_rate_cps: f64 = quantity(Rate, "0 cps", "1000000 Gcps"), Or("0 cps"), "71 kcps";
            "avalanches without light"
            "one in a femtosecond";
        background_rate = quantity(Rate, "0 cps", "1000000 Gcps"), Or("0 cps"), "1 Mcps";
            "background, in photons before the detection probability"
            "one in a femtosecond";
        background = table("detector.background"),
            Otherwise("none: `background_rate` stands for it"),
            "{ illuminance = \"10 klux\", filter_width = \"10 nm\", reflectance = 0.5, aperture = \"20 mm\", field_of_view = \"10 mrad\" }";
            "in place of `background_rate` what it follows from";
        dead_time => dead_time_ps: f64 = quantity(Time, "0 s", "10 ms"), Or("0 s"), "14 ns";
            "time after an avalanche in which the detector counts nothing"
            "a passively quenched detector with a slow counter has some microseconds; 10^5 \
             dead times of warm-up are within 64 bits of chips";
        recharge => recharge: Recharge = choice(Recharge::CHOICES), Or("\"active\""), "\"passive\"";
            "what light does within the dead time: nothing (\"active\", non-paralyzable), or \
             begin it anew (\"passive\", paralyzable), of which nothing is expected beside \
             afterpulsing";
        recharge_time_constant = quantity(Time, "1 fs", "1 ms"),
            Otherwise("`dead_time` stands for it"), "10 ns";
            "with `comparator_threshold` in place of `dead_time`, of `recharge = \"passive\"`: that of the \
             output's exponential fall, and D = tau ln(1 / threshold)"
            "the dead time is within its bounds with each threshold";
        comparator_threshold = number(0.0001, 0.9999),
            Otherwise("`dead_time` stands for it"), "0.25";
            "height of the output, as a share of its full one, above which the comparator shows a pulse"
            "as for `recharge_time_constant`: dead times of 0.0001 to 9.2 time constants";
        afterpulsing = table("detector.afterpulsing"),
            Otherwise("none"), "{ probability = 0.137, time_constant = \"5 ns\" }";
            "avalanches that an avalanche causes later";
        pulse_width = quantity(Time, "1 fs", "10 ms"),
            Otherwise("half the dead time, but at least a phase step"), "7 ns";
            "width of the digital pulse that a detection makes"
            "as for `dead_time`";
        delay => delay_ps: f64 = quantity(Time, "0 s", "1 ms"), Or("0 s"), "1.75 ns";
            "constant delay from avalanche to registered time"
            "200 km of cable";
        delay_std => delay_std_ps: f64 = quantity(Time, "0 s", "1 ms"), Or("0 s"), "20 ps";
            "standard deviation with which the delay is known: what is expected of a scan's distance takes it in"
            "as for `delay`";
        jitter = quantity(Time, "0 s", "1 ms"), Otherwise("none"), "53.5 ps";
            "list of the standard deviations of independent Gaussian jitters"
            "in all no more than 65,536 chips: detections of twenty of them are put in order";
        jitter_tail = table("detector.jitter_tail"),
            Otherwise("none"), "{ share = 0.1, time_constant = \"200 ps\" }";
            "further delay of some detections, beside the Gaussian ones: the diffusion tail";
        jitter_histogram = words("rows of a time from 0 ps on and an amplitude, as CSV text", Form::Text),
            Otherwise("none"), "\"0,0.9\\n100,0.07\\n200,0.03\"";
            "the same, as measured: the delay's distribution in equal steps";
        counter = table("detector.counter"),
            Otherwise("none"), "{ rising_delay = \"340 ps\", falling_delay = \"390 ps\" }";
            "edges of the article's continuous-time counter";
        sampler = table("detector.sampler"),
            Otherwise("samples are equally far apart"), "{ second_pin_skew = \"30 ps\" }";
            "when the hardware samples the pulses, where its samples are not equally far apart";
        crosstalk = table("detector.crosstalk"),
            Otherwise("none"), "{ probability = 0.02, delay = \"300 ps\" }";
            "avalanches that an avalanche causes at the detectors before and after this one in the \
             scene, expected to first order";
        cells => cells: u32 = integer(1, 64), Or("1"), "4";
            "SPADs behind the detector's input (a macropixel), each with its share of the light and \
             with dead time, afterpulses and pulses of its own; photons are simulated for several, and \
             expectations are of those that are added up (`combination`), alike, and fire no other"
            "the next arrival is looked for among all of them";
        combination => combination: Combination = choice(Combination::CHOICES), Or("\"or\""), "\"xor\"";
            "when cells' pulses make the level high: where `coincidence` of them overlap (\"or\"), or \
             where their number is odd, as behind a tree of XOR gates (\"xor\"); or each cell has a level, \
             whose edges all count (\"adder\")";
        cell_outputs => cell_outputs: CellOutputs = choice(CellOutputs::CHOICES), Or("\"combined\""), "\"separate\"";
            "whether the FPGA gets the combined level (\"combined\"), or each cell's (\"separate\") and combines \
             their samples; all detectors of a scene then have the same cells, combination and coincidence";
        coincidence => coincidence: u32 = integer(1, 64), Or("1"), "2";
            "how many cells' pulses have to overlap; 1 is an OR"
            "as for `cells`";
        cell_dark_count_rates = quantity(Rate, "0 cps", "1000000 Gcps"),
            Otherwise("`dark_count_rate`, spread evenly"), "10 kcps";
            "list of the dark counts of each cell, in place of `dark_count_rate`: hot cells"
            "one in a femtosecond";
        cell_crosstalk = table("detector.cell_crosstalk"),
            Otherwise("none"), "{ probability = 0.05, delay = \"100 ps\" }";
            "avalanches that an avalanche causes at another cell of the same detector";
    }

    CELL_CROSSTALK = "detector.cell_crosstalk" {
        probability = number(0.0, 1.0), Needed, "0.05";
            "chance that an avalanche fires another cell if that is ready, each as likely"
            "a probability";
        delay = quantity(Time, "0 s", "10 us"), Or("0 s"), "100 ps";
            "how much later"
            "no longer than a detection's own delays";
    }

    /// Avalanches that an avalanche causes at neighbouring detectors.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct Crosstalk {}
    of CROSSTALK = "detector.crosstalk" {
        probability => probability: f64 = number(0.0, 1.0), Needed, "0.02";
            "chance that an avalanche fires a neighbour that is ready, of each of them"
            "a probability";
        delay => delay_ps: f64 = quantity(Time, "0 s", "10 us"), Or("0 s"), "300 ps";
            "how much later"
            "no longer than a detection's own delays";
    }

    AFTERPULSING = "detector.afterpulsing" {
        probability = number(0.0, 0.999999), Needed, "0.137";
            "chance that an avalanche causes at least one afterpulse"
            "fourteen afterpulses for every avalanche";
        time_constant = quantity(Time, "1 fs", "10 ms"), Needed, "5 ns";
            "exponential time constant, from the dead time's end"
            "a simulation begins thirty of them early";
    }

    JITTER_TAIL = "detector.jitter_tail" {
        share = number(0.0, 1.0), Needed, "0.1";
            "share of the detections that come later"
            "a share";
        time_constant = quantity(Time, "1 fs", "10 us"), Needed, "200 ps";
            "mean of these delays, which are exponential"
            "a simulation begins thirty of them early; no longer than jitter may be";
    }

    /// Edge timing of the article's continuous-time counter (Table I).
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct CounterTiming {}
    of COUNTER = "detector.counter" {
        rising_delay => rising_delay_ps: f64 = EDGE, Or("0 s"), "340 ps";
            "how late the sign's rising edge comes"
            "no more than 65,536 chips: the sign looks back over the difference of the delays, \
             chip by chip";
        falling_delay => falling_delay_ps: f64 = EDGE, Or("0 s"), "390 ps";
            "how late the sign's falling edge comes"
            "as for `rising_delay`";
        transition => transition_ps: f64 = EDGE, Or("0 s"), "1.5 ps";
            "within this distance of an edge either sign is equally likely"
            "as for `rising_delay`";
    }
}

impl Detector {
    /// Mean number of afterpulses that an avalanche begets: the number is Poisson, and its
    /// chance to be at least one the afterpulsing probability.
    pub fn afterpulses_per_avalanche(&self) -> f64 {
        -(-self.afterpulsing_probability).ln_1p()
    }

    /// One that counts every photon at once, without noise, dead time or jitter; its pulses
    /// are of `pulse_width_ps`.
    pub fn ideal(name: &str, reference: SourceIndex, pulse_width_ps: f64) -> Detector {
        Detector { name: name.to_owned(), reference, pulse_width_ps, ..Detector::default() }
    }

    /// What its avalanches cause at its neighbours, if they cause anything.
    pub fn crosstalk(&self) -> Option<Crosstalk> {
        self.crosstalk.filter(|crosstalk| crosstalk.probability > 0.0)
    }

    /// One of its cells as a detector, which has its share of the light and its dark counts.
    #[must_use]
    pub fn cell(&self, number: u32) -> Detector {
        let share = 1.0 / f64::from(self.cells);
        let dark_count_rates_cps = &self.cell_dark_count_rates_cps;
        Detector {
            photon_detection_probability: share * self.photon_detection_probability,
            dark_count_rate_cps: match dark_count_rates_cps.get(number as usize) {
                Some(&rate_cps) => rate_cps,
                None => share * self.dark_count_rate_cps,
            },
            cells: 1,
            ..self.clone()
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

choices! {
    /// What an arrival does within the dead time.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum Recharge {
        /// Nothing: the detector is quenched until the dead time ends (non-paralyzable).
        Active = "active",
        /// It begins the dead time anew, uncounted: the detector recharges slowly and fires again
        /// before its pulse has left the comparator (paralyzable).
        Passive = "passive",
    }
}

impl Recharge {
    /// The other one.
    #[must_use]
    pub fn other(self) -> Recharge {
        match self {
            Recharge::Active => Recharge::Passive,
            Recharge::Passive => Recharge::Active,
        }
    }

    /// Its name in scenes.
    pub fn name(self) -> &'static str {
        Recharge::CHOICES[self as usize]
    }
}

choices! {
    /// What several cells' pulses make of the input's level.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum Combination {
        /// It is high while as many pulses overlap as [`Detector::coincidence`] says.
        Or = "or",
        /// It is high while an odd number of pulses is.
        Xor = "xor",
        /// Each has its own level, and the hits of all of them are added up.
        Adder = "adder",
    }
}

choices! {
    /// What comes to the FPGA of a detector's cells.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum CellOutputs {
        /// The level that their pulses make together.
        Combined = "combined",
        /// Each one's own level.
        Separate = "separate",
    }
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
    let mut keys = Detector::keys(&section);
    let of_comparator_ps = read_comparator(&section, keys.as_ref().map(|keys| keys.recharge));
    if let (Some(keys), Some(dead_time_ps)) = (&mut keys, of_comparator_ps) {
        keys.dead_time_ps = dead_time_ps;
    }
    let from_budget_cps = budget::read_background(&section, wavelength_nm);
    let background_rate_cps = section.quantity("background_rate");
    // What cannot be read is complained about already.
    let has_dead_time = keys.as_ref().is_none_or(|keys| keys.dead_time_ps > 0.0);
    let (afterpulsing_probability, afterpulsing_time_constant_ps) =
        read_afterpulsing(&section, has_dead_time);
    let pulse_width_ps = section.quantity("pulse_width");
    let jitter_ps = read_jitter(&section, clock);
    let jitter_tail = read_tail(&section, clock);
    let counter = read_counter(&section, clock);
    let sampler = sampler::read(&section, clock);
    let crosstalk = read_crosstalk(&section, "crosstalk");
    let cell_dark_count_rates_cps =
        section.quantities("cell_dark_count_rates", "[\"10 kcps\", \"1 Mcps\"]");
    let cell_crosstalk = read_crosstalk(&section, "cell_crosstalk");
    if let Some(keys) = &keys {
        check_cells(&section, keys, &cell_dark_count_rates_cps, cell_crosstalk);
    }
    section.finish();
    let keys = keys?;
    let half_dead_time = || Some((0.5 * keys.dead_time_ps).max(clock?.sample_period_ps()));
    Some(Detector {
        name: name?.to_owned(),
        reference: SourceIndex(reference?),
        background_rate_cps: from_budget_cps.or(background_rate_cps)?,
        afterpulsing_probability,
        afterpulsing_time_constant_ps,
        pulse_width_ps: pulse_width_ps.or_else(half_dead_time)?,
        jitter_ps,
        jitter_tail,
        counter: counter?,
        sampler: sampler?,
        crosstalk,
        dark_count_rate_cps: match cell_dark_count_rates_cps.is_empty() {
            true => keys.dark_count_rate_cps,
            false => cell_dark_count_rates_cps.iter().sum(),
        },
        cell_dark_count_rates_cps,
        cell_crosstalk,
        ..keys
    })
}

/// The dead time of an output that falls exponentially from an avalanche on, until a comparator's threshold; none
/// of a detector that does not say these. What does not hold together is reported.
fn read_comparator(section: &Section, recharge: Option<Recharge>) -> Option<f64> {
    const TIME_CONSTANT: &str = "recharge_time_constant";
    const THRESHOLD: &str = "comparator_threshold";
    let time_constant_ps = section.quantity(TIME_CONSTANT);
    let threshold = section.number(THRESHOLD);
    let [has_time_constant, has_threshold, has_dead_time] =
        [TIME_CONSTANT, THRESHOLD, "dead_time"].map(|key| section.get(key).is_some());
    let alone = |other: &str| match has_dead_time {
        true => {
            "dead_time is given, and follows from this and another key together; leave this out"
                .to_owned()
        }
        false => {
            format!("alone it gives no dead time; write {other}, too, or dead_time in its place")
        }
    };
    match (has_time_constant, has_threshold) {
        (false, false) => {}
        (true, false) => section.report(TIME_CONSTANT, &alone(THRESHOLD)),
        (false, true) => section.report(THRESHOLD, &alone(TIME_CONSTANT)),
        (true, true) if has_dead_time => section.report(
            THRESHOLD,
            "dead_time is given, too, and follows from recharge_time_constant and comparator_threshold; \
             leave out it or both of these",
        ),
        (true, true) if recharge == Some(Recharge::Active) => section.report(
            THRESHOLD,
            "with recharge = \"active\" a circuit ends the dead time; write recharge = \"passive\", or \
             dead_time in place of recharge_time_constant and this",
        ),
        (true, true) => return Some(time_constant_ps? * -threshold?.ln()),
    }
    None
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

fn read_crosstalk(detector: &Section, key: &'static str) -> Option<Crosstalk> {
    let section = detector.section(key)?;
    let crosstalk = Crosstalk::keys(&section);
    section.finish();
    crosstalk
}

/// Reports what is said of cells and does not hold together.
fn check_cells(
    section: &Section,
    keys: &Detector,
    dark_count_rates_cps: &[f64],
    crosstalk: Option<Crosstalk>,
) {
    let Detector { cells, coincidence, combination, .. } = *keys;
    if coincidence > cells {
        let message = format!("no {coincidence} pulses overlap of cells = {cells}; write fewer");
        section.report("coincidence", &message);
    } else if coincidence > 1 && combination != Combination::Or {
        let takes = match combination {
            Combination::Adder => "\"adder\" counts every pulse",
            _ => "\"xor\" takes an odd number of pulses",
        };
        let message = format!("combination = {takes}; leave one of the two out");
        section.report("coincidence", &message);
    }
    if combination == Combination::Adder && keys.cell_outputs == CellOutputs::Combined {
        section.report(
            "combination",
            "\"adder\" adds up the edges of cells that have an input each; write cell_outputs = \
             \"separate\", or take \"or\" or \"xor\"",
        );
    }
    let given = dark_count_rates_cps.len();
    if given > 0 && given != cells as usize {
        let message = format!("{given} rates for cells = {cells}; write one for each cell");
        section.report("cell_dark_count_rates", &message);
    } else if given > 0 && section.get("dark_count_rate").is_some() {
        section.report("cell_dark_count_rates", "dark_count_rate is given, too; leave it out");
    }
    if crosstalk.is_none() {
        return;
    }
    let report = |message: &str| section.report("cell_crosstalk", message);
    if cells == 1 {
        report("the detector has no other cell; leave it out, or write cells = 2 or more");
    } else if keys.dead_time_ps == 0.0 {
        report("cells without dead time would fire one another without end; give it a dead_time");
    } else if keys.is_paralyzable() {
        report(
            "it is simulated between cells of recharge = \"active\" alone; leave one of the two out",
        );
    }
}

/// Reports separate outputs that the hardware is not made for.
pub(super) fn check_cell_outputs(sections: &[Section], scene: &Scene) {
    if scene.detectors.iter().all(|spad| spad.cell_outputs == CellOutputs::Combined) {
        return;
    }
    let law = |spad: &Detector| (spad.cell_outputs, spad.cells, spad.combination, spad.coincidence);
    for (section, spad) in sections.iter().zip(&scene.detectors) {
        let report = |message: &str| section.report("cell_outputs", message);
        if law(spad) != law(&scene.detectors[0]) {
            report(
                "separate outputs are combined alike for all detectors of a scene: write the same \
                 cell_outputs, cells, combination and coincidence for each, or leave this key out of all",
            );
        } else if spad.cells == 1 {
            report("cells = 1 has one output; write cells = 2 or more, or leave out this key");
        } else if spad.combination == Combination::Adder
            && scene.hardware.architecture == Architecture::Histogram
        {
            section.report(
                "combination",
                "a bin of a histogram takes one hit at a time, and \"adder\" has several; take \"or\" or \
                 \"xor\", or count up and down (hardware.architecture = \"updown\")",
            );
        }
    }
}

/// Detectors that fire one another are simulated together, each of them for each.
pub(super) const MOST_TALKING: usize = 16;

/// Reports crosstalk that is not simulated: without dead time avalanches would cause one another
/// without end, and one that arrivals begin anew rests on what other detectors do later.
pub(super) fn check_crosstalk(sections: &[Section], scene: &Scene) {
    let mut talking = 0;
    for (number, (section, spad)) in sections.iter().zip(&scene.detectors).enumerate() {
        if spad.crosstalk().is_none() {
            continue;
        }
        let mut all =
            Scene::neighbours(scene, DetectorIndex(number)).chain([DetectorIndex(number)]);
        if all.any(|one| scene.detectors[one].cells > 1) {
            section.report(
                "crosstalk",
                "it is simulated between detectors of one cell each; leave out cells, or this",
            );
            continue;
        }
        talking += 1;
        let mut heard = Scene::neighbours(scene, DetectorIndex(number));
        let report = |message: &str| section.report("crosstalk", message);
        if talking > MOST_TALKING {
            report(&format!(
                "{MOST_TALKING} detectors of a scene have it already; leave out those of others"
            ));
        } else if scene.detectors.len() == 1 {
            report("the scene has no other detector; leave it out, or write a second [[detector]]");
        } else if spad.dead_time_ps == 0.0 {
            report(
                "detectors without dead time would fire one another without end; give it a dead_time",
            );
        } else if spad.is_paralyzable()
            || heard.any(|other| scene.detectors[other].is_paralyzable())
        {
            report(
                "it is simulated between detectors of recharge = \"active\" alone; leave one of the \
                 two out",
            );
        }
    }
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
    let counter = CounterTiming::keys(&section);
    if let Some(CounterTiming { rising_delay_ps, falling_delay_ps, transition_ps }) = counter {
        check_chips(&section, "rising_delay", rising_delay_ps, MOST_EDGE_CHIPS, clock);
        check_chips(&section, "falling_delay", falling_delay_ps, MOST_EDGE_CHIPS, clock);
        check_chips(&section, "transition", transition_ps, MOST_EDGE_CHIPS, clock);
    }
    section.finish();
    counter
}
