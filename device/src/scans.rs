use goldtof::estimate::chance::NO_PEAK;
use goldtof_wire::{Content, Identity, ResultsFrame};

/// A count at its place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PlacedCount {
    /// Number of the scan since the host began to listen.
    pub scan: u64,
    /// Number of the detector in the scene.
    pub detector: u64,
    /// Phase step of the code period; of a histogram the bin.
    pub phase_step: u64,
    /// The count.
    pub count: i64,
    /// Hits up and down together, where the hardware sends them.
    pub total: Option<u64>,
}

/// The largest of counts that come one after another.
#[derive(Debug, Clone, Default)]
pub struct Largest {
    /// Phase step and count.
    largest: Option<(u64, i64)>,
    counts: Vec<i64>,
}

/// Normal numbers are nearer to their median than this many standard deviations a quarter of the time.
const QUARTER_STD: f64 = 0.3186;

/// In scans of so many peaks' widths the nearest to the median are not a peak's.
const FEWEST_BASES: usize = 4;

impl Largest {
    /// Takes a count.
    pub fn take(&mut self, phase_step: u64, count: i64) {
        self.counts.push(count);
        if self.largest.is_none_or(|(_, largest)| count > largest) {
            self.largest = Some((phase_step, count));
        }
    }

    /// Phase step and count of it; none where nothing stands out: noise that scatters as the counts do has as large
    /// a one, or all are the same, or the only one is 0. A peak is `base` steps wide.
    ///
    /// The scatter is that of the quarter of the counts that are nearest to the median: most sidelobes of a code
    /// are small, and a peak is not among them. Counts are whole numbers: half of one is added.
    pub fn peak(&self, base: usize) -> Option<(u64, i64)> {
        let (step, largest) = self.largest?;
        if self.counts.len() == 1 {
            return (largest != 0).then_some((step, largest));
        }
        let number = self.counts.len();
        if number < FEWEST_BASES * base {
            // Nearly all of them are the peak's.
            let is_flat = self.counts.iter().all(|&count| count == largest);
            return (!is_flat).then_some((step, largest));
        }
        let median = nth(self.counts.iter().copied(), number / 2);
        let quarter = nth(self.counts.iter().map(|count| count.abs_diff(median)), number / 4);
        let std = (quarter as f64 + 0.5) / QUARTER_STD;
        let (height, variance) = (largest.abs_diff(median) as f64, std * std);
        // The Chernoff bound of differences of Poisson numbers.
        let tail = height.hypot(variance) - variance - height * (height / variance).asinh();
        (number as f64 * tail.exp() < NO_PEAK).then_some((step, largest))
    }
}

/// The number that `before` of some are not greater than.
fn nth<T: Ord + Copy>(numbers: impl Iterator<Item = T>, before: usize) -> T {
    let mut numbers: Vec<T> = numbers.collect();
    *numbers.select_nth_unstable(before).1
}

/// Puts the results of frames at their places.
#[derive(Debug, Clone)]
pub struct ResultOrder {
    identity: Identity,
    scan: u64,
    next_index: u64,
}

impl ResultOrder {
    /// Before the first frame.
    pub fn new(identity: Identity) -> ResultOrder {
        ResultOrder { identity, scan: 0, next_index: 0 }
    }

    /// Number of the scan whose results come next.
    pub fn scan(&self) -> u64 {
        self.scan
    }

    /// Whether rows have a total count.
    pub fn has_totals(&self) -> bool {
        self.identity.layout.more_bits > 0 && self.identity.content == Content::Counts
    }

    /// The line was interrupted: what comes next is of another scan.
    pub fn interrupted(&mut self) {
        if self.next_index > 0 {
            self.scan += 1;
            self.next_index = 0;
        }
    }

    /// Gives each count of a frame to `each`.
    pub fn rows(&mut self, frame: &ResultsFrame, mut each: impl FnMut(PlacedCount)) {
        let index = u64::from(frame.index);
        // A scan whose end is missing ends where another one begins.
        if index < self.next_index {
            self.scan += 1;
        }
        let Identity { layout, content, samples_per_chip, .. } = self.identity;
        for (&result, index) in frame.results.iter().zip(index..) {
            let (detector, step) = self.identity.place(index);
            let mut row = |phase_step: u64, count: i64, total: Option<u64>| {
                each(PlacedCount { scan: self.scan, detector, phase_step, count, total });
            };
            match content {
                Content::Counts => {
                    let total = (layout.more_bits > 0).then(|| layout.more(result));
                    row(self.identity.phase_step(step), layout.count(result, 0), total);
                }
                Content::Rows => {
                    for k in 0..layout.counts {
                        let bin = step * u64::from(samples_per_chip) + u64::from(k);
                        row(bin, layout.unsigned_count(result, k) as i64, None);
                    }
                }
                Content::Peaks => row(layout.more(result), layout.count(result, 0), None),
            }
        }
        self.next_index = index + frame.results.len() as u64;
        if frame.last {
            self.scan += 1;
            self.next_index = 0;
        }
    }
}

