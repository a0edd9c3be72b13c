//! Table `[hardware]`.

use super::declare::*;
use super::{EstimatorKind, Scan, Scene, TotalsMissing};

tables! {
    /// Target and options of the hardware. Without `counter_width` counts are as wide as no stimulus
    /// can overflow; a narrower count saturates and flags. Without `total_counts` the estimator decides:
    /// [`Scene::sends_total_counts`](super::Scene::sends_total_counts).
    #[derive(Debug, Clone, PartialEq)]
    pub struct Hardware {}
    of HARDWARE = "hardware" {
        target => target: FpgaTarget = choice(FpgaTarget::CHOICES), Or("\"ecp5-25k-6\""), "\"ecp5-25k-6\"";
            "device that the hardware is built for";
        architecture => architecture: Architecture = choice(Architecture::CHOICES),
            Or("\"updown\""), "\"histogram\"";
            "whether hits are counted up and down, one phase step after another, or by \
             their time in the code period, for all phase steps at once";
        polarity => polarity: Polarity = choice(Polarity::CHOICES), Or("\"high\""), "\"low\"";
            "level of the samples while a detector's pulse lasts; a comparator that inverts \
             needs \"low\"";
        parallel => parallel: u32 = integer(1, 64), Or("1"), "8";
            "phase steps correlated at once, no more than the scan has"
            "what fits into the targets";
        counter_width => counter_width: Option<u32> = integer(2, 64), Otherwise("as wide as no stimulus can overflow"), "20";
            "bits of a count in the results, or of a histogram's bin"
            "a sign and a bit; the reference model's counts have 64 bits";
        total_counts => total_counts: Option<bool> = BOOLEAN, Otherwise("true with estimator \"model\", else false"), "true";
            "whether results carry the total count of a step beside the signed one";
        peak_detector => peak_detector: bool = BOOLEAN, Or("false"), "true";
            "whether the hardware finds the largest count of a scan";
        readout => readout: Readout = choice(Readout::CHOICES), Or("\"queue\""), "\"rows\"";
            "whether each detector has a whole counter and a place in a queue of results, or \
             counts little by little into one memory, as the pixels of an array do";
        accumulate => accumulate: u32 = integer(1, 255), Or("1"), "4";
            "scans whose counts a board adds up before they go to its serial line; estimates are \
             of the sums"
            "a byte of the line's protocol";
        scene_text => scene_text: bool = BOOLEAN, Or("false"), "true";
            "whether a board holds the scene's text, for a host to read by its serial line";
        sample_counts => sample_counts: bool = BOOLEAN, Or("false"), "true";
            "whether a board counts hits by sample of the chip, of which a host calibrates the sampler";
        registers => registers: Registers = choice(Registers::CHOICES), Or("\"none\""), "\"axi4-lite\"";
            "registers by which a host starts and stops scans, and sets first step, number of \
             steps, integration and code, with no new build";
        code_taps => code_taps: bool = BOOLEAN, Or("false"), "true";
            "whether a host sets codes' taps with their seeds: of Gold codes' second LFSRs, and of m-sequences";
        track => track: bool = BOOLEAN, Or("false"), "true";
            "whether the hardware, once a scan has found a target, follows it with a window of two chips";
        track_gain => track_gain: Share = choice(Share::CHOICES), Or("\"1/4\""), "\"1/2\"";
            "share of its distance from the peak by which the window moves each time; a host sets others";
        track_threshold => track_threshold: Share = choice(Share::CHOICES), Or("\"1/2\""), "\"1/4\"";
            "share of the followed light below which a window has lost it; a host sets others";
        track_patience => track_patience: u32 = integer(1, 15), Or("4"), "1";
            "windows without the light, one after another, after which a whole scan looks for the target; a \
             host sets others"
            "four bits of a register";
        buffers => buffers: u32 = integer(1, 2), Or("2"), "1";
            "histograms that each detector has memory for: with 2 one counts while the \
             other is read, as slowly as the receiver likes; with 1 a row leaves at each \
             clock of the next frame's first code period, and the receiver has to take it"
            "a third would wait for nothing";
    }
}

