//! The exact theory of every pixel, from a table over light and delay.
//!
//! A pixel with one path differs from another in three numbers: the rate of its light, that of
//! its background, and its delay. A phase step later everything is as before, as far as the scan
//! has no beginning and no end: delays are folded into one step where pixels show that they may
//! be. Between the nodes stand cubics (Lagrange, four nodes to a side), of the bias as it is and of
//! standard deviation, share of misses and rate by their logarithms. Nodes are worked out where
//! pixels need them. How far the cubics are off is measured at pixels, against the theory of
//! exactly these, and nodes are added until that is below [`MOST_ERROR_IN_STD`].

use std::collections::HashMap;

use rand::seq::index::sample;
use rand::{RngExt as _, SeedableRng as _};
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;
use serde::Serialize;

use super::{Map, PIXEL, Seen};
use crate::estimate::unwrap::check_normal;
use crate::estimate::{CountingTier, Prediction, calibration_offset_ps, distance_m, predict};
use crate::light::photon_rate_hz;
use crate::scene::{EstimatorKind, PathIndex, PixelLight, PixelPath};
use crate::sensor::Sensor;
use crate::simulate::{Tier, simulate};

/// Errors of the interpolation that are small enough, in standard deviations of a pixel.
const MOST_ERROR_IN_STD: f64 = 0.1;
/// Two delays a whole number of phase steps apart are the same if theory says so to this.
const SAME_STEP_IN_STD: f64 = 0.03;
/// Pixels that the interpolation is held against theory at.
const CHECKED: usize = 96;
/// Of these those that ask whether delays may be folded.
const CHECKED_FOLDING: usize = 12;
/// Share of the brightest pixels, of which half of the checked ones are: they scatter least.
const BRIGHTEST: f64 = 0.05;
/// Nodes from which on none are added: a minute of one core, about.
const MOST_NODES: usize = 10_000;
/// What halving a distance leaves of the errors if it is worth its nodes.
const GAIN: f64 = 0.9;
/// A rate that is none, or a share, by its logarithm.
const LEAST: f64 = 1e-15;

/// What theory expects of the pixels.
#[derive(Debug, Clone)]
pub struct TheoryMaps {
    /// Pixel by pixel, row by row; none of one that is dark, or that nothing is expected of.
    pub pixels: Vec<Option<ExpectedPixel>>,
    /// How that was interpolated.
    pub interpolation: TableInterpolation,
    /// What there is to say of it.
    pub remarks: Vec<String>,
}

/// What is expected of a pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExpectedPixel {
    /// Mean error of the distance.
    pub bias_m: f64,
    /// Standard deviation of one scan's distance.
    pub std_m: f64,
    /// Share of scans that miss the pixel's path; NaN where it is not known.
    pub missed_fraction: f64,
    /// Rate of detections.
    pub detected_rate_cps: f64,
}

/// How theory was interpolated, and how well.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
#[schemars(rename = "Interpolation")]
pub struct TableInterpolation {
    /// Points of light and delay that theory was worked out at.
    pub nodes: usize,
    /// Pixels whose own theory it was held against, half of them among the brightest.
    pub checked_pixels: usize,
    /// Largest error of bias or standard deviation at these, in the pixel's standard deviations.
    pub worst_error_in_std: f64,
    /// Root mean square of those errors.
    pub rms_error_in_std: f64,
    /// How much more own light a node has than the one below.
    pub own_light_step_fraction: f64,
    /// The same of background over own light; none where all pixels have the same background.
    pub background_step_fraction: Option<f64>,
    /// Nodes to a phase step of delay.
    pub nodes_per_phase_step: usize,
    /// Whether delays were folded into one phase step.
    pub folded: bool,
    /// Pixels with light of which nothing is expected.
    pub pixels_without_expectation: usize,
}

impl TheoryMaps {
    /// The theory of all pixels, each with one path.
    pub(super) fn of(
        sensor: &Sensor,
        seen: &Seen,
        counting: CountingTier,
        seed: u64,
    ) -> TheoryMaps {
        Tabulation::new(sensor, seen, counting, seed).done()
    }

    /// A map of something that is expected.
    pub fn map(&self, columns: u32, value: impl Fn(&ExpectedPixel) -> f64) -> Map {
        let values = self.pixels.iter().map(|pixel| pixel.as_ref().map_or(f64::NAN, &value));
        Map::new(columns, values.collect())
    }
}