/// One detector's counts of a whole scan, in the order in which they were measured.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct DetectorScan {
    /// Phase step of each count; of a histogram its bin.
    pub phase_steps: Vec<u64>,
    /// The counts.
    pub counts: Vec<i64>,
    /// Hits up and down together, where the hardware sends them; else empty.
    pub totals: Vec<u64>,
}

/// A scan all of whose results came.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Scan {
    /// Its number since the host began to listen; those that did not come whole have numbers, too.
    pub number: u64,
    /// When its last result came, in seconds since 1970.
    pub time_s: f64,
    /// Its counts, detector by detector.
    pub detectors: Vec<DetectorScan>,
}

/// Takes frames, and gives the scans that came whole.
#[derive(Debug, Clone)]
pub struct Scans {
    order: ResultOrder,
    results_of_scan: u64,
    detectors: usize,
    /// The scan that is coming, and the place of its next result; no place once one is missing.
    coming: Scan,
    next_index: Option<u64>,
}

impl Scans {
    /// Before the first frame.
    pub fn new(identity: Identity) -> Scans {
        Scans {
            order: ResultOrder::new(identity),
            results_of_scan: identity.results_of_scan(),
            detectors: usize::from(identity.detectors),
            coming: Scan::default(),
            next_index: None,
        }
    }

    /// Something is missing: the scan that is coming is not whole, even if a later one goes on at its place.
    pub fn lost(&mut self) {
        self.next_index = None;
    }

    /// The line was interrupted: what comes next is of another scan.
    pub fn interrupted(&mut self) {
        self.order.interrupted();
        self.lost();
    }

    /// Takes a frame that came at `time_s`; gives the scan that it completes.
    pub fn take(&mut self, frame: &ResultsFrame, time_s: f64) -> Option<Scan> {
        if frame.index == 0 {
            self.next_index = Some(0);
            self.coming = Scan {
                number: self.order.scan(),
                time_s,
                detectors: vec![DetectorScan::default(); self.detectors],
            };
        }
        let follows = self.next_index == Some(u64::from(frame.index));
        let coming = &mut self.coming;
        self.order.rows(frame, |row| {
            let Some(of) = coming.detectors.get_mut(row.detector as usize).filter(|_| follows)
            else {
                return;
            };
            coming.number = row.scan;
            of.phase_steps.push(row.phase_step);
            of.counts.push(row.count);
            of.totals.extend(row.total);
        });
        let reached = u64::from(frame.index) + frame.results.len() as u64;
        self.next_index = follows.then_some(reached);
        let is_whole = frame.last && follows && reached == self.results_of_scan;
        is_whole.then(|| {
            self.next_index = None;
            self.coming.time_s = time_s;
            std::mem::take(&mut self.coming)
        })
    }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_distr::{Distribution, Poisson};
    use rand_xoshiro::Xoshiro256PlusPlus;

    use super::*;

    fn peak(counts: impl Iterator<Item = i64>) -> Option<(u64, i64)> {
        let mut largest = Largest::default();
        (0..).zip(counts).for_each(|(step, count)| largest.take(step, count));
        largest.peak(16)
    }

    /// Scans of 248 differences of Poisson numbers, as dark counts up and down are: one in fifty may have a peak,
    /// and where hits are few a hit more or less is none.
    #[test]
    fn noise_has_no_peak() {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(5);
        for hits in [0.02, 1.0, 45.0] {
            let poisson = Poisson::new(hits).expect("a mean");
            let mut difference =
                || (poisson.sample(&mut random) - poisson.sample(&mut random)) as i64;
            let peaks = (0..400).filter(|_| peak((0..248).map(|_| difference())).is_some()).count();
            assert!(peaks <= 24, "{hits}: {peaks} of 400");
        }
    }

    /// A window of a peak's own steps, a square wave, and two steps.
    #[test]
    fn short_scans_have_peaks() {
        let triangle = (0..16).map(|step: i64| 50 * (8 - (step - 8).abs()));
        assert_eq!(peak(triangle), Some((8, 400)));
        let square = (0..16).map(|step: i64| 25 * ((step - 8).abs() - 4));
        assert_eq!(peak(square), Some((0, 100)));
        assert_eq!(peak([0, 70].into_iter()), Some((1, 70)));
        assert_eq!(peak([7, 7].into_iter()), None);
    }

    /// The Gold code of degree 5 with the largest sidelobes, chip by chip and without noise: its peak is one, bright
    /// or dim.
    #[test]
    fn sidelobes_hide_no_peak() {
        let chips = goldtof::Sensor::load("../scenes/quick.toml").expect("the scene is sound");
        let chips = chips.reference(goldtof::scene::DetectorIndex(0)).chips.clone();
        let sign = |chip: usize| 2 * i64::from(chips[chip % 31]) - 1;
        let correlation =
            |lag: usize| (0..31).map(|chip| sign(chip) * sign(chip + lag)).sum::<i64>();
        for times in [1, 1000] {
            let mut largest = Largest::default();
            (0..31)
                .for_each(|step| largest.take(step as u64, times * correlation((step + 11) % 31)));
            assert_eq!(largest.peak(2), Some((20, 31 * times)));
        }
    }
}
