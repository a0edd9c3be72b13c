//! Every key, once: what it takes, what it is when it is left out, an example; what it
//! means; and where its bounds come from.

use super::Absent::{Needed, Or, Otherwise};
use super::{
    BOOLEAN, Form, Key, Kind, Table, choice, integer, names, number, quantity, ratio, table, words,
};
use crate::code::{Family, MAX_CODE_CHIPS, MAX_DEGREE, MAX_INTERLEAVE, MIN_DEGREE};
use crate::scene::units::Quantity::{
    Angle, ClockDrift, ClockOffset, Distance, Illuminance, Power, Rate, SpectralIrradiance, Speed,
    Time, Wavelength,
};
use crate::scene::{Architecture, EstimatorKind, OtherLight, Polarity, Recharge, Target};

/// Most phase steps of a code period: the longest code, with the most samples.
const MOST_PHASE_STEPS: i64 = (MAX_CODE_CHIPS * 64) as i64;
/// A full angle.
const ANGLE: Kind = quantity(Angle, "1e-3 urad", "3 rad");
/// What a counter's edge may be late.
const EDGE: Kind = quantity(Time, "0 s", "1 ms");

/// Tables of keys: `key: kind, when left out, example; "meaning" "why these bounds";`
macro_rules! tables {
    ($($name:ident = $path:literal $(and $shared:ident)? {
        $($key:ident: $kind:expr, $absent:expr, $example:literal; $meaning:literal $($why:literal)?;)*
    })*) => {$(
        pub(in crate::scene) static $name: Table = Table {
            path: $path,
            keys: &[$(Key {
                name: stringify!($key),
                kind: $kind,
                absent: $absent,
                example: $example,
                meaning: $meaning,
                why: concat!("", $($why)?),
            },)*],
            shared: &[$(&$shared)?],
        };
    )*};
}

