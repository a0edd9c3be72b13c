//! A steady state, sooner than by waiting for it.
//!
//! A saturated detector fires like a clock, whose phase it forgets only after the square of (rate x
//! dead time) dead times. What is slow are few modes, though: as many as turn round within a dead
//! time before they fade. Reduced rank extrapolation (Sidi, "Efficient implementation of minimal
//! polynomial and reduced rank extrapolation methods", 1991) finds where they lead from as many
//! states, one round after another: the sum of the states with weights that add up to 1 whose
//! next one differs least from it.

/// States that are kept for an extrapolation.
const MOST_STATES: usize = 32;
/// Rounds without one before, in which what is quick fades.
const ROUNDS_BEFORE: usize = 4;
/// With fewer rounds to wait, waiting costs about as much.
const LEAST_ROUNDS: usize = 4 * MOST_STATES;
/// A state has come round if no number of it has changed by more than this share of the largest.
const CHANGE: f64 = 1e-13;
/// What a difference has in a direction of its own must be more than rounding.
const OWN_SHARE: f64 = 1e-11;

/// What goes on round by round: some independent columns of numbers, in each of which a round
/// makes of a state another that depends on it linearly, but for a constant.
pub trait Rounds {
    /// Goes on by a round.
    fn go_round(&mut self);
    /// The state of each column. Its first numbers are those that the others follow from.
    fn states(&self) -> Vec<Vec<f64>>;
    /// How many of a state's first numbers tell it from others.
    fn telling(&self) -> usize;
    /// How many of a state's first numbers may be more by the same number without any effect but that
    /// they stay so: rounding makes them drift, all alike, and never come round.
    fn drifting(&self) -> usize;
    /// Puts other states in place of its own.
    fn set(&mut self, states: &[Vec<f64>]);
}

/// How rounds of a detector in periodic light are made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Round {
    /// Chips of one: whole periods, and more than a state reaches.
    pub chips: usize,
    /// Rounds after which the steady state has been waited for.
    pub most: usize,
}

impl Round {
    /// Rounds of whole periods, and no fewer chips than `least_chips`, of a detector that is waited for
    /// `memory_chips`; none if that are so few rounds that waiting does as well. In `fading_chips` the
    /// slowest mode fades by e^7, and the mode k in a k^2th of that.
    pub fn new(
        fading_chips: f64,
        least_chips: usize,
        period_chips: usize,
        memory_chips: usize,
    ) -> Option<Round> {
        // k and -k of each mode need a state.
        let most_k = MOST_STATES as f64 / 2.0;
        let wanted = (fading_chips / (most_k * most_k)).ceil() as usize;
        let chips = wanted.max(least_chips).next_multiple_of(period_chips);
        let most = memory_chips.div_ceil(chips);
        (most > LEAST_ROUNDS).then_some(Round { chips, most })
    }

    /// Chips until the steady state, about: two extrapolations, and what shows that nothing changes.
    pub fn expected_chips(&self) -> usize {
        2 * (ROUNDS_BEFORE + MOST_STATES + 1) * self.chips
    }
}

/// Goes on until the states of all columns come round, or have been waited for. They are then where
/// they would be without any drift.
pub fn settle(rounds: &mut impl Rounds, most: usize) {
    // Before the first one there is no state yet.
    rounds.go_round();
    let drifting = rounds.drifting();
    let telling = rounds.telling();
    let mut before = rounds.states();
    let mut columns: Vec<Column> = before.iter().map(|_| Column::new(drifting)).collect();
    for left in (0..most.saturating_sub(1)).rev() {
        rounds.go_round();
        let after = rounds.states();
        let changes = columns.iter_mut().zip(before.into_iter().zip(&after));
        let largest_share = changes
            .map(|(column, (before, after))| column.go_on(before, after, telling))
            .fold(0.0, f64::max);
        before = after;
        if largest_share <= CHANGE || left == 0 {
            break;
        }
        if columns.iter().all(|column| column.is_full || column.states.len() == MOST_STATES) {
            columns
                .iter_mut()
                .zip(&mut before)
                .for_each(|(column, state)| column.extrapolate(state));
            rounds.set(&before);
        }
    }
    columns.iter().zip(&mut before).for_each(|(column, state)| column.take_drift(state));
    rounds.set(&before);
}