/// What the theory of a pixel depends on.
#[derive(Debug, Clone, Copy, PartialEq)]
struct LightPoint {
    /// Logarithm of the share of its light that arrives.
    own: f64,
    /// Logarithm of background over own light, both in photons; none where the scene has the
    /// background.
    background: Option<f64>,
    delay_ps: f64,
}

/// Coordinates of a cell's corner, in nodes.
type Corner = [i32; 3];
/// What is interpolated, as it is.
type Values = [f64; 4];

/// From node to node.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Grid {
    own: f64,
    background: f64,
    per_step: i32,
    /// Where delays are folded to.
    folded_to_ps: Option<f64>,
}

struct Tabulation<'a> {
    sensor: &'a Sensor,
    counting: CountingTier,
    emitted_hz: f64,
    step_ps: f64,
    points: Vec<Option<LightPoint>>,
    /// Pixels at which it is checked, and their theory.
    checked: Vec<(usize, ExpectedPixel)>,
    /// Nodes by the bits of their coordinates.
    known: HashMap<[u64; 3], Result<Values, String>>,
    remarks: Vec<String>,
}

impl<'a> Tabulation<'a> {
    fn new(sensor: &'a Sensor, seen: &Seen, counting: CountingTier, seed: u64) -> Self {
        let scene = sensor.scene();
        let source = &scene.sources[scene.detectors[PIXEL].reference];
        let emitted_hz = photon_rate_hz(source.mean_power_w, source.wavelength_nm);
        let mut outside = 0;
        let mut point = |pixel: usize| {
            let light = &seen.lights[pixel];
            let path = light.paths.first().filter(|_| seen.own_primary_hz[pixel] > 0.0)?;
            if !is_within_scan(sensor, counting, path.delay_ps) {
                outside += 1;
                return None;
            }
            let own = path.transmission;
            let background =
                light.background_rate_cps.map(|rate| (rate.max(LEAST) / (emitted_hz * own)).ln());
            Some(LightPoint { own: own.ln(), background, delay_ps: path.delay_ps })
        };
        let points: Vec<Option<LightPoint>> = (0..seen.lights.len()).map(&mut point).collect();
        let mut remarks = Vec::new();
        if outside > 0 {
            remarks.push(format!(
                "{outside} pixels have their peak outside of the scan, or within a chip of its rim: \
                 nothing is expected of them"
            ));
        }
        let step_ps = sensor.clock().sample_period_ps();
        let known = HashMap::new();
        let mut made = Tabulation {
            sensor,
            counting,
            emitted_hz,
            step_ps,
            points,
            checked: Vec::new(),
            known,
            remarks,
        };
        let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
        made.choose_checked(&mut random);
        made
    }

    /// Chooses pixels to check at, and works out their theory.
    fn choose_checked(&mut self, random: &mut Xoshiro256PlusPlus) {
        let mut lit: Vec<usize> =
            (0..self.points.len()).filter(|&p| self.points[p].is_some()).collect();
        let anywhere = sample(random, lit.len(), lit.len().min(CHECKED / 2));
        let mut chosen: Vec<usize> = anywhere.into_iter().map(|place| lit[place]).collect();
        let own = |pixel: &usize| self.points[*pixel].map_or(0.0, |point| point.own);
        lit.sort_by(|a, b| own(b).total_cmp(&own(a)));
        let bright = ((lit.len() as f64 * BRIGHTEST).ceil() as usize).max(CHECKED / 2);
        let bright = &lit[..bright.min(lit.len())];
        let of_bright = sample(random, bright.len(), bright.len().min(CHECKED / 2));
        chosen.extend(of_bright.into_iter().map(|place| bright[place]));
        // In no order of light, so that the first of them are anywhere.
        for last in (1..chosen.len()).rev() {
            chosen.swap(last, random.random_range(0..=last));
        }
        let exact = |&pixel: &usize| Some((pixel, self.exact(&self.points[pixel]?).ok()?));
        self.checked = chosen.par_iter().filter_map(exact).collect();
    }

