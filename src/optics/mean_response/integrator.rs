//! y' = -rate y + g(t) over one cell, exactly for a parabola g.

use super::chain::{Chain, STATES};

/// The propagators of every state, for each cell and brightness that has come
/// up: a code has few brightnesses, but many chips.
#[derive(Debug, Clone)]
pub struct Propagators {
    known: Vec<Vec<(f64, [Propagator; STATES])>>,
}

impl Propagators {
    pub fn new(cells: usize) -> Propagators {
        Propagators {
            known: vec![Vec::new(); cells],
        }
    }

    /// Propagators of cell `cell`, `width` wide, at primary rate `lambda`.
    pub fn get(
        &mut self,
        chain: &Chain,
        cell: usize,
        width: f64,
        lambda: f64,
    ) -> [Propagator; STATES] {
        let known = &mut self.known[cell];
        if let Some((_, propagators)) = known.iter().find(|(rate, _)| *rate == lambda) {
            return *propagators;
        }
        let propagators =
            std::array::from_fn(|m| Propagator::new(chain.exit_rate(lambda, m), width));
        known.push((lambda, propagators));
        propagators
    }
}

/// Weights of one cell for one decay rate: stable for any rate.
#[derive(Debug, Clone, Copy)]
pub struct Propagator {
    decay: f64,
    /// Weights of g at the cell's start, middle and end.
    weights: [f64; 3],
}

impl Propagator {
    pub fn new(rate: f64, width: f64) -> Propagator {
        let [phi_1, phi_2, phi_3] = phi(-rate * width);
        // g = g0 + b x + c x^2 with x in 0..1 through the three values; the
        // integral of exp(-rate (width - s)) x^k is width k! phi_(k+1).
        Propagator {
            decay: (-rate * width).exp(),
            weights: [
                width * (phi_1 - 3.0 * phi_2 + 4.0 * phi_3),
                width * (4.0 * phi_2 - 8.0 * phi_3),
                width * (4.0 * phi_3 - phi_2),
            ],
        }
    }

    /// y at the cell's end, from y at its start and g at start, middle, end.
    pub fn advance(&self, start: f64, g: [f64; 3]) -> f64 {
        let [a, b, c] = self.weights;
        self.decay * start + a * g[0] + b * g[1] + c * g[2]
    }
}

/// phi_k(z) = sum over n of z^n / (n + k)!, for k = 1, 2, 3.
fn phi(z: f64) -> [f64; 3] {
    if z.abs() < 1.0 {
        // The closed forms cancel near zero; the series needs few terms.
        let mut sums = [0.0; 3];
        for (k, sum) in sums.iter_mut().enumerate() {
            let mut term = [1.0, 0.5, 1.0 / 6.0][k];
            for n in 0..20 {
                *sum += term;
                term *= z / (n + k + 2) as f64;
            }
        }
        return sums;
    }
    let phi_1 = z.exp_m1() / z;
    let phi_2 = (phi_1 - 1.0) / z;
    [phi_1, phi_2, (phi_2 - 0.5) / z]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_parabola_is_integrated_exactly_at_any_rate() {
        // y = 1 + 2 t - 3 t^2 solves y' = -rate y + g.
        let y = |t: f64| 1.0 + 2.0 * t - 3.0 * t * t;
        for rate in [0.0, 1e-6, 0.5, 1.4, 3.0, 40.0, 1e4] {
            let width = 0.7;
            let g = [0.0, 0.35, 0.7].map(|t| 2.0 - 6.0 * t + rate * y(t));
            let found = Propagator::new(rate, width).advance(y(0.0), g);
            assert!((found - y(width)).abs() < 1e-11, "rate {rate}: {found}");
        }
    }
}
