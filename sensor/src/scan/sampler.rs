//! When the samples of a chip are taken.

use std::sync::Arc;

/// The instants at which a detector's level is sampled. They repeat with every chip.
///
/// Times are in sample periods T_s = T_c / S. Sample k of a chip is taken k T_s after the
/// chip's start if samples are equally far apart, and it shows what happened since the sample
/// before: its *bin*. A sampler that is not perfect has bins of different widths; its sample 0 is
/// still taken at the chip's start, as any constant delay is the detector's.
///
/// ```
/// # mod goldtof {
/// #     pub use goldtof_sensor::*;
/// # }
/// use goldtof::scan::Sampler;
///
/// // Every other sample comes from a second pin, a tenth of a sample late.
/// let sampler = Sampler::of_widths(&[0.9, 1.1, 0.9, 1.1]);
/// assert_eq!([0, 1, 2, 3, 4].map(|sample| sampler.instant(sample)), [0.0, 1.1, 2.0, 3.1, 4.0]);
/// assert_eq!(sampler.first_from(5.05), 5);
/// assert_eq!(Sampler::default().first_from(5.05), 6);
/// ```
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Sampler {
    /// Instants of samples 0 ..= S of a chip, the last that of the next chip's first; none for
    /// samples that are equally far apart.
    instants: Option<Arc<[f64]>>,
}

impl Sampler {
    /// The sampler with bins of such widths, one for each sample of a chip: of sample 0, from the
    /// last sample of the chip before, first. They are scaled to fill a chip.
    ///
    /// # Panics
    /// If a width is not a number above zero, or there is none.
    pub fn of_widths(widths: &[f64]) -> Sampler {
        assert!(!widths.is_empty(), "a chip has a sample");
        assert!(widths.iter().all(|width| *width > 0.0 && width.is_finite()), "widths above zero");
        if widths.windows(2).all(|pair| pair[0] == pair[1]) {
            return Sampler::default();
        }
        let samples = widths.len() as f64;
        let scale = samples / widths.iter().sum::<f64>();
        let mut instants = vec![0.0];
        let mut sum = 0.0;
        for width in &widths[1..] {
            sum += width;
            instants.push(scale * sum);
        }
        instants.push(samples);
        Sampler { instants: Some(instants.into()) }
    }

    /// Whether samples are equally far apart.
    pub fn is_even(&self) -> bool {
        self.instants.is_none()
    }

    /// When a sample is taken, counted from the first of chip 0; before that, too.
    pub fn instant(&self, sample: i64) -> f64 {
        let Some(instants) = &self.instants else { return sample as f64 };
        let samples = instants.len() as i64 - 1;
        let (chip, of_chip) = (sample.div_euclid(samples), sample.rem_euclid(samples));
        (chip * samples) as f64 + instants[of_chip as usize]
    }

    /// Width of a sample's bin.
    pub fn width(&self, sample: i64) -> f64 {
        match &self.instants {
            None => 1.0,
            Some(_) => self.instant(sample) - self.instant(sample - 1),
        }
    }