    /// The theory of a point.
    fn exact(&self, point: &LightPoint) -> Result<ExpectedPixel, String> {
        let own = point.own.exp();
        let path = PixelPath {
            source: self.sensor.scene().detectors[PIXEL].reference,
            delay_ps: point.delay_ps,
            transmission: own,
        };
        let light = PixelLight {
            ray: [0.0, 0.0, 1.0],
            paths: vec![path],
            distances_m: vec![distance_m(point.delay_ps)],
            background_rate_cps: point.background.map(|ratio| ratio.exp() * self.emitted_hz * own),
        };
        expected(&Sensor::new(&self.sensor.scene().of_pixel(&light)), self.counting)
    }

    /// Where the grid begins, and adds nodes until it is good enough.
    fn done(mut self) -> TheoryMaps {
        let mut grid =
            Grid { own: 0.5, background: 1.0, per_step: 4, folded_to_ps: self.folding() };
        let mut error = self.errors(&grid);
        // Which distance is halved next, and how many have been without gain.
        let (mut axis, mut without_gain) = (0, 0);
        while error.0 >= MOST_ERROR_IN_STD && self.known.len() < MOST_NODES {
            // Jumps of the coarse stage run across light and delay: neither alone may help.
            let both = without_gain == 3;
            let mut finer = grid;
            if both || axis == 0 {
                finer.per_step *= 2;
            }
            if both || axis == 1 {
                finer.own *= 0.5;
            }
            if axis == 2 && !both {
                finer.background *= 0.5;
            }
            let found = self.errors(&finer);
            if both || found.1 < GAIN * error.1 {
                (grid, error, without_gain) = (finer, found, 0);
            } else {
                (axis, without_gain) = ((axis + 1) % 3, without_gain + 1);
            }
        }
        if error.0 >= MOST_ERROR_IN_STD {
            self.remarks.push(format!(
                "theory is interpolated with errors of up to {:.2} standard deviations",
                error.0
            ));
        }
        let all: Vec<usize> = (0..self.points.len()).collect();
        let pixels = self.interpolated(&grid, &all);
        let dark = |(point, found): &(&Option<LightPoint>, &Option<ExpectedPixel>)| {
            point.is_some() && found.is_none()
        };
        let pixels_without_expectation = self.points.iter().zip(&pixels).filter(dark).count();
        if pixels_without_expectation > 0
            && let Some(reason) = self.reason()
        {
            self.remarks.push(format!(
                "nothing is expected of {pixels_without_expectation} pixels: {reason}"
            ));
        }
        let has_background = self.points.iter().flatten().any(|point| point.background.is_some());
        TheoryMaps {
            interpolation: TableInterpolation {
                nodes: self.known.len(),
                checked_pixels: self.checked.len(),
                worst_error_in_std: error.0,
                rms_error_in_std: error.1,
                own_light_step_fraction: grid.own.exp_m1(),
                background_step_fraction: has_background.then(|| grid.background.exp_m1()),
                nodes_per_phase_step: grid.per_step as usize,
                folded: grid.folded_to_ps.is_some(),
                pixels_without_expectation,
            },
            pixels,
            remarks: self.remarks,
        }
    }

    /// Where delays are folded to: the beginning of a phase step amid those of the pixels; none
    /// where theory is another a step later.
    fn folding(&self) -> Option<f64> {
        let mut delays: Vec<f64> =
            self.points.iter().flatten().map(|point| point.delay_ps).collect();
        delays.sort_by(f64::total_cmp);
        let middle_ps = *delays.get(delays.len() / 2)?;
        let to_ps = (middle_ps / self.step_ps).floor() * self.step_ps;
        let is_same = |(pixel, found): &(usize, ExpectedPixel)| {
            let point = self.points[*pixel]?;
            let delay_ps = to_ps + (point.delay_ps - to_ps).rem_euclid(self.step_ps);
            let there = self.exact(&LightPoint { delay_ps, ..point }).ok()?;
            Some(error_in_std(&there, found) < SAME_STEP_IN_STD)
        };
        let some = &self.checked[..self.checked.len().min(CHECKED_FOLDING)];
        some.par_iter().all(|checked| is_same(checked) == Some(true)).then_some(to_ps)
    }

    /// Largest and root mean square error at the checked pixels, in standard deviations. One that
    /// nodes nearby give no number for does not count.
    fn errors(&mut self, grid: &Grid) -> (f64, f64) {
        let pixels: Vec<usize> = self.checked.iter().map(|(pixel, _)| *pixel).collect();
        let found = self.interpolated(grid, &pixels);
        let pairs = pixels.iter().zip(&self.checked);
        let errors: Vec<f64> = pairs
            .filter_map(|(&pixel, (_, exact))| Some(error_in_std(found[pixel].as_ref()?, exact)))
            .collect();
        let squares: f64 = errors.iter().map(|error| error * error).sum();
        let worst = errors.iter().copied().fold(0.0, f64::max);
        (worst, (squares / errors.len().max(1) as f64).sqrt())
    }

