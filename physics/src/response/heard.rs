//! What crosstalk adds to a detector's light, to first order in its probability.
//!
//! Each avalanche of another detector fires this one a delay later with the probability p, if it
//! is ready. To first order these are events of their own at the rate p a(t - delay), where a is
//! the mean rate of the other's avalanches in its own light. Left out are parts of p^2: avalanches
//! of the other that were caused themselves; and that those which are heard are a dead time apart
//! but for afterpulses, so that fewer of them find the detector blind by one another than of as
//! many at any time. Their share is limited.

use super::MeanResponseError;
use super::avalanches::detections;
use super::domain::check_stillness;
use super::forward::Detections;
use super::grid::{Grid, Kinks, SampleInstants, frame_chips};
use super::light::Light;
use crate::photons::DetectorModel;

/// Largest share of a detector's avalanches that may be of second order in the probability.
const MOST_OF_SECOND_ORDER: f64 = 0.0025;

/// So many brightnesses are told apart of what is heard: each takes a table of its own.
pub(super) const LEVELS: f64 = 1024.0;

/// Mean avalanches of the detectors that fire one.
#[derive(Debug, Clone)]
pub struct Heard {
    others: Vec<Other>,
    second_order_share: f64,
}

/// About which share of a detector's avalanches its expectations leave out, of second order in the
/// probability of crosstalk; 0 where nothing fires it.
///
/// # Errors
/// As for the mean response: detectors with cells, and a share that is too large to be left out.
pub fn second_order_share(model: &DetectorModel) -> Result<f64, MeanResponseError> {
    let heard = Heard::of(model)?;
    Ok(heard.map_or(0.0, |heard| heard.second_order_share))
}

#[derive(Debug, Clone)]
struct Other {
    probability: f64,
    /// From the time that avalanches are counted from to the start of the other's frame.
    later_chips: f64,
    grid: Grid,
    detections: Detections,
}

impl Heard {
    /// What a detector of the scene hears; none if nothing fires it.
    pub fn of(model: &DetectorModel) -> Result<Option<Heard>, MeanResponseError> {
        let Some(coupled) = &model.crosstalk else { return Ok(None) };
        if coupled.heard().next().is_none() {
            return Ok(None);
        }
        if model.pixel.is_some() || coupled.heard().any(|(_, other)| other.pixel.is_some()) {
            return Err(MeanResponseError::CrosstalkOfCells);
        }
        let mut others = Vec::new();
        let mut second_per_chip = 0.0;
        let own_per_chip = average(model);
        for (link, other) in coupled.heard() {
            check_stillness(other)?;
            let light = Light::of(other);
            let samples = SampleInstants { origin_chips: 0.0, sampling: None };
            let grid = Grid::new(other, &light, Kinks::Later, &samples)?;
            let detections = detections(other, &grid)?.all;
            others.push(Other {
                probability: link.probability,
                later_chips: frame_chips(&light) + link.delay_chips,
                grid,
                detections,
            });
            for before in coupled.links.iter().filter(|before| before.to == link.from) {
                let source = coupled.models[before.from].as_ref();
                let its_per_chip = source.map_or(own_per_chip, average);
                second_per_chip += link.probability * before.probability * its_per_chip;
            }
            let its_per_chip = others.last().map_or(0.0, Other::per_chip);
            let blind_chips = model.dead_time_chips.min(other.dead_time_chips);
            let afterpulses = other.afterpulsing.map_or(0.0, |a| a.mean_per_avalanche);
            second_per_chip += link.probability.powi(2)
                * its_per_chip
                * (its_per_chip * blind_chips + afterpulses);
        }
        let mut heard = Heard { others, second_order_share: 0.0 };
        if second_per_chip > 0.0 {
            heard.second_order_share = second_per_chip / (own_per_chip + heard.per_chip());
        }
        let (share, limit) = (heard.second_order_share, MOST_OF_SECOND_ORDER);
        if share > limit {
            return Err(MeanResponseError::Crosstalk { share, limit });
        }
        Ok(Some(heard))
    }

    /// The grid of a detector that hears it, whose frame begins so late.
    pub fn at(heard: Option<&Heard>, mut grid: Grid, frame_chips: f64) -> Grid {
        grid.heard_per_chip = heard.map_or(Vec::new(), |heard| heard.rates(&grid, frame_chips));
        grid
    }

    /// What it adds to the rate in each cell, chip by chip of the grid's period; in steps of a
    /// [level](LEVELS).
    fn rates(&self, grid: &Grid, frame_chips: f64) -> Vec<f64> {
        let mut rates = Vec::with_capacity(grid.period_chips * grid.cells.len());
        for chip in 0..grid.period_chips {
            for edge in grid.edges.windows(2) {
                let [from, to] = [edge[0], edge[1]].map(|edge| frame_chips + chip as f64 + edge);
                rates.push((self.until(to) - self.until(from)) / (to - from));
            }
        }
        let step = rates.iter().copied().fold(0.0, f64::max) / LEVELS;
        if step > 0.0 {
            rates.iter_mut().for_each(|rate| *rate = (*rate / step).round() * step);
        }
        rates
    }

    /// Events before a time, from some time on.
    fn until(&self, time_chips: f64) -> f64 {
        let of = |other: &Other| {
            let time = time_chips - other.later_chips;
            other.probability * other.detections.until(&other.grid, time)
        };
        self.others.iter().map(of).sum()
    }

    /// Events on average.
    fn per_chip(&self) -> f64 {
        self.others.iter().map(|other| other.probability * other.per_chip()).sum()
    }
}

impl Other {
    /// Its avalanches on average.
    fn per_chip(&self) -> f64 {
        self.detections.per_period() / self.grid.period_chips as f64
    }
}

/// About how many avalanches a detector has in a chip, in its own light.
fn average(model: &DetectorModel) -> f64 {
    let light = Light::of(model);
    let lit = |path: &super::LightPath| {
        let on = path.code.chips.iter().map(|&chip| f64::from(chip)).sum::<f64>();
        path.rate_per_chip * on / path.code.chips.len() as f64
    };
    let primary = light.constant_per_chip + light.paths.iter().map(lit).sum::<f64>();
    model.dead_time().detected(primary)
}
