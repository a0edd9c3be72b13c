//! Sequential tests (Wald, Sequential Analysis, 1947): draws that go on until a claim, or a fault that
//! it would hide, is as good as proven. What holds is decided in a fraction of the draws that a test of
//! as many as the worst case needs would take, with the same chance to miss the fault.
//!
//! Seeds are fixed, so that a test draws the same numbers in every run.

use crate::repeated;

/// Chance that what is sound is taken for faulty.
const FALSE_ALARM: f64 = 1e-4;
/// So many times seldomer a release misses a fault.
const OF_A_RELEASE: u64 = 1_000;
/// By then each test has ended, or its claims are both wrong.
const MOST_DRAWS: u64 = 20_000;

/// Where a logarithm of the likelihood of a fault over that of the claim ends a test: the fault is
/// ruled out, or it is there.
fn limits(miss: f64) -> [f64; 2] {
    let miss = miss / repeated(1, OF_A_RELEASE) as f64;
    [(miss / (1.0 - FALSE_ALARM)).ln(), ((1.0 - miss) / FALSE_ALARM).ln()]
}

/// Something that happens in a share of the draws at most.
pub struct Seldom {
    shares: [f64; 2],
    limits: [f64; 2],
    draws: u64,
    happened: u64,
}

impl Seldom {
    /// In the share `sound`, against the share `faulty`, which is missed with the probability `miss`.
    pub fn new(sound: f64, faulty: f64, miss: f64) -> Seldom {
        assert!(sound < faulty);
        Seldom { shares: [sound, faulty], limits: limits(miss), draws: 0, happened: 0 }
    }

    pub fn take(&mut self, happens: bool) {
        self.draws += 1;
        self.happened += u64::from(happens);
    }

    /// Logarithm of the likelihood ratio.
    fn evidence(&self) -> f64 {
        let [sound, faulty] = self.shares;
        let others = (self.draws - self.happened) as f64;
        self.happened as f64 * (faulty / sound).ln()
            + others * ((1.0 - faulty) / (1.0 - sound)).ln()
    }

    /// Whether there is more to draw.
    pub fn is_open(&self) -> bool {
        let [sound, faulty] = self.limits;
        self.draws < MOST_DRAWS && (sound..faulty).contains(&self.evidence())
    }

    /// Whether the fault is ruled out.
    pub fn holds(&self) -> bool {
        self.evidence() < self.limits[0]
    }

    #[track_caller]
    pub fn assert_holds(&self, what: &str) {
        let told = format!("{what}: {} of {}", self.happened, self.draws);
        println!("{told}");
        assert!(self.holds(), "{told}");
    }
}

/// Errors in units of their expected standard deviation: around 0, and by 1.
pub struct Scatter {
    /// Means and standard deviations that errors may have instead.
    faults: [[f64; 2]; 4],
    limits: [f64; 2],
    draws: f64,
    sum: f64,
    squares: f64,
}

impl Scatter {
    /// Against a scatter `factor` times as large or as small, and a mean that is `bias` away; each is
    /// missed with the probability `miss`.
    pub fn new(factor: f64, bias: f64, miss: f64) -> Scatter {
        let faults = [[0.0, factor], [0.0, 1.0 / factor], [bias, 1.0], [-bias, 1.0]];
        Scatter { faults, limits: limits(miss), draws: 0.0, sum: 0.0, squares: 0.0 }
    }

    pub fn take(&mut self, error: f64) {
        self.draws += 1.0;
        self.sum += error;
        self.squares += error * error;
    }

    /// Logarithms of the likelihood ratios.
    fn evidence(&self) -> [f64; 4] {
        self.faults.map(|[mean, std]| {
            let squares = self.squares - 2.0 * mean * self.sum + self.draws * mean * mean;
            0.5 * (self.squares - squares / (std * std)) - self.draws * std.ln()
        })
    }

    /// Whether every fault is ruled out.
    pub fn holds(&self) -> bool {
        self.evidence().into_iter().all(|evidence| evidence < self.limits[0])
    }

    /// Whether there is more to draw.
    pub fn is_open(&self) -> bool {
        let is_faulty = self.evidence().into_iter().any(|evidence| evidence > self.limits[1]);
        self.draws < MOST_DRAWS as f64 && !self.holds() && !is_faulty
    }

    #[track_caller]
    pub fn assert_holds(&self, what: &str) {
        let mean = self.sum / self.draws;
        let std = (self.squares / self.draws).sqrt();
        let told = format!("{what}: {mean:.3} and {std:.3} of {} errors", self.draws);
        println!("{told}");
        assert!(self.holds(), "{told}");
    }
}