    /// Widths of all bins of a chip; one of a sampler whose bins are alike.
    fn widths(&self) -> impl Iterator<Item = f64> + '_ {
        let bins = self.instants.as_ref().map_or(1, |instants| instants.len() as i64 - 1);
        (0..bins).map(|sample| self.width(sample))
    }

    /// Width of the widest bin.
    pub fn widest(&self) -> f64 {
        self.widths().fold(0.0, f64::max)
    }

    /// Width of the narrowest bin.
    pub fn narrowest(&self) -> f64 {
        self.widths().fold(f64::INFINITY, f64::min)
    }

    /// Where a time is among the samples: n at the instant of sample n, straight between.
    pub fn place(&self, time: f64) -> f64 {
        let Some(instants) = &self.instants else { return time };
        let samples = (instants.len() - 1) as f64;
        let chips = (time / samples).floor() * samples;
        let within = time - chips;
        let sample = instants.partition_point(|instant| *instant <= within) - 1;
        let width = instants[sample + 1] - instants[sample];
        chips + sample as f64 + (within - instants[sample]) / width
    }

    /// The first sample that is taken at a time that is not negative, or later.
    #[inline]
    pub fn first_from(&self, time: f64) -> u64 {
        let Some(instants) = &self.instants else {
            // As `ceil`, and as quick on any processor.
            let whole = time as i64;
            return (whole + i64::from((whole as f64) < time)) as u64;
        };
        let samples = (instants.len() - 1) as u64;
        let chip = time as u64 / samples * samples;
        let within = time - chip as f64;
        chip + instants.partition_point(|instant| *instant < within) as u64
    }

    /// Share of the light that comes at any time alike which samples show, if of each bin only the
    /// last `seen` does.
    pub fn seen_share(&self, seen: f64) -> f64 {
        let (sum, all) = self
            .widths()
            .fold((0.0, 0.0), |(sum, all), width| (sum + width.min(seen), all + width));
        sum / all
    }

    /// Mean time from what a sample shows to where that sample would be taken if samples were
    /// equally far apart, of light that comes at any time alike. Of each bin only the last
    /// `seen` shows.
    pub fn mean_lateness(&self, seen: f64) -> f64 {
        if self.is_even() {
            return 0.5 * seen.min(1.0);
        }
        let (mut sum, mut all) = (0.0, 0.0);
        for (sample, width) in (0..).zip(self.widths()) {
            let seen = width.min(seen);
            sum += seen * (sample as f64 - self.instant(sample) + 0.5 * seen);
            all += seen;
        }
        sum / all
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 1 + 0.25 + 0.5 + 2.25 sample periods.
    fn uneven() -> Sampler {
        Sampler::of_widths(&[20.0, 5.0, 10.0, 45.0])
    }

    #[test]
    fn instants_repeat_with_the_chip_and_sample_0_is_at_its_start() {
        let instants: Vec<f64> = (-2..6).map(|sample| uneven().instant(sample)).collect();
        assert_eq!(instants, [-3.25, -1.0, 0.0, 0.25, 0.75, 3.0, 4.0, 4.25]);
        let widths: Vec<f64> = (-1..4).map(|sample| uneven().width(sample)).collect();
        assert_eq!(widths, [2.25, 1.0, 0.25, 0.5, 2.25]);
        assert_eq!((uneven().narrowest(), uneven().widest()), (0.25, 2.25));
    }

    #[test]
    fn a_place_is_the_number_of_the_sample_at_its_instant_and_straight_between() {
        for (time, place) in [(0.0, 0.0), (0.125, 0.5), (0.25, 1.0), (1.875, 2.5), (3.5, 3.5)] {
            for chips in [-3.0, 0.0, 7.0] {
                let shift = 4.0 * chips;
                assert_eq!(uneven().place(time + shift), place + shift);
                assert_eq!(Sampler::default().place(time + shift), time + shift);
            }
        }
    }

    #[test]
    fn the_first_sample_from_a_time_on_is_that_at_it_or_the_next() {
        for (time, first) in
            [(0.0, 0), (1e-9, 1), (0.25, 1), (0.26, 2), (0.76, 3), (3.0, 3), (3.1, 4), (8.3, 10)]
        {
            assert_eq!(uneven().first_from(time), first, "{time}");
        }
        for (time, first) in [(0.0, 0), (0.2, 1), (1.0, 1), (7.000001, 8)] {
            assert_eq!(Sampler::default().first_from(time), first, "{time}");
        }
    }

    #[test]
    fn an_even_sampler_is_one_whatever_the_unit_of_its_widths() {
        assert_eq!(Sampler::of_widths(&[250.0; 8]), Sampler::default());
        assert_eq!(Sampler::of_widths(&[1.0]), Sampler::default());
    }

    /// A second pin late by d takes d / 2 off the mean, whatever the samples are like.
    #[test]
    fn the_mean_lateness_is_half_a_sample_less_half_a_second_pins() {
        assert_eq!(Sampler::default().mean_lateness(f64::INFINITY), 0.5);
        assert_eq!(Sampler::default().mean_lateness(0.25), 0.125);
        for d in [-0.5, -0.01, 0.2, 0.75] {
            let widths = [1.0 - d, 1.0 + d, 1.0 - d, 1.0 + d];
            let mean = Sampler::of_widths(&widths).mean_lateness(f64::INFINITY);
            assert!((mean - 0.5 * (1.0 - d)).abs() < 1e-12, "{d}: {mean}");
        }
    }
}