/// Chips of the shortest phase step that is read out by rows.
pub const LEAST_CHIPS_OF_ROWS: u64 = 8;

choices! {
    /// What the hardware counts.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
    pub enum Architecture {
        /// Hits up and down by the sign of the delayed reference (eq. 11), one phase step,
        /// or `parallel` of them, after another.
        #[default]
        UpDown = "updown",
        /// Hits by their time in the code period, a bin for each sample of it. Every phase
        /// step's up/down count follows from the same hits, so that a scan is as long as its
        /// integration time.
        Histogram = "histogram",
    }
}

choices! {
    /// Where detectors keep their counts.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
    pub enum Readout {
        /// Each has a counter for a whole step, and a register in the queue of results.
        #[default]
        Queue = "queue",
        /// Each has a counter for a part of a step, which is shifted to one adder and memory that
        /// all share.
        Rows = "rows",
    }
}

choices! {
    /// How a host reaches the hardware's settings.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
    pub enum Registers {
        /// Not at all: the scan is that of the scene.
        #[default]
        None = "none",
        /// By an AXI4-Lite slave (ARM IHI 0022, chapter B1) of 32 bits.
        Axi4Lite = "axi4-lite",
    }
}

choices! {
    /// A share that hardware takes by shifts.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum Share {
        /// All of it.
        Whole = "1",
        /// Half of it, and so on.
        Half = "1/2",
        /// A quarter.
        Quarter = "1/4",
        /// An eighth.
        Eighth = "1/8",
        /// A sixteenth.
        Sixteenth = "1/16",
        /// A 32nd.
        Part32 = "1/32",
        /// A 64th.
        Part64 = "1/64",
        /// A 128th.
        Part128 = "1/128",
    }
}

impl Share {
    /// How often it is halved.
    pub fn halvings(self) -> u32 {
        self as u32
    }
}

choices! {
    /// Level of a detector's samples while its pulse lasts.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
    pub enum Polarity {
        /// A hit is a rising edge.
        #[default]
        High = "high",
        /// A hit is a falling edge, as from a comparator that inverts.
        Low = "low",
    }
}

impl Polarity {
    /// A word of so many samples, at most 64, without a pulse.
    pub fn rest(self, samples: u32) -> u64 {
        match self {
            Polarity::High => 0,
            Polarity::Low => u64::MAX >> (u64::BITS - samples),
        }
    }
}

choices! {
    /// FPGA targets.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum FpgaTarget {
        /// Lattice ECP5 25k, speed grade 6.
        Ecp525k6 = "ecp5-25k-6",
        /// Lattice iCE40 HX8K.
        Ice40Hx8k = "ice40-hx8k",
        /// AMD 7-series (synthesis only).
        Xc7 = "xc7",
    }
}

pub(super) fn read(
    root: &Section,
    scan: Option<&Scan>,
    estimator: Option<EstimatorKind>,
    detectors: usize,
) -> Option<Hardware> {
    let section = root.section_or_defaults("hardware");
    let hardware = Hardware::keys(&section);
    if let Some(hardware) = &hardware {
        check(&section, hardware, scan, estimator);
        check_readout(&section, hardware, scan, estimator, detectors);
    }
    section.finish();
    hardware
}

/// Reports keys that contradict the scan, the estimator, or the architecture.
fn check(
    section: &Section,
    hardware: &Hardware,
    scan: Option<&Scan>,
    estimator: Option<EstimatorKind>,
) {
    let parallel = hardware.parallel;
    if let Some(scan) = scan.filter(|scan| scan.steps < u64::from(parallel)) {
        let message = format!(
            "{parallel} phase steps at once are more than the {} of the scan; \
             use {} or less, or scan more steps",
            scan.steps, scan.steps
        );
        section.report("parallel", &message);
    }
    if hardware.total_counts == Some(false) && estimator == Some(EstimatorKind::Model) {
        section.report("total_counts", &TotalsMissing.to_string());
    }
    match hardware.architecture {
        Architecture::UpDown if section.get("buffers").is_some() => {
            let message = "up/down counts have no memories; leave out this key, or write \
                           architecture = \"histogram\"";
            section.report("buffers", message);
        }
        Architecture::UpDown => check_registers(section, hardware, scan),
        Architecture::Histogram => check_histogram(section, scan, parallel),
    }
}

