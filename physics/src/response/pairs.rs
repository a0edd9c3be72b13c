//! Pairs of detections of one detector in one light.

use super::chain::{Chain, states_needed};
use super::forward::{self, AllAndMerged, Detections, ReadyStates};
use super::grid::{Grid, Kinks, SampleInstants};
use super::heard::Heard;
use super::light::Light;
use super::poisson::{self, Waiting};
use super::span::{PairReach, Span};
use super::variance::Backwards;
use super::{MAX_STATES, MeanResponseError, paralyzable, variance, with_states};
use crate::photons::DetectorModel;

/// What the detections of one code period know of later ones.
pub struct DetectorPairs {
    pub grid: Grid,
    detections: Detections,
    states: Box<dyn States>,
    /// Expected detections in every cell of the code period, less those that merge
    /// with the one before.
    pub hits: Vec<f64>,
    /// [`DetectorPairs::excess`] of all detections that count.
    pub excess_of_all: Vec<f64>,
    samples: SampleInstants,
    /// Share of each cell of a chip in which a pulse is seen by a sample.
    pub seen: Vec<f64>,
}

/// The detector's states, whatever their number.
trait States: Send + Sync {
    fn excess(&self, grid: &Grid, of: &Detections, signs: &[&[f64]], span: &Span) -> Vec<Vec<f64>>;
}

struct Solved<const M: usize> {
    chain: Chain<M>,
    ready: ReadyStates<M>,
}

impl DetectorPairs {
    pub fn new(
        model: &DetectorModel,
        light: &Light,
        heard: Option<&Heard>,
        samples: SampleInstants,
    ) -> Result<DetectorPairs, MeanResponseError> {
        let grid = Grid::new(model, light, Kinks::LaterAndEarlier, &samples)?;
        let grid = Heard::at(heard, grid, samples.origin_chips - model.delay_chips);
        let (detections, states) = solve(model, &grid)?;
        let detections = detections.counted();
        let cumulative = &detections.cumulative;
        let hits: Vec<f64> = cumulative.windows(2).map(|c| c[1] - c[0]).collect();
        let mut pairs = DetectorPairs {
            grid,
            detections,
            states,
            excess_of_all: Vec::new(),
            hits,
            samples,
            seen: Vec::new(),
        };
        [pairs.seen, _] = pairs.shares_after(f64::NEG_INFINITY);
        let seen: Vec<f64> = pairs.seen_of_period().collect();
        pairs.excess_of_all = pairs.excess(&[&seen]).swap_remove(0);
        Ok(pairs)
    }

    /// For every cell: expected detections there, times what each goes with of later ones,
    /// weighted with each of `signs`, beyond their plain expectation.
    pub fn excess(&self, signs: &[&[f64]]) -> Vec<Vec<f64>> {
        let span = Span::of_period(&self.grid);
        self.states.excess(&self.grid, &self.detections, signs, &span)
    }

    /// The same of the cells before chip `end` of the code period, with later detections from
    /// that chip on only.
    pub fn excess_across(&self, signs: &[&[f64]], end: usize, reach: PairReach) -> Vec<Vec<f64>> {
        let span = Span::across(&self.grid, end, reach);
        self.states.excess(&self.grid, &self.detections, signs, &span)
    }

    /// What `of_period` has for every cell of the code period, for the cells before chip `end`.
    pub fn before<'a>(
        &'a self,
        of_period: &'a [f64],
        end: usize,
        reach: PairReach,
    ) -> impl Iterator<Item = f64> + 'a {
        let cells = self.grid.cells.len();
        let first = Span::across(&self.grid, end, reach).first_chip * cells;
        of_period.iter().copied().cycle().skip(first).take(reach.before * cells)
    }

    /// Share of each cell of a chip that comes after `edge` (in chips from the
    /// chip's start), and after the edge of the chip before; of what a sample sees.
    pub fn shares_after(&self, edge: f64) -> [Vec<f64>; 2] {
        let seen = |from: f64, to: f64| {
            let registered = |time: f64| time + self.samples.origin_chips;
            match &self.samples.sampling {
                None => to - from,
                Some(sampling) => sampling.seen_between(registered(from), registered(to)),
            }
        };
        [edge, edge - 1.0].map(|edge| {
            let cells = self.grid.edges.windows(2);
            cells
                .map(|cell| seen(edge.clamp(cell[0], cell[1]), cell[1]) / (cell[1] - cell[0]))
                .collect()
        })
    }

    /// Share of every cell of the code period in which a pulse is seen.
    pub fn seen_of_period(&self) -> impl Iterator<Item = f64> + '_ {
        self.seen.iter().copied().cycle().take(self.hits.len())
    }
}