    /// Why there is no theory at a node, of the first that has none.
    fn reason(&self) -> Option<String> {
        self.known.values().filter_map(|node| node.as_ref().err()).min().cloned()
    }

    /// The theory of some pixels, at their places among all.
    fn interpolated(&mut self, grid: &Grid, pixels: &[usize]) -> Vec<Option<ExpectedPixel>> {
        // Cells with their nodes, each cell once.
        let mut cells: HashMap<Corner, usize> = HashMap::new();
        let mut corners: Vec<Corner> = Vec::new();
        let mut placed: Vec<(usize, usize, [f64; 3])> = Vec::new();
        for &pixel in pixels {
            let Some(point) = &self.points[pixel] else { continue };
            let (corner, within) = self.place(grid, point);
            let cell = *cells.entry(corner).or_insert_with(|| {
                corners.push(corner);
                corners.len() - 1
            });
            placed.push((pixel, cell, within));
        }
        let has_background = self.points.iter().flatten().any(|point| point.background.is_some());
        let mut wanted: Vec<LightPoint> = Vec::new();
        let mut keys: Vec<Vec<[u64; 3]>> = Vec::new();
        for corner in &corners {
            let nodes = around(*corner, has_background).map(|node| {
                let point = self.node(grid, node, has_background);
                let key = key(&point);
                self.known.entry(key).or_insert_with(|| {
                    wanted.push(point);
                    Err(String::new())
                });
                key
            });
            keys.push(nodes.collect());
        }
        let exact =
            |point: &LightPoint| (key(point), self.exact(point).map(|found| found.values()));
        let found: Vec<_> = wanted.par_iter().map(exact).collect();
        self.known.extend(found);
        let nodes: Vec<Option<Vec<Values>>> = keys
            .iter()
            .map(|keys| keys.iter().map(|key| self.known[key].as_ref().ok().copied()).collect())
            .collect();
        let mut told = vec![None; self.points.len()];
        for (pixel, cell, within) in placed {
            told[pixel] = nodes[cell].as_ref().map(|nodes| between(nodes, within, has_background));
        }
        told
    }

    /// The cell of a point, and where it is in it.
    fn place(&self, grid: &Grid, point: &LightPoint) -> (Corner, [f64; 3]) {
        let from_ps = grid.folded_to_ps.unwrap_or(0.0);
        let steps = (point.delay_ps - from_ps) / self.step_ps;
        let steps = if grid.folded_to_ps.is_some() { steps.rem_euclid(1.0) } else { steps };
        let coordinates = [
            point.own / grid.own,
            point.background.unwrap_or(0.0) / grid.background,
            steps * f64::from(grid.per_step),
        ];
        (coordinates.map(|at| at.floor() as i32), coordinates.map(|at| at - at.floor()))
    }

    /// The point of a node.
    fn node(&self, grid: &Grid, node: Corner, has_background: bool) -> LightPoint {
        let (from_ps, step) = match grid.folded_to_ps {
            Some(from_ps) => (from_ps, node[2].rem_euclid(grid.per_step)),
            None => (0.0, node[2]),
        };
        LightPoint {
            own: f64::from(node[0]) * grid.own,
            background: has_background.then(|| f64::from(node[1]) * grid.background),
            delay_ps: from_ps + f64::from(step) * (self.step_ps / f64::from(grid.per_step)),
        }
    }
}

impl ExpectedPixel {
    fn values(&self) -> Values {
        [
            self.bias_m,
            self.std_m.ln(),
            self.missed_fraction.max(LEAST).ln(),
            self.detected_rate_cps.max(LEAST).ln(),
        ]
    }

    fn of([bias_m, std, missed, rate]: Values) -> ExpectedPixel {
        ExpectedPixel {
            bias_m,
            std_m: std.exp(),
            missed_fraction: missed.exp().min(1.0),
            detected_rate_cps: rate.exp(),
        }
    }
}