/// A host counts in groups of steps.
fn check_registers(section: &Section, hardware: &Hardware, scan: Option<&Scan>) {
    let parallel = u64::from(hardware.parallel);
    let Some(scan) = scan.filter(|_| hardware.registers != Registers::None) else {
        return;
    };
    if !scan.steps.is_multiple_of(parallel) {
        let message = format!(
            "a host sets the scan's length in groups of {parallel} steps at once, and {} steps end \
             within a group; scan {} or {} steps, or leave out the registers",
            scan.steps,
            scan.steps - scan.steps % parallel,
            scan.steps.next_multiple_of(parallel)
        );
        section.report("registers", &message);
    }
}

/// What is read out by rows is one signed count of each detector.
fn check_readout(
    section: &Section,
    hardware: &Hardware,
    scan: Option<&Scan>,
    estimator: Option<EstimatorKind>,
    detectors: usize,
) {
    if hardware.readout == Readout::Queue {
        return;
    }
    let sends_totals = hardware.total_counts == Some(true)
        || (hardware.total_counts.is_none() && estimator == Some(EstimatorKind::Model));
    let reports = [
        (hardware.architecture == Architecture::Histogram, "signed counts; leave out architecture"),
        (detectors < 2, "several detectors; leave out this key"),
        (hardware.parallel > 1, "one phase step at a time; leave out parallel"),
        (
            sends_totals,
            "signed counts alone, without totals; leave out total_counts, and take estimator = \
             \"fft\"",
        ),
        (hardware.peak_detector, "one count after another to the host; leave out peak_detector"),
        (hardware.counter_width.is_some(), "exact counts; leave out counter_width"),
        (hardware.accumulate > 1, "scans that are sent as they are; leave out accumulate"),
        (
            hardware.registers != Registers::None,
            "steps of a length that is built in; leave out registers",
        ),
    ];
    for (is_asked, why) in reports {
        if is_asked {
            section.report("readout", &format!("a read-out by rows has {why}"));
        }
    }
    let least = (detectors as u64).max(LEAST_CHIPS_OF_ROWS);
    if let Some(scan) = scan.filter(|scan| scan.integration_chips < least) {
        let message = format!(
            "a read-out by rows of {detectors} detectors needs phase steps of at least {least} chips, \
             and these have {}; integrate for longer, or leave out this key",
            scan.integration_chips
        );
        section.report("readout", &message);
    }
}

/// Reports what a scene lacks whose codes' taps a host is to set.
pub(super) fn check_taps(section: &Section, scene: &Scene) {
    if !scene.hardware.code_taps {
        return;
    }
    if scene.hardware.registers == Registers::None {
        let message = "a host sets taps by registers; write registers = \"axi4-lite\", too, or leave out this key";
        section.report("code_taps", message);
    }
    if scene.sources.iter().all(|source| source.code.generator.last_lfsr().is_none()) {
        section.report("code_taps", "no source's code comes from an LFSR; leave out this key");
    }
}