tables! {
    SOURCE = "source" {
        name: words("a text that is not empty", Form::Text), Needed, "\"laser\"";
            "what paths and detectors call it";
        code: table("source.code"), Needed, "{ family = \"gold\", degree = 11 }";
            "the code that it repeats without end";
        wavelength: quantity(Wavelength, "1 nm", "1 mm"), Or("783 nm"), "783 nm";
            "vacuum wavelength"
            "soft X-rays to far infrared: what photon counters exist for";
        mean_power: quantity(Power, "0 W", "1000 W"),
            Or("0 W: a source without light, for work on the hardware alone"), "4 pW";
            "optical power averaged over the code, at the source"
            "no laser is keyed chip by chip at more";
        extinction_ratio: ratio(1.0, 1e15), Or("\"inf\": no light in the off-state"), "10";
            "on-rate over off-rate, or \"inf\""
            "1 is light without a code; beyond 10^15 a double no longer tells the off-light \
             from none: write \"inf\"";
        clock_offset: quantity(ClockOffset, "-1000 ppm", "1000 ppm"),
            Or("0 ppm: it shares the detectors' clock"), "20 ppm";
            "how much faster than the detectors' its clock is; none for a reference"
            "ten times what the cheapest quartz may be off";
        clock_drift: quantity(ClockDrift, "-10 ppm/s", "10 ppm/s"), Or("0 ppm/s"), "0.1 ppm/s";
            "how much faster it gets"
            "a quartz that is heated by some degrees a second";
        rise_time: quantity(Time, "0 s", "1 ms"), Or("0 s"), "300 ps";
            "from 10 to 90 % of the light when it turns on, in a straight line, half of it at \
             the chip's edge"
            "no more than 80 % of a chip: an edge ends before the next one begins";
        fall_time: quantity(Time, "0 s", "1 ms"), Or("0 s"), "500 ps";
            "from 90 to 10 % when it turns off"
            "as for `rise_time`";
        impulse_response: words("rows of a time in ps and an amplitude, as CSV text", Form::Text),
            Otherwise("none"), "\"0,0.1\\n100,0.6\\n200,0.3\"";
            "in place of edges what a flash without width becomes, as measured, in equal \
             steps; its mean time is the chip's";
    }

    CODE = "source.code" {
        family: choice(const { &names(&Family::NAMES) }), Needed, "\"gold\"";
            "family of the code";
        degree: integer(MIN_DEGREE as i64, MAX_DEGREE as i64),
            Otherwise("none: Gold codes and m-sequences need it"), "11";
            "degree n of the polynomials: 2^n - 1 chips"
            "shorter ones make no Gold code; codes are kept in memory, chip by chip";
        index: integer(-2, (1 << MAX_DEGREE) - 2), Otherwise("0"), "0";
            "code of the Gold set, -2 to 2^n - 2"
            "codes of the largest set";
        interleave: integer(0, MAX_INTERLEAVE as i64), Or("0"), "1";
            "interleaving depth nu: 2^nu times as many chips"
            "codes are kept in memory, chip by chip";
        polynomials: integer(0, MAX_DEGREE as i64),
            Otherwise("a preferred pair; for an m-sequence its first polynomial"), "2";
            "lists of exponents, [[11, 2, 0], [11, 8, 5, 2, 0]]"
            "as for `degree`";
        seeds: words("a list of texts of n digits 0 and 1", Form::Texts),
            Otherwise("all ones"), "[\"11111\", \"11111\"]";
            "first n chips of each m-sequence";
        allow_non_preferred: BOOLEAN, Otherwise("false"), "true";
            "whether a pair that is not preferred may make a Gold set";
        chips: words("a text of digits 0 and 1", Form::Digits),
            Otherwise("none: family \"chips\" needs it"), "\"0110\"";
            "one period of the code, first chip first";
    }

    PATH = "path" {
        source: words("the name of a source", Form::Text), Needed, "\"laser\"";
            "where the light comes from";
        detector: words("the name of a detector", Form::Text), Needed, "\"spad\"";
            "where it arrives";
        distance: quantity(Distance, "0 m", "1500000 km"),
            Otherwise("none: `delay` stands for it"), "3.2 m";
            "half the optical path"
            "four times as far as the moon; as for `delay`";
        delay: quantity(Time, "0 s", "10.01 s"),
            Otherwise("none: `distance` stands for it"), "21.35 ns";
            "time of flight"
            "a double keeps 2 fs there, 0.3 um of distance";
        transmission: number(0.0, 1.0), Or("1"), "0.5";
            "share of the source's photons that arrive"
            "a share";
        link: table("path.link"),
            Otherwise("none: `transmission` stands for it"),
            "{ reflectance = 0.5, aperture = \"20 mm\" }";
            "in place of `transmission` what it follows from, at the path's distance";
        velocity: quantity(Speed, "-299 km/s", "299 km/s"),
            Or("0 m/s: the path stands still"), "1.5 m/s";
            "change of the distance; positive is away from the sensor"
            "a thousandth of the speed of light: no relativity is modelled";
        fluctuation: table("path.fluctuation"),
            Otherwise("none"), "{ std = \"2 mm\", correlation_time = \"1 ms\" }";
            "what the distance does at random beside that";
    }

    RECEIVER = "" {
        reflectance: number(0.0, 1.0), Needed, "0.5";
            "share of the light that the target sends back, in all directions (Lambertian)"
            "a share";
        aperture: quantity(Distance, "1 um", "10 m"), Needed, "20 mm";
            "diameter of the receiving lens"
            "from a bare detector to the largest telescope";
        optics: number(0.0, 1.0), Or("1"), "0.7";
            "transmission of lenses and filter at the source's wavelength"
            "a share";
        fill_factor: number(0.0, 1.0), Or("1"), "0.3";
            "share of the detector's area that detects"
            "a share";
    }

    LINK = "path.link" and RECEIVER {
        divergence: ANGLE, Otherwise("none: the spot is in the field of view"), "20 mrad";
            "full angle of the source's cone, evenly lit"
            "lenses look forwards";
        field_of_view: ANGLE, Otherwise("none: the spot is in the field of view"), "10 mrad";
            "full angle of the detector's cone; of a larger spot the part within it counts"
            "as for `divergence`";
    }

    BACKGROUND = "detector.background" and RECEIVER {
        illuminance: quantity(Illuminance, "0 lux", "1000 klux"),
            Otherwise("none: `irradiance` stands for it"), "10 klux";
            "sunlight on the target, whose spectrum is known from 350 nm to 1700 nm, for filters of 1 nm and more"
            "nine suns at noon";
        irradiance: quantity(SpectralIrradiance, "0 W/m2/nm", "1000 W/m2/nm"),
            Otherwise("none: `illuminance` stands for it"), "100 mW/m2/nm";
            "light on the target near the source's wavelength"
            "the sun has less than two";
        filter_width: quantity(Wavelength, "1e-6 nm", "10 um"), Needed, "10 nm";
            "width of the filter that passes the source's wavelength"
            "from a laser's line to no filter at all";
        field_of_view: ANGLE, Needed, "10 mrad";
            "full angle of the cone that the detector sees, filled by the target"
            "as for `divergence`";
    }

    FLUCTUATION = "path.fluctuation" {
        std: quantity(Distance, "0 m", "1000 km"), Needed, "2 mm";
            "standard deviation of the distance"
            "light must not overtake itself: see what depends on several keys";
        correlation_time: quantity(Time, "16 ps", "10000 h"), Needed, "1 ms";
            "time after which the correlation is 1/e"
            "16 of the shortest chips; a year";
    }

    DETECTOR = "detector" {
        name: words("a text that is not empty", Form::Text), Needed, "\"spad\"";
            "what paths call it";
        reference: words("the name of a source", Form::Text), Needed, "\"laser\"";
            "source whose code the sign follows";
        photon_detection_probability: number(0.0, 1.0), Or("1"), "0.31";
            "chance that an incident photon fires a ready detector"
            "a probability";
        dark_count_rate: quantity(Rate, "0 cps", "1000000 Gcps"), Or("0 cps"), "71 kcps";
            "avalanches without light"
            "one in a femtosecond";
        background_rate: quantity(Rate, "0 cps", "1000000 Gcps"), Or("0 cps"), "1 Mcps";
            "background, in photons before the detection probability"
            "one in a femtosecond";
        background: table("detector.background"),
            Otherwise("none: `background_rate` stands for it"),
            "{ illuminance = \"10 klux\", filter_width = \"10 nm\", reflectance = 0.5, aperture = \"20 mm\", field_of_view = \"10 mrad\" }";
            "in place of `background_rate` what it follows from";
        dead_time: quantity(Time, "0 s", "10 ms"), Or("0 s"), "14 ns";
            "time after an avalanche in which the detector counts nothing"
            "a passively quenched detector with a slow counter has some microseconds; 10^5 \
             dead times of warm-up are within 64 bits of chips";
        recharge: choice(const { &names(&Recharge::NAMES) }), Or("\"active\""), "\"passive\"";
            "what light does within the dead time: nothing (\"active\", non-paralyzable), or \
             begin it anew (\"passive\", paralyzable), which photons are simulated for and \
             nothing is expected of";
        afterpulsing: table("detector.afterpulsing"),
            Otherwise("none"), "{ probability = 0.137, time_constant = \"5 ns\" }";
            "avalanches that an avalanche causes later";
        pulse_width: quantity(Time, "1 fs", "10 ms"),
            Otherwise("half the dead time, but at least a phase step"), "7 ns";
            "width of the digital pulse that a detection makes"
            "as for `dead_time`";
        delay: quantity(Time, "0 s", "1 ms"), Or("0 s"), "1.75 ns";
            "constant delay from avalanche to registered time"
            "200 km of cable";
        jitter: quantity(Time, "0 s", "1 ms"), Otherwise("none"), "53.5 ps";
            "list of the standard deviations of independent Gaussian jitters"
            "in all no more than 65,536 chips: detections of twenty of them are put in order";
        jitter_tail: table("detector.jitter_tail"),
            Otherwise("none"), "{ share = 0.1, time_constant = \"200 ps\" }";
            "further delay of some detections, beside the Gaussian ones: the diffusion tail";
        jitter_histogram: words("rows of a time from 0 ps on and an amplitude, as CSV text", Form::Text),
            Otherwise("none"), "\"0,0.9\\n100,0.07\\n200,0.03\"";
            "the same, as measured: the delay's distribution in equal steps";
        counter: table("detector.counter"),
            Otherwise("none"), "{ rising_delay = \"340 ps\", falling_delay = \"390 ps\" }";
            "edges of the article's continuous-time counter";
    }

    AFTERPULSING = "detector.afterpulsing" {
        probability: number(0.0, 0.999999), Needed, "0.137";
            "chance that an avalanche causes at least one afterpulse"
            "fourteen afterpulses for every avalanche";
        time_constant: quantity(Time, "1 fs", "10 ms"), Needed, "5 ns";
            "exponential time constant, from the dead time's end"
            "a simulation begins thirty of them early";
    }

    JITTER_TAIL = "detector.jitter_tail" {
        share: number(0.0, 1.0), Needed, "0.1";
            "share of the detections that come later"
            "a share";
        time_constant: quantity(Time, "1 fs", "10 us"), Needed, "200 ps";
            "mean of these delays, which are exponential"
            "a simulation begins thirty of them early; no longer than jitter may be";
    }

    COUNTER = "detector.counter" {
        rising_delay: EDGE, Or("0 s"), "340 ps";
            "how late the sign's rising edge comes"
            "no more than 65,536 chips: the sign looks back over the difference of the delays, \
             chip by chip";
        falling_delay: EDGE, Or("0 s"), "390 ps";
            "how late the sign's falling edge comes"
            "as for `rising_delay`";
        transition: EDGE, Or("0 s"), "1.5 ps";
            "within this distance of an edge either sign is equally likely"
            "as for `rising_delay`";
    }

    CLOCK = "clock" {
        chip_period: quantity(Time, "1 ps", "10 ms"), Needed, "8 ns";
            "chip period T_c; one clock of the hardware"
            "1 THz is beyond any hardware, and a delay of 10 s still counts in chips to \
             0.002; slower than 100 Hz nothing is sampled";
        samples_per_chip: integer(1, 64), Or("8"), "8";
            "samples, and phase steps, per chip S; a power of two"
            "a clock's samples of a detector are one word of 64 bits";
    }

    SCAN = "scan" {
        integration: quantity(Time, "1 ps", "1000000 s"), Needed, "100 us";
            "integration time of a phase step, rounded to whole chips; of a histogram, to \
             whole code periods"
            "the shortest chip period; eleven days, in which the number of samples stays within 64 \
             bits";
        steps: words("\"all\" or a table of phase steps", Form::AllOr("scan.steps")),
            Otherwise("\"all\""), "\"all\"";
            "which phase steps are measured";
    }

    STEPS = "scan.steps" {
        first: integer(0, MOST_PHASE_STEPS - 1),
            Otherwise("none: the window is given with `around`"), "0";
            "first phase step, less than those of a code period"
            "phase steps of the longest code, 2^24 chips, with 64 samples per chip";
        count: integer(1, MOST_PHASE_STEPS),
            Otherwise("none: the window is given with `around`"), "64";
            "number of phase steps, no more than those of a code period"
            "as for `first`";
        around: quantity(Distance, "0 m", "1500000 km"),
            Otherwise("none: the window is given with `first`"), "3.2 m";
            "distance (or time of flight, 0 s to 10 s) in the middle of the window"
            "as for `path.distance` and `path.delay`";
        halfwidth: integer(0, MOST_PHASE_STEPS / 2),
            Otherwise("none: the window is given with `first`"), "16";
            "phase steps on either side of the middle"
            "as for `first`";
    }

    ESTIMATE = "estimate" {
        estimator: choice(const { &names(&EstimatorKind::NAMES) }), Or("\"fft\""), "\"fft\"";
            "how counts become distances";
        other_light: choice(const { &names(&OtherLight::NAMES) }), Or("\"given\""), "\"given\"";
            "which light besides the strongest path the model estimator looks for";
    }

    HARDWARE = "hardware" {
        target: choice(const { &names(&Target::NAMES) }), Or("\"ecp5-25k-6\""), "\"ecp5-25k-6\"";
            "device that the hardware is built for";
        architecture: choice(const { &names(&Architecture::NAMES) }),
            Or("\"updown\""), "\"histogram\"";
            "whether hits are counted up and down, one phase step after another, or by \
             their time in the code period, for all phase steps at once";
        polarity: choice(const { &names(&Polarity::NAMES) }), Or("\"high\""), "\"low\"";
            "level of the samples while a detector's pulse lasts; a comparator that inverts \
             needs \"low\"";
        parallel: integer(1, 64), Or("1"), "8";
            "phase steps correlated at once, no more than the scan has"
            "what fits into the targets";
        counter_width: integer(2, 64), Otherwise("as wide as no stimulus can overflow"), "20";
            "bits of a count in the results, or of a histogram's bin"
            "a sign and a bit; the reference model's counts have 64 bits";
        total_counts: BOOLEAN, Otherwise("true with estimator \"model\", else false"), "true";
            "whether results carry the total count of a step beside the signed one";
        peak_detector: BOOLEAN, Or("false"), "true";
            "whether the hardware finds the largest count of a scan";
        buffers: integer(1, 2), Or("2"), "1";
            "histograms that each detector has memory for: with 2 one counts while the \
             other is read, as slowly as the receiver likes; with 1 a row leaves at each \
             clock of the next frame's first code period, and the receiver has to take it"
            "a third would wait for nothing";
    }
}