fn largest(numbers: impl Iterator<Item = f64>) -> f64 {
    numbers.fold(0.0, |largest, number| largest.max(number.abs()))
}

/// States of one column, and what each round changed beside the drift: Q R, by Gram and Schmidt.
struct Column {
    drifting: usize,
    /// How much a round drifts, and how many rounds the state has.
    drift: f64,
    drifted_rounds: f64,
    /// Rounds since the last extrapolation.
    rounds: usize,
    states: Vec<Vec<f64>>,
    /// Rounds that each of these has drifted.
    drifted: Vec<f64>,
    directions: Vec<Vec<f64>>,
    /// R, column by column.
    shares: Vec<Vec<f64>>,
    /// Whether the last change is nothing but what others before it make up.
    is_full: bool,
}

impl Column {
    fn new(drifting: usize) -> Column {
        Column {
            drifting,
            drift: 0.0,
            drifted_rounds: 1.0,
            rounds: 0,
            states: Vec::new(),
            drifted: Vec::new(),
            directions: Vec::new(),
            shares: Vec::new(),
            is_full: false,
        }
    }

    /// Takes note of a state, and of the one that a round has made of it; gives the largest change, as a
    /// share of the largest number.
    fn go_on(&mut self, before: Vec<f64>, after: &[f64], telling: usize) -> f64 {
        let mut change: Vec<f64> = after.iter().zip(&before).map(|(a, b)| a - b).collect();
        let (drifting, _) = change.split_at_mut(self.drifting);
        self.drift = drifting.iter().sum::<f64>() / drifting.len().max(1) as f64;
        drifting.iter_mut().for_each(|change| *change -= self.drift);
        let [most, scale] = [&change, after].map(|numbers| largest(numbers.iter().copied()));
        self.rounds += 1;
        if self.rounds > ROUNDS_BEFORE && !self.is_full && self.states.len() < MOST_STATES {
            change.truncate(telling);
            self.add(before, change);
        }
        self.drifted_rounds += 1.0;
        if scale > 0.0 { most / scale } else { 0.0 }
    }

    fn add(&mut self, state: Vec<f64>, mut change: Vec<f64>) {
        let length = dot(&change, &change).sqrt();
        let mut shares = vec![0.0; self.directions.len()];
        // Twice is enough.
        for _ in 0..2 {
            for (direction, share) in self.directions.iter().zip(&mut shares) {
                let along = dot(direction, &change);
                *share += along;
                change.iter_mut().zip(direction).for_each(|(change, own)| *change -= along * own);
            }
        }
        let own = dot(&change, &change).sqrt();
        self.is_full = own <= OWN_SHARE * length;
        if self.is_full {
            return;
        }
        change.iter_mut().for_each(|change| *change /= own);
        shares.push(own);
        self.states.push(state);
        self.drifted.push(self.drifted_rounds);
        self.directions.push(change);
        self.shares.push(shares);
    }