/// What the scene's estimator is expected to say of a sensor's only path.
pub(super) fn expected(sensor: &Sensor, counting: CountingTier) -> Result<ExpectedPixel, String> {
    if sensor.scene().estimator == EstimatorKind::Fft {
        let predicted =
            predict(sensor, PIXEL, PathIndex(0), counting).map_err(|e| e.to_string())?;
        let Prediction { bias_m, std_m, missed_fraction, detection_rate_hz, .. } = predicted;
        let range_m = distance_m(sensor.timing().code_period_ps());
        check_normal(std_m, range_m).map_err(|spread| spread.to_string())?;
        return Ok(ExpectedPixel {
            bias_m,
            std_m,
            missed_fraction: missed_fraction.unwrap_or(f64::NAN),
            detected_rate_cps: detection_rate_hz,
        });
    }
    let tier = match counting {
        CountingTier::Sampled => Tier::Sampled,
        CountingTier::Events | CountingTier::Binned => Tier::Events,
    };
    let simulation = simulate(sensor, tier.scans(0), |_| ()).map_err(|error| error.to_string())?;
    let path = simulation.estimates.into_iter().next().ok_or("there is no path")?;
    let remark = path.remark.unwrap_or_else(|| "nothing is expected".to_owned());
    let (bias_m, std_m) = path.expected_bias_m.zip(path.expected_std_m).ok_or(remark)?;
    let rate = predict(sensor, PIXEL, PathIndex(0), counting);
    Ok(ExpectedPixel {
        bias_m,
        std_m,
        missed_fraction: path.expected_missed_fraction.unwrap_or(f64::NAN),
        detected_rate_cps: rate.map_or(f64::NAN, |predicted| predicted.detection_rate_hz),
    })
}

/// Whether the phase finds a whole window of steps round a delay in the scan.
fn is_within_scan(sensor: &Sensor, counting: CountingTier, delay_ps: f64) -> bool {
    let scan = &sensor.timing().scan;
    if scan.is_full() {
        return true;
    }
    let offset_ps = calibration_offset_ps(sensor, PIXEL, counting);
    let place = (delay_ps + offset_ps) / sensor.clock().sample_period_ps() - scan.first_step as f64;
    let place = place.rem_euclid(scan.steps_per_period as f64);
    let chip = f64::from(sensor.clock().samples_per_chip) + 1.0;
    (chip..=scan.steps as f64 - 1.0 - chip).contains(&place)
}

/// The larger error of bias and standard deviation, in the exact standard deviation.
fn error_in_std(found: &ExpectedPixel, exact: &ExpectedPixel) -> f64 {
    let errors = [found.bias_m - exact.bias_m, found.std_m - exact.std_m];
    errors.iter().fold(0.0, |most: f64, error| most.max(error.abs() / exact.std_m))
}

fn key(point: &LightPoint) -> [u64; 3] {
    [point.own, point.background.unwrap_or(0.0), point.delay_ps].map(f64::to_bits)
}

/// The nodes that a cell's cubics take: four to a side.
fn around(corner: Corner, has_background: bool) -> impl Iterator<Item = Corner> {
    let sides = move |axis: usize| if axis == 1 && !has_background { 0..=0 } else { -1..=2 };
    sides(0).flat_map(move |a| {
        sides(1)
            .flat_map(move |b| sides(2).map(move |c| [corner[0] + a, corner[1] + b, corner[2] + c]))
    })
}

/// Cubics through a cell's nodes, in the order of [`around`].
fn between(nodes: &[Values], within: [f64; 3], has_background: bool) -> ExpectedPixel {
    let [own, background, delay] = within.map(weights);
    let background = if has_background { &background[..] } else { &[1.0][..] };
    let mut sum = [0.0; 4];
    let mut nodes = nodes.iter();
    for a in own {
        for b in background {
            for c in delay {
                let Some(values) = nodes.next() else { break };
                for (sum, value) in sum.iter_mut().zip(values) {
                    *sum += a * b * c * value;
                }
            }
        }
    }
    ExpectedPixel::of(sum)
}

/// Lagrange's weights of the nodes at -1, 0, 1 and 2.
fn weights(at: f64) -> [f64; 4] {
    [
        -at * (at - 1.0) * (at - 2.0) / 6.0,
        (at + 1.0) * (at - 1.0) * (at - 2.0) / 2.0,
        -(at + 1.0) * at * (at - 2.0) / 2.0,
        (at + 1.0) * at * (at - 1.0) / 6.0,
    ]
}
