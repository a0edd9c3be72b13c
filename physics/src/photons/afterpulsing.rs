//! Afterpulses: trapped carriers that fire the detector again.

use rand::RngExt;
use rand_distr::{Distribution, Exp1};

use super::random::StreamRng;
use super::time::ChipTime;

/// Afterpulsing of one detector.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Afterpulsing {
    /// Mean number of afterpulses per avalanche, -ln(1 - p): the number is
    /// Poisson, so that p is the chance of at least one.
    pub mean_per_avalanche: f64,
    /// Mean delay from the end of the dead time, in chips.
    pub time_constant_chips: f64,
}

impl Afterpulsing {
    /// `None` without afterpulsing.
    pub fn new(probability: f64, time_constant_chips: f64) -> Option<Afterpulsing> {
        (probability > 0.0).then(|| Afterpulsing {
            mean_per_avalanche: -(-probability).ln_1p(),
            time_constant_chips,
        })
    }
}

/// The afterpulses that are still to come.
#[derive(Debug, Clone)]
pub struct PendingAfterpulses {
    afterpulsing: Afterpulsing,
    none_probability: f64,
    rng: StreamRng,
    /// When they come.
    pub pending: Pending,
}

/// Times that are still to come.
#[derive(Debug, Clone)]
pub struct Pending {
    times: Vec<ChipTime>,
    /// The earliest of them.
    pub next: ChipTime,
}

impl Pending {
    /// Nothing to come.
    pub fn none() -> Pending {
        Pending { times: Vec::new(), next: ChipTime::NEVER }
    }

    /// One more.
    #[inline]
    pub fn add(&mut self, time: ChipTime) {
        self.times.push(time);
        if time < self.next {
            self.next = time;
        }
    }

    /// What comes until a time is gone.
    #[inline]
    pub fn lose(&mut self, until: ChipTime) {
        self.times.retain(|&time| time > until);
        self.next = self
            .times
            .iter()
            .copied()
            .fold(ChipTime::NEVER, |first, time| if time < first { time } else { first });
    }
}

impl PendingAfterpulses {
    /// No afterpulse pending.
    pub fn new(afterpulsing: Afterpulsing, rng: StreamRng) -> PendingAfterpulses {
        PendingAfterpulses {
            afterpulsing,
            none_probability: (-afterpulsing.mean_per_avalanche).exp(),
            rng,
            pending: Pending::none(),
        }
    }

    /// An avalanche whose dead time ends at `ready`: pending afterpulses up to
    /// then are lost (or are the avalanche itself), and new ones are trapped.
    #[inline]
    pub fn avalanche(&mut self, ready: ChipTime) {
        let new = self.draw_number();
        if new == 0 && self.pending.times.is_empty() {
            return;
        }
        self.pending.lose(ready);
        for _ in 0..new {
            let delay: f64 = Exp1.sample(&mut self.rng);
            self.pending.add(ready.after(delay * self.afterpulsing.time_constant_chips));
        }
    }

    /// A Poisson number by inversion; nearly always one comparison.
    #[inline]
    fn draw_number(&mut self) -> u32 {
        let uniform: f64 = self.rng.random();
        let mut number = 0;
        let mut term = self.none_probability;
        let mut cumulative = term;
        // The terms' rounded sum may stay below 1, hence the second condition.
        while uniform >= cumulative && term > 1e-18 {
            number += 1;
            term *= self.afterpulsing.mean_per_avalanche / f64::from(number);
            cumulative += term;
        }
        number
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::photons::random::{RandomStream, StreamKey};
    use crate::scan::Group;

    #[test]
    fn numbers_are_poisson() {
        let afterpulsing = Afterpulsing::new(0.6, 1.0).expect("there is afterpulsing");
        let key = StreamKey { seed: 3, detector: 0, group: Group(0), repetition: 0 };
        let mut pending =
            PendingAfterpulses::new(afterpulsing, key.stream(RandomStream::Afterpulsing));
        let draws = 200_000;
        let (mut none, mut sum, mut squares) = (0, 0.0, 0.0);
        for _ in 0..draws {
            let number = f64::from(pending.draw_number());
            none += u32::from(number == 0.0);
            sum += number;
            squares += number * number;
        }
        let n = f64::from(draws);
        let mean = -(0.4_f64.ln());
        assert!((f64::from(none) / n - 0.4).abs() < 5.0 * (0.24 / n).sqrt());
        assert!((sum / n - mean).abs() < 5.0 * (mean / n).sqrt());
        // Variance of a Poisson sample variance: (mu + 2 mu^2) / n.
        let variance = squares / n - (sum / n).powi(2);
        assert!((variance - mean).abs() < 5.0 * ((mean + 2.0 * mean * mean) / n).sqrt());
    }
}
