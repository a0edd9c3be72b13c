//! y' = -rate y + g(t) over one cell, exactly for a parabola g.

// States are looped over by number: iterators are not always inlined.
#![allow(clippy::needless_range_loop)]

use super::chain::{Chain, State};
use super::several::Number;

/// What one cell does to the states at one brightness.
#[derive(Debug, Clone)]
pub struct CellStep<const M: usize> {
    lambda: f64,
    decay: State<M>,
    /// Weights of g at the cell's start, middle and end.
    weights: [State<M>; 3],
    /// Rate at which each ready state is left.
    pub exit: State<M>,
    /// Rates from a ready state to the state after the dead time.
    passage: [State<M>; M],
    /// The same with rows and columns exchanged, so that either direction adds up
    /// whole rows.
    passage_to: [State<M>; M],
}

impl<const M: usize> CellStep<M> {
    fn new(chain: &Chain<M>, width: f64, lambda: f64) -> CellStep<M> {
        let mut step = CellStep {
            lambda,
            decay: [0.0; M],
            weights: [[0.0; M]; 3],
            exit: [0.0; M],
            passage: chain.passage_rates(lambda),
            passage_to: [[0.0; M]; M],
        };
        step.passage_to = std::array::from_fn(|m| std::array::from_fn(|i| step.passage[i][m]));
        for m in 0..M {
            let rate = chain.exit_rate(lambda, m);
            let [phi_1, phi_2, phi_3] = phi(-rate * width);
            // g = g0 + b x + c x^2 with x in 0..1 through the three values; the
            // integral of exp(-rate (width - s)) x^k is width k! phi_(k+1).
            step.decay[m] = (-rate * width).exp();
            step.weights[0][m] = width * (phi_1 - 3.0 * phi_2 + 4.0 * phi_3);
            step.weights[1][m] = width * (4.0 * phi_2 - 8.0 * phi_3);
            step.weights[2][m] = width * (4.0 * phi_3 - phi_2);
            step.exit[m] = rate;
        }
        step
    }

    /// y at the cell's end, from y at its start and g at start, middle, end.
    #[inline(always)]
    pub fn advance<V: Number>(&self, start: &[V; M], g: &[[V; M]; 3]) -> [V; M] {
        let [a, b, c] = &self.weights;
        let mut end = [V::default(); M];
        for m in 0..M {
            end[m] = start[m] * self.decay[m] + g[0][m] * a[m] + g[1][m] * b[m] + g[2][m] * c[m];
        }
        end
    }

    /// y' at a place where y and g are known.
    #[inline(always)]
    pub fn slope<V: Number>(&self, y: &[V; M], g: &[V; M]) -> [V; M] {
        let mut slope = *g;
        for m in 0..M {
            slope[m] -= y[m] * self.exit[m];
        }
        slope
    }

    /// Rates at which avalanches out of `ready` lead into each state.
    #[inline(always)]
    pub fn pass_forwards(&self, ready: &State<M>) -> State<M> {
        let mut into = [0.0; M];
        for from in 0..M {
            for m in 0..M {
                into[m] += ready[from] * self.passage[from][m];
            }
        }
        into
    }

    /// For each ready state, rate of leaving it times the value found after the
    /// dead time.
    #[inline(always)]
    pub fn pass_backwards<V: Number>(&self, later: &[V; M]) -> [V; M] {
        let mut value = [V::default(); M];
        for to in 0..M {
            for i in 0..M {
                value[i] += later[to] * self.passage_to[to][i];
            }
        }
        value
    }
}

/// The steps of every cell at every brightness that has come up: a code has few
/// brightnesses, but many chips.
#[derive(Debug, Clone)]
pub struct CellSteps<'c, const M: usize> {
    chain: &'c Chain<M>,
    known: Vec<Vec<CellStep<M>>>,
}

impl<'c, const M: usize> CellSteps<'c, M> {
    pub fn new(chain: &'c Chain<M>, cells: usize) -> CellSteps<'c, M> {
        CellSteps { chain, known: vec![Vec::new(); cells] }
    }

    /// The step of cell `cell`, `width` wide, at primary rate `lambda`.
    #[inline(always)]
    pub fn get(&mut self, cell: usize, width: f64, lambda: f64) -> &CellStep<M> {
        let known = &self.known[cell];
        let mut place = 0;
        while place < known.len() && known[place].lambda != lambda {
            place += 1;
        }
        if place == known.len() {
            self.add(cell, width, lambda);
        }
        &self.known[cell][place]
    }

    #[cold]
    fn add(&mut self, cell: usize, width: f64, lambda: f64) {
        self.known[cell].push(CellStep::new(self.chain, width, lambda));
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
        let chain = Chain::<1>::new(None, 1.0);
        for rate in [0.0, 1e-6, 0.5, 1.4, 3.0, 40.0, 1e4] {
            let width = 0.7;
            let g = [0.0, 0.35, 0.7].map(|t| [2.0 - 6.0 * t + rate * y(t)]);
            let [found] = CellStep::new(&chain, width, rate).advance(&[y(0.0)], &g);
            assert!((found - y(width)).abs() < 1e-11, "rate {rate}: {found}");
        }
    }
}