fn solve(
    model: &DetectorModel,
    grid: &Grid,
) -> Result<(AllAndMerged, Box<dyn States>), MeanResponseError> {
    if model.dead_time_chips <= 0.0 {
        let (detections, waiting) = poisson::solve(grid);
        return Ok((detections, Box::new(waiting)));
    }
    if model.is_paralyzable {
        return Ok((paralyzable::solve(grid), Box::new(Prolonged)));
    }
    let needed = states_needed(model.afterpulsing, model.dead_time_chips);
    if needed > MAX_STATES {
        return Err(MeanResponseError::TooManyAfterpulses { limit: MAX_STATES });
    }
    Ok(with_states!(needed, M => {
        let chain = Chain::<M>::new(model.afterpulsing, model.dead_time_chips);
        let mut ready = ReadyStates::<M>::new();
        let detections = forward::solve(grid, &chain, grid.round(), Some(&mut ready));
        (detections, Box::new(Solved { chain, ready }))
    }))
}

impl<const M: usize> States for Solved<M> {
    fn excess(&self, grid: &Grid, of: &Detections, signs: &[&[f64]], span: &Span) -> Vec<Vec<f64>> {
        let (chain, states, round) = (&self.chain, &self.ready, grid.round());
        let problem = Backwards { grid, chain, states, detections: of, round };
        variance::excess(&problem, signs, span)
    }
}

impl States for Waiting {
    fn excess(&self, grid: &Grid, _: &Detections, signs: &[&[f64]], span: &Span) -> Vec<Vec<f64>> {
        signs.iter().map(|signs| Waiting::excess(self, grid, signs, span)).collect()
    }
}

/// A dead time that arrivals prolong: it has no state beside its detections.
struct Prolonged;

impl States for Prolonged {
    fn excess(&self, grid: &Grid, of: &Detections, signs: &[&[f64]], span: &Span) -> Vec<Vec<f64>> {
        signs.iter().map(|signs| paralyzable::excess(grid, of, signs, span)).collect()
    }
}