    /// Makes of a state the one that a round is expected to change least, and begins anew.
    fn extrapolate(&mut self, state: &mut [f64]) {
        let number = self.states.len();
        if number > 0 {
            // R^T R w = (1, ..., 1), and w divided by its sum.
            let mut weights = vec![1.0; number];
            for row in 0..number {
                let known: f64 = (0..row).map(|of| self.shares[row][of] * weights[of]).sum();
                weights[row] = (weights[row] - known) / self.shares[row][row];
            }
            for row in (0..number).rev() {
                let of_row = |of: usize| self.shares[of][row];
                let known: f64 = (row + 1..number).map(|of| of_row(of) * weights[of]).sum();
                weights[row] = (weights[row] - known) / self.shares[row][row];
            }
            let all: f64 = weights.iter().sum();
            weights.iter_mut().for_each(|weight| *weight /= all);
            state.fill(0.0);
            for (weight, of) in weights.iter().zip(&self.states) {
                state.iter_mut().zip(of).for_each(|(state, of)| *state += weight * of);
            }
            self.drifted_rounds = dot(&weights, &self.drifted);
        }
        let (drift, drifted_rounds) = (self.drift, self.drifted_rounds);
        *self = Column { drift, drifted_rounds, ..Column::new(self.drifting) };
    }

    /// Takes off what a state has drifted.
    fn take_drift(&self, state: &mut [f64]) {
        let drifted = self.drift * self.drifted_rounds;
        state[..self.drifting].iter_mut().for_each(|number| *number -= drifted);
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers that turn and fade, each pair at its own pace, about others that are to be found; all of them
    /// beside a first one, which drifts.
    struct Turning {
        state: Vec<f64>,
        rest: Vec<f64>,
        drift: f64,
        rounds: usize,
    }

    impl Turning {
        fn new(pairs: u32, drift: f64) -> Turning {
            let rest: Vec<f64> = (0..2 * pairs).map(|n| f64::from(n * 7 % 11) - 5.0).collect();
            Turning { state: vec![0.0; rest.len() + 1], rest, drift, rounds: 0 }
        }

        /// How far it is off.
        fn off(&self) -> f64 {
            let expected = [0.0].into_iter().chain(self.rest.iter().copied());
            largest(self.state.iter().zip(expected).map(|(state, rest)| state - rest))
        }
    }

    impl Rounds for Turning {
        fn go_round(&mut self) {
            self.rounds += 1;
            let first = self.state[0];
            self.state[0] += self.drift;
            let pairs = self.state[1..].chunks_exact_mut(2).zip(self.rest.chunks_exact(2));
            for (number, (state, rest)) in (1..).zip(pairs) {
                let fades = (-f64::from(number * number) / 400.0).exp();
                let turns = 2.0 * f64::from(number);
                let [x, y] = [0, 1].map(|of| state[of] - first - rest[of]);
                let first = first + self.drift;
                state[0] = first + rest[0] + fades * (turns.cos() * x - turns.sin() * y);
                state[1] = first + rest[1] + fades * (turns.sin() * x + turns.cos() * y);
            }
        }

        fn states(&self) -> Vec<Vec<f64>> {
            vec![self.state.clone()]
        }

        fn telling(&self) -> usize {
            self.state.len()
        }

        fn drifting(&self) -> usize {
            self.state.len()
        }

        fn set(&mut self, states: &[Vec<f64>]) {
            self.state.clone_from(&states[0]);
        }
    }

    /// Of a hundred modes of which the slowest fades by e in 400 rounds; waiting takes 11,000.
    #[test]
    fn few_rounds_lead_to_rest_whatever_drifts() {
        for drift in [0.0, 1e-6, 0.1] {
            let mut turning = Turning::new(100, drift);
            settle(&mut turning, 11_000);
            assert!(turning.off() < 1e-9 + 1e-7 * drift, "{drift}: {:e}", turning.off());
            assert!(turning.rounds < 500, "{drift}: {}", turning.rounds);
        }
    }

    #[test]
    fn what_does_not_come_round_is_waited_for() {
        let mut turning = Turning::new(100, 0.0);
        settle(&mut turning, 20);
        assert!(turning.rounds == 20 && turning.off() > 1e-3, "{}", turning.off());
        let mut resting = Turning { state: vec![0.0], ..Turning::new(0, 0.0) };
        settle(&mut resting, 50);
        assert_eq!((resting.rounds, resting.state), (2, vec![0.0]));
    }
}