/// Reports what a scene lacks whose hardware is to follow a target.
pub(super) fn check_tracking(section: &Section, scene: &Scene) {
    let hardware = &scene.hardware;
    if !hardware.track {
        for key in ["track_gain", "track_threshold", "track_patience"] {
            if section.get(key).is_some() {
                section.report(
                    key,
                    "no target is followed; write track = true, or leave out this key",
                );
            }
        }
        return;
    }
    if hardware.architecture == Architecture::Histogram {
        // Told with all that a histogram has no use for.
        return;
    }
    let complain = |message: &str| section.report("track", message);
    let (window, scan) = (2 * u64::from(scene.samples_per_chip), scene.timing().scan);
    if window > scan.steps_per_period {
        complain(&format!(
            "the window of two chips has {window} phase steps, and the code period {}; use a longer code",
            scan.steps_per_period
        ));
    }
    if hardware.registers == Registers::None {
        complain("a host turns it on and off; write registers = \"axi4-lite\"");
    }
    if !hardware.peak_detector {
        complain("the window begins at a scan's peak; write peak_detector = true");
    }
    if hardware.parallel > 1 {
        complain("a window moves by single phase steps; leave out `parallel`");
    }
    if hardware.readout == Readout::Rows {
        complain(
            "rows are for many detectors, and a window follows what one sees; leave out `readout`",
        );
    }
    if scene.detectors.iter().any(|detector| detector.cells > 1) {
        complain("what a window is expected to see is known of single SPADs; leave out `cells`");
    }
    if scene.detectors.len() > 1 {
        complain(&format!(
            "a window follows what one detector sees, and the scene has {}; emit a sensor for each",
            scene.detectors.len()
        ));
    }
}

/// A histogram has every phase step and every hit: nothing chooses among them.
fn check_histogram(section: &Section, scan: Option<&Scan>, parallel: u32) {
    for (key, why) in [
        ("parallel", "a histogram serves all phase steps at once; leave out this key"),
        (
            "total_counts",
            "a histogram holds every hit, so that its sum is the total; leave out this key",
        ),
        (
            "peak_detector",
            "all counts of a histogram follow from it by a correlation on the host, and so does \
             their peak; leave out this key",
        ),
        (
            "accumulate",
            "a histogram adds up code periods; integrate for longer, and leave out this key",
        ),
        (
            "track",
            "a histogram has every phase step at once, and follows any target; leave out this key",
        ),
        (
            "registers",
            "a histogram has every phase step whatever the target, and registers set which steps are \
             counted; leave out this key",
        ),
    ] {
        // One at a time is what a scene has that says nothing.
        let is_one = key == "parallel" && parallel == 1;
        if section.get(key).is_some() && !is_one {
            section.report(key, why);
        }
    }
    let Some(scan) = scan else {
        return;
    };
    if !scan.is_full() || scan.first_step != 0 {
        section.report(
            "architecture",
            "a histogram has all phase steps of the code period, and the scan asks for some of \
             them; write scan.steps = \"all\", or count up and down (\"updown\")",
        );
    }
}

impl Scene {
    /// Whether the hardware sends total counts beside the signed ones: as
    /// `hardware.total_counts` says, else with the estimator that needs them. A
    /// histogram always does: its sum is the total.
    pub fn sends_total_counts(&self) -> bool {
        let needed = self.estimator == EstimatorKind::Model
            || self.hardware.architecture == Architecture::Histogram;
        self.hardware.total_counts.unwrap_or(needed)
    }

    /// The scene with another estimator, and with the hardware that it needs, as
    /// far as the scene leaves that open; unchanged for `None`.
    ///
    /// # Errors
    /// When the scene's hardware leaves out what the estimator needs.
    pub fn with_estimator(
        mut self,
        estimator: Option<EstimatorKind>,
    ) -> Result<Self, TotalsMissing> {
        self.estimator = estimator.unwrap_or(self.estimator);
        if self.estimator == EstimatorKind::Model && !self.sends_total_counts() {
            return Err(TotalsMissing);
        }
        Ok(self)
    }

    /// The scene with another estimator on the hardware that it has: what is sent
    /// stays as it is.
    pub fn estimated_by(&self, estimator: EstimatorKind) -> Scene {
        let mut scene = self.clone();
        scene.hardware.total_counts = Some(self.sends_total_counts());
        scene.estimator = estimator;
        scene
    }
}
