//! The samples at which a detector's level is high, for a whole run.

use std::ops::Range;

use super::Unfit;
use crate::photons::Pulse;
use crate::scan::Sample;

/// Most runs of samples that are kept, 4 bytes each.
const MOST_RUNS: usize = 1 << 27;
/// Runs that memory gives at once.
const AHEAD: usize = 16;
/// Runs from one whose place is kept to the next.
const STRIDE: usize = 256;

/// A detector's level as lengths of runs: what lanes go through side by side, each of them at another
/// place, has to be small.
#[derive(Debug, Clone, Default)]
pub(super) struct HighSamples {
    /// So many low samples, and so many high ones. Without low ones the high ones before go on.
    runs: Vec<[u16; 2]>,
    /// Where every [`STRIDE`]-th of them begins.
    starts: Vec<Sample>,
    end: Sample,
}

/// Where a reader is: before a run, which begins there.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Place {
    run: usize,
    at: Sample,
}

impl HighSamples {
    /// Takes in pulses, in order of their first samples, counted from sample `origin`, and adds the hits
    /// that they make. One that begins where another has just ended makes none.
    ///
    /// # Errors
    /// When there are too many to keep.
    pub(super) fn add(
        &mut self,
        pulses: &[Pulse],
        origin: Sample,
        hits: &mut Vec<Sample>,
    ) -> Result<(), Unfit> {
        if self.runs.len() + pulses.len() > MOST_RUNS {
            return Err(Unfit::new(format!(
                "the scan has more than {MOST_RUNS} pulses, which lanes keep in memory"
            )));
        }
        self.runs.reserve(pulses.len());
        hits.reserve(pulses.len());
        for pulse in pulses {
            let (first, end) = (pulse.first + origin.0, pulse.end + origin.0);
            if first > self.end {
                hits.push(first);
            }
            let low = first.max(self.end) - self.end;
            let high = end.max(self.end + low) - (self.end + low);
            if high > 0 {
                self.push(low, high);
            }
        }
        Ok(())
    }

    #[inline(always)]
    fn push(&mut self, mut low: u64, mut high: u64) {
        const MOST: u64 = u16::MAX as u64;
        while low > MOST || high > MOST {
            let lows = low.min(MOST);
            let highs = if lows < low { 0 } else { high.min(MOST) };
            self.keep(lows, highs);
            (low, high) = (low - lows, high - highs);
        }
        self.keep(low, high);
    }

    #[inline(always)]
    fn keep(&mut self, low: u64, high: u64) {
        if self.runs.len().is_multiple_of(STRIDE) {
            self.starts.push(self.end);
        }
        self.runs.push([low as u16, high as u16]);
        self.end += low + high;
    }

    /// The first hit at or after a sample. A lane that begins to warm up there has seen no level before,
    /// and a run of high samples that reaches into it would be one hit too many.
    pub(super) fn first_hit_from(&self, sample: Sample) -> Place {
        let mark = self.starts.partition_point(|&start| start <= sample).saturating_sub(1);
        let mut place =
            Place { run: mark * STRIDE, at: self.starts.get(mark).copied().unwrap_or_default() };
        while let Some(&[low, high]) = self.runs.get(place.run)
            && (low == 0 || place.at + u64::from(low) < sample)
        {
            place = place.behind(low, high);
        }
        place
    }

    /// Reads what is at some places, and a little farther on. Lanes are far apart in memory: asked for one after another,
    /// each read would be waited for.
    pub(super) fn touch(&self, places: &[Place]) {
        let lows = |run: usize| self.runs.get(run).map_or(0, |[low, _]| u32::from(*low));
        let touched = places.iter().map(|place| lows(place.run) + lows(place.run + AHEAD));
        std::hint::black_box(touched.fold(0, u32::wrapping_add));
    }

    /// Calls `mark` with each sample of a window, numbered from its start, that is high where the one
    /// before it is not, or the other way round; before the window all is low. The place goes on to the
    /// first run that reaches behind the window.
    #[inline]
    pub(super) fn edges(
        &self,
        place: &mut Place,
        window: &Range<Sample>,
        mut mark: impl FnMut(Sample),
    ) {
        // Whatever is written to memory for each run costs more than all else.
        let mut here = *place;
        for &[low, high] in self.runs.get(here.run..).unwrap_or_default() {
            let (start, next) = (here.at + u64::from(low), here.behind(low, high));
            if start >= window.end {
                break;
            }
            if next.at > window.start && high > 0 {
                mark(Sample(start.max(window.start) - window.start));
            }
            // What reaches into the next window is kept for it.
            if next.at > window.end {
                break;
            }
            if next.at > window.start && high > 0 && next.at < window.end {
                mark(Sample(next.at - window.start));
            }
            here = next;
        }
        *place = here;
    }
}

impl Place {
    fn behind(self, low: u16, high: u16) -> Place {
        Place { run: self.run + 1, at: self.at + u64::from(low) + u64::from(high) }
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    use super::*;

    /// Pulses that overlap, touch, and are far apart or long, against a level that is written out sample
    /// by sample.
    #[test]
    fn edges_and_hits_are_those_of_the_level() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(3);
        let origin = Sample(24);
        let (mut pulses, mut first) = (Vec::new(), 0);
        for number in 0..2_000 {
            let is_odd = number % 500 == 499;
            first += if is_odd { 200_000 } else { rng.random_range(0..9) };
            let length = if is_odd { 150_000 } else { rng.random_range(1..9) };
            pulses.push(Pulse { first: Sample(first), end: Sample(first + length) });
        }
        let last = pulses.iter().map(|pulse| pulse.end.0).max().expect("there are some");
        let mut level = vec![false; (last + origin.0) as usize + 2];
        for pulse in &pulses {
            level[(pulse.first + origin.0).0 as usize..(pulse.end + origin.0).0 as usize]
                .fill(true);
        }
        let (mut high, mut hits) = (HighSamples::default(), Vec::new());
        for some in pulses.chunks(300) {
            high.add(some, origin, &mut hits).expect("they are few");
        }
        let rises: Vec<Sample> = (1..level.len())
            .filter(|&sample| level[sample] && !level[sample - 1])
            .map(|sample| Sample(sample as u64))
            .collect();
        assert_eq!(hits, rises);

        // Windows one after another, from any sample on.
        for _ in 0..50 {
            let from = rng.random_range(0..level.len());
            let hit = rises.partition_point(|rise| rise.0 < from as u64);
            let mut place = high.first_hit_from(Sample(from as u64));
            let mut window = Sample(from as u64)..Sample(from as u64);
            for _ in 0..30 {
                window = window.end..window.end + rng.random_range(1..20_000);
                let mut found = vec![false; (window.end - window.start) as usize];
                high.edges(&mut place, &window, |edge| found[edge.0 as usize] ^= true);
                let mut before = false;
                for (edge, found) in (window.start.0..).zip(found) {
                    // What was high at the start is no hit.
                    let is_seen = rises.get(hit).is_some_and(|rise| rise.0 <= edge);
                    let now = is_seen && level.get(edge as usize).copied().unwrap_or(false);
                    assert_eq!(found, now != before, "sample {edge} of {window:?}");
                    before = now;
                }
            }
        }
    }
}