/// Sums over the cells before each chip, and over all: chip by chip, since one sum would wait for each of its additions.
pub fn before_chips<const N: usize>(
    grid: &Grid,
    mut per_cell: impl Iterator<Item = [f64; N]>,
) -> [Vec<f64>; N] {
    let mut sums = std::array::from_fn(|_| Vec::with_capacity(grid.period_chips + 1));
    let mut before = [0.0; N];
    let mut keep = |before: &[f64; N]| {
        sums.iter_mut().zip(before).for_each(|(sums, &before)| sums.push(before));
    };
    for _ in 0..grid.period_chips {
        keep(&before);
        let mut of_chip = [0.0; N];
        for value in per_cell.by_ref().take(grid.cells.len()) {
            of_chip.iter_mut().zip(value).for_each(|(sum, value)| *sum += value);
        }
        before.iter_mut().zip(of_chip).for_each(|(before, of_chip)| *before += of_chip);
    }
    keep(&before);
    sums
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::response::grid::frame_chips;
    use crate::response::sampling::DetectionSampling;
    use crate::response::{CountingTier, MeanResponse, SecondMoments};
    use crate::scene::{DetectorIndex, load_with};
    use crate::sensor::Sensor;

    /// Places one dead time away are borders of cells where the dead time is a whole number of eighths of a chip: what
    /// is read there, and not read twice, against weights of whole cells. One cell's end is then looked up with
    /// the start of the next, unless its light is another.
    #[test]
    fn borders_are_what_their_weights_say_to_the_last_bit() {
        for (dead_time, joins) in [("14 ns", true), ("13.7 ns", false)] {
            let settings = [format!("detector.dead_time={dead_time}").parse().expect("a setting")];
            let file = std::path::Path::new("../scenes/quick.toml");
            let sensor = Sensor::new(&load_with(file, &settings).expect("sound"));
            let model = DetectorModel::new(&sensor, DetectorIndex(0));
            let response = MeanResponse::new(&model).expect("solved");
            let pairs = SecondMoments::new(&response).expect("solved").solved.pairs;
            assert_eq!(pairs.grid.cells.iter().all(|cell| cell.after_joins), joins);

            let mut plain = pairs.grid.clone();
            for cell in &mut plain.cells {
                cell.after_joins = false;
                let places = cell.before.iter_mut().chain(&mut cell.after);
                places.for_each(|place| place.border = None);
            }
            let (all, states) = solve(&model, &plain).expect("solved");
            assert_eq!(all.counted().rates, pairs.detections.rates);
            let cells = 0..pairs.hits.len();
            let signs: Vec<f64> = cells.map(|cell| f64::from(cell as u32 * 7 % 5) - 2.0).collect();
            let span = Span::of_period(&plain);
            for signs in [&[&signs[..]][..], &[&signs, &pairs.hits, &signs]] {
                let excess = states.excess(&plain, &pairs.detections, signs, &span);
                assert_eq!(excess, pairs.excess(signs));
                assert!(excess[0].iter().any(|excess| *excess != 0.0));
            }
        }
    }

    /// What a state is extrapolated to, forwards and backwards, against that which is waited for.
    fn extrapolated<const M: usize>(settings: &[&str]) {
        let parsed = settings.iter().map(|setting| setting.parse().expect("a setting"));
        let file = std::path::Path::new("../scenes/quick.toml");
        let scene = load_with(file, &parsed.collect::<Vec<_>>()).expect("sound");
        let model = DetectorModel::new(&Sensor::new(&scene), DetectorIndex(0));
        let light = Light::of(&model);
        let tier = CountingTier::Sampled;
        let samples = SampleInstants {
            origin_chips: frame_chips(&light) + model.delay_chips,
            sampling: DetectionSampling::of(&model, &light, tier).expect("few pulses merge"),
        };
        let grid = Grid::new(&model, &light, Kinks::LaterAndEarlier, &samples).expect("solved");
        let round = grid.round();
        assert!(round.is_some(), "{settings:?}: {}", grid.memory_chips);
        let needed = states_needed(model.afterpulsing, model.dead_time_chips);
        assert!(needed <= M, "{needed}");
        let chain = Chain::<M>::new(model.afterpulsing, model.dead_time_chips);
        let solved = [None, round].map(|round| {
            let mut states = ReadyStates::<M>::new();
            let detections = forward::solve(&grid, &chain, round, Some(&mut states)).counted();
            (detections, states)
        });
        let rates = solved.each_ref().map(|(detections, _)| detections.rates.concat());
        assert_alike(&rates, 0.0, &format!("{settings:?}: rates"));
        let ready = solved.each_ref().map(|(_, states)| states.concat().concat());
        assert_alike(&ready, 0.0, &format!("{settings:?}: ready"));

        let (detections, states) = (&solved[0].0, &solved[0].1);
        let cells = grid.period_chips * grid.cells.len();
        let signs = [3, 5].map(|every| {
            (0..cells)
                .map(|cell| 1.0 - f64::from(u8::from(cell / 9 % every == 0)))
                .collect::<Vec<_>>()
        });
        // What is waited for drifts, period by period: from twice as far it has drifted twice as much.
        let waited = |times: usize| {
            let after = times * grid.memory_chips.next_multiple_of(grid.period_chips);
            let period = Span::of_period(&grid);
            let period = Span { counted: 0..period.begun + after, ..period };
            let reach = PairReach { before: 40, after: after + grid.period_chips - 3 };
            [period, Span::across(&grid, 3, reach)]
        };
        let counted = [&[&signs[1][..], &signs[0]][..], &[&signs[0]]];
        for (signs, (nearer, farther)) in counted.into_iter().zip(waited(1).iter().zip(&waited(2)))
        {
            let excess = |span: &Span, round| {
                let (grid, chain) = (&grid, &chain);
                let problem = Backwards { grid, chain, states, detections, round };
                variance::excess(&problem, signs, span).concat()
            };
            let [near, far] = [nearer, farther].map(|span| excess(span, None));
            let waited = near.iter().zip(far).map(|(near, far)| 2.0 * near - far).collect();
            let both = [waited, excess(nearer, round)];
            let per_chip = detections.per_period() / grid.period_chips as f64;
            let counts = per_chip * farther.counted.end as f64;
            assert_alike(&both, counts, &format!("{settings:?}: excess"));
        }
    }

    /// Within 1e-9 of the largest, and 1e-12 of what has been summed up to get there.
    fn assert_alike(numbers: &[Vec<f64>; 2], sum: f64, what: &str) {
        let [waited, extrapolated] = numbers;
        assert_eq!(waited.len(), extrapolated.len());
        let largest = waited.iter().fold(0.0, |largest: f64, number| largest.max(number.abs()));
        let differences = waited.iter().zip(extrapolated).map(|(a, b)| (a - b).abs());
        let most = differences.fold(0.0, f64::max);
        let limit = 1e-9 * largest + 1e-12 * sum;
        assert!(largest > 0.0 && most <= limit, "{what}: {most:e} of {largest:e}");
    }

    #[test]
    fn extrapolated_states_are_those_that_are_waited_for() {
        // Just so many that rounds are made, of a code so short that they are.
        const SATURATED: [&str; 3] = [
            "source.mean_power=39 pW",
            "detector.dead_time=87 ns",
            "source.code={ family = \"chips\", chips = \"1110100\" }",
        ];
        let with = |setting| [&SATURATED[..], &[setting]].concat();
        extrapolated::<1>(&with(
            "detector.afterpulsing={ probability = 0, time_constant = \"5 ns\" }",
        ));
        extrapolated::<4>(&SATURATED);
        // Pulses merge.
        extrapolated::<4>(&with("detector.pulse_width=86.5 ns"));
    }
}
