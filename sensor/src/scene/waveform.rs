//! Shapes in time other than steps and Gaussians: a laser's edges, and the tail of a
//! detector's jitter.

use super::reader::Section;
use crate::scan::Clock;

/// Most rows of a measured curve.
const MOST_ROWS: usize = 4096;
/// A laser's curve is kept as at most so many flashes, one after another.
const MOST_FLASHES: usize = 16;
/// A histogram of jitter is kept as at most so many delays.
const MOST_DELAYS: usize = 64;
/// The rows of a curve are equally far apart, to this share of their distance.
const UNEVEN: f64 = 1e-3;
/// The header that a curve may have.
const HEADER: &str = "time_ps,amplitude";
/// A tail ends after so many time constants (probability 10^-13).
const MOST_TIME_CONSTANTS: f64 = 30.0;

/// How a source's light follows its code.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum LaserResponse {
    /// On and off at once.
    #[default]
    Ideal,
    /// Straight edges, half of which lies before the chip's edge and half after it.
    Edges {
        /// From 10 to 90 % when it turns on.
        rise_time_ps: f64,
        /// From 90 to 10 % when it turns off.
        fall_time_ps: f64,
    },
    /// Such edges, of light that lasts longer than its chips.
    Stretched {
        /// From 10 to 90 % when it turns on.
        rise_time_ps: f64,
        /// From 90 to 10 % when it turns off.
        fall_time_ps: f64,
        /// How much longer, half of it before and half after; may be negative.
        longer_ps: f64,
    },
    /// What a flash without width becomes, its mean time at 0.
    Measured(WaveformCurve),
}

impl LaserResponse {
    /// How much longer the light of a run of on-chips lasts than the chips.
    pub fn longer_ps(&self) -> f64 {
        match self {
            LaserResponse::Stretched { longer_ps, .. } => *longer_ps,
            _ => 0.0,
        }
    }
}

/// The part of a detection's delay that is neither constant nor Gaussian.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum JitterTail {
    /// Nothing.
    #[default]
    None,
    /// An exponential delay of a share of the detections: carriers that diffuse to
    /// where they are multiplied.
    Exponential {
        /// Share of the detections, 0..=1.
        share: f64,
        /// Mean delay of these.
        time_constant_ps: f64,
    },
    /// A measured distribution.
    Measured(WaveformCurve),
}

/// Times and their shares, which add up to 1.
#[derive(Debug, Clone, PartialEq)]
pub struct WaveformCurve {
    /// Time in picoseconds, ascending, and share.
    pub points: Vec<[f64; 2]>,
}

impl WaveformCurve {
    /// A curve from CSV text: rows of a time in picoseconds and an amplitude, equally
    /// spaced. Neighbours are put together, at their mean time, until at most `most`
    /// points are left.
    ///
    /// # Errors
    /// What is wrong, and where.
    fn from_csv(text: &str, most: usize) -> Result<WaveformCurve, String> {
        let rows = rows(text)?;
        let total: f64 = rows.iter().map(|row| row[1]).sum();
        if total <= 0.0 || !total.is_finite() {
            return Err("its amplitudes add up to nothing; one at least must be above 0".to_owned());
        }
        let first = rows.iter().position(|row| row[1] > 0.0).unwrap_or(0);
        let last = rows.iter().rposition(|row| row[1] > 0.0).unwrap_or(0);
        let lit = &rows[first..=last];
        let points = lit.chunks(lit.len().div_ceil(most)).filter_map(|group| {
            let share: f64 = group.iter().map(|row| row[1]).sum();
            let moment: f64 = group.iter().map(|row| row[0] * row[1]).sum();
            (share > 0.0).then(|| [moment / share, share / total])
        });
        Ok(WaveformCurve { points: points.collect() })
    }

    /// Mean time.
    pub fn mean_ps(&self) -> f64 {
        self.points.iter().map(|[time, share]| time * share).sum()
    }

    /// The same curve with its mean time at 0.
    fn centred(mut self) -> WaveformCurve {
        let mean_ps = self.mean_ps();
        self.points.iter_mut().for_each(|point| point[0] -= mean_ps);
        self
    }

    /// From the first time to the last.
    fn width_ps(&self) -> f64 {
        match (self.points.first(), self.points.last()) {
            (Some(first), Some(last)) => last[0] - first[0],
            _ => 0.0,
        }
    }
}

impl JitterTail {
    /// Mean delay.
    pub fn mean_ps(&self) -> f64 {
        match self {
            JitterTail::None => 0.0,
            JitterTail::Exponential { share, time_constant_ps } => share * time_constant_ps,
            JitterTail::Measured(curve) => curve.mean_ps(),
        }
    }
}

fn rows(text: &str) -> Result<Vec<[f64; 2]>, String> {
    let mut rows: Vec<[f64; 2]> = Vec::new();
    let lines = text.lines().zip(1..).map(|(line, n)| (line.trim(), n));
    let mut lines = lines.filter(|(line, _)| !line.is_empty()).peekable();
    lines.next_if(|(line, _)| line.replace(' ', "") == HEADER);
    for (line, number) in lines {
        let numbers: Vec<Option<f64>> = line.split(',').map(|t| t.trim().parse().ok()).collect();
        let [Some(time_ps), Some(amplitude)] = numbers[..] else {
            return Err(format!(
                "its line {number} is not a time in picoseconds, a comma and an amplitude; write for \
                 example 125,0.8"
            ));
        };
        if !(time_ps.is_finite() && amplitude.is_finite() && amplitude >= 0.0) {
            return Err(format!(
                "its line {number} has a time or an amplitude that is not a finite number, or an \
                 amplitude below 0; take what is noise for 0"
            ));
        }
        rows.push([time_ps, amplitude]);
        if rows.len() > MOST_ROWS {
            return Err(format!("it has more than {MOST_ROWS} rows; use fewer"));
        }
    }
    if rows.len() < 2 {
        return Err(format!(
            "it needs two rows at least, of a time in picoseconds and an amplitude each, under a \
             header {HEADER} or none"
        ));
    }
    let spacing = rows[1][0] - rows[0][0];
    let even =
        rows.windows(2).all(|pair| (pair[1][0] - pair[0][0] - spacing).abs() <= UNEVEN * spacing);
    match even && spacing > 0.0 {
        true => Ok(rows),
        false => Err("its times must ascend in equal steps".to_owned()),
    }
}

/// How a source's light follows its code.
pub(super) fn read_laser(section: &Section, clock: Option<Clock>) -> LaserResponse {
    let rise_time = section.quantity("rise_time");
    let fall_time = section.quantity("fall_time");
    let longer_ps = section.quantity("duty_cycle_distortion").unwrap_or_default();
    let measured = read_curve(section, "impulse_response", MOST_FLASHES);
    if section.get("impulse_response").is_some()
        && (section.get("rise_time").is_some() || section.get("fall_time").is_some())
    {
        let message =
            "the edges are in the impulse response; leave out `rise_time` and `fall_time`";
        section.report("impulse_response", message);
    }
    if section.get("impulse_response").is_some() && longer_ps != 0.0 {
        let message = "how long a flash lasts is in the impulse response; leave one of them out";
        section.report("duty_cycle_distortion", message);
    }
    let response = match measured {
        Some(curve) => LaserResponse::Measured(curve.centred()),
        None => match (rise_time.unwrap_or_default(), fall_time.unwrap_or_default()) {
            (rise_time_ps, fall_time_ps) if longer_ps != 0.0 => {
                LaserResponse::Stretched { rise_time_ps, fall_time_ps, longer_ps }
            }
            (0.0, 0.0) => LaserResponse::Ideal,
            (rise_time_ps, fall_time_ps) => LaserResponse::Edges { rise_time_ps, fall_time_ps },
        },
    };
    if let Some(clock) = clock {
        check_edges(section, &response, clock);
    }
    response
}

/// Refuses edges that do not end before the next chip.
fn check_edges(section: &Section, response: &LaserResponse, clock: Clock) {
    let chip_ps = clock.chip_period_ps;
    // Of an edge 0.8 lie between 10 and 90 %.
    let most_ps = 0.8 * chip_ps;
    let too_long = |key: &'static str, time_ps: f64| {
        if time_ps > most_ps {
            let message = format!(
                "{} is more than 80 % of a chip, so that an edge does not end before the next; write \
                 at most \"{} ps\"",
                section.get(key).map_or_else(String::new, |value| section.excerpt(value)),
                most_ps.floor()
            );
            section.report(key, &message);
        }
    };
    match response {
        LaserResponse::Ideal => {}
        LaserResponse::Edges { rise_time_ps, fall_time_ps } => {
            too_long("rise_time", *rise_time_ps);
            too_long("fall_time", *fall_time_ps);
        }
        LaserResponse::Stretched { rise_time_ps, fall_time_ps, longer_ps } => {
            let edges_ps = 0.5 * (rise_time_ps + fall_time_ps) / 0.8;
            if longer_ps.abs() + edges_ps >= chip_ps {
                let message = format!(
                    "beside edges of {edges_ps:.1} ps from end to end, on average, this is as long as \
                     a chip, so that an edge does not end before the next; write less than \
                     \"{:.0} ps\"",
                    (chip_ps - edges_ps).max(0.0)
                );
                section.report("duty_cycle_distortion", &message);
            }
        }
        LaserResponse::Measured(curve) if curve.width_ps() > 16.0 * chip_ps => {
            let message = format!(
                "it is {:.1} ns long, more than 16 chips; take the part with light in it",
                curve.width_ps() / 1e3
            );
            section.report("impulse_response", &message);
        }
        LaserResponse::Measured(_) => {}
    }
}

/// The tail of a detector's jitter, and how long it is at most.
pub(super) fn read_tail(section: &Section) -> (JitterTail, f64) {
    let measured = read_curve(section, "jitter_histogram", MOST_DELAYS);
    let exponential = section.section("jitter_tail").map(|tail| {
        let numbers = (tail.number("share"), tail.quantity("time_constant"));
        tail.finish();
        numbers
    });
    if exponential.is_some() && section.get("jitter_histogram").is_some() {
        let message = "the tail is in the histogram; leave out `jitter_tail`";
        section.report("jitter_histogram", message);
    }
    if let Some(curve) = measured {
        if curve.points.first().is_some_and(|point| point[0] < 0.0) {
            let message = "its times begin before 0; a detection does not come before its \
                           avalanche: let times begin at 0, and `delay` be shorter by as much";
            section.report("jitter_histogram", message);
        }
        let length_ps = curve.points.last().map_or(0.0, |point| point[0]);
        return (JitterTail::Measured(curve), length_ps);
    }
    match exponential {
        Some((Some(share), Some(time_constant_ps))) if share > 0.0 => (
            JitterTail::Exponential { share, time_constant_ps },
            MOST_TIME_CONSTANTS * time_constant_ps,
        ),
        _ => (JitterTail::None, 0.0),
    }
}

fn read_curve(section: &Section, key: &'static str, most: usize) -> Option<WaveformCurve> {
    let text = section.string(key, "0,0.2\\n125,0.8\\n")?;
    let curve = WaveformCurve::from_csv(text, most);
    curve.map_err(|message| section.report(key, &message)).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_curve_keeps_its_mean_and_its_light_however_many_rows_it_has() {
        // A triangle over 0 .. 1000 ps, with dark ends: mean 500, variance 1000^2 / 24.
        let row = |n: i32| {
            let time = f64::from(n) - 200.0;
            let amplitude = (500.0 - (time - 500.0).abs()).max(0.0);
            format!("{time},{amplitude}\n")
        };
        let text: String = (0..1400).map(row).collect();
        let curve = WaveformCurve::from_csv(&text, 16).expect("a curve");
        assert!(curve.points.len() <= 16 && curve.points.len() > 8);
        let total: f64 = curve.points.iter().map(|point| point[1]).sum();
        assert!((total - 1.0).abs() < 1e-12);
        assert!((curve.mean_ps() - 500.0).abs() < 1e-6, "{}", curve.mean_ps());
        let centred = curve.centred();
        let variance: f64 = centred.points.iter().map(|[t, w]| t * t * w).sum();
        let ratio = variance / (1e6 / 24.0);
        assert!((0.98..1.0).contains(&ratio), "{ratio}");
    }

    #[test]
    fn what_is_no_curve_is_named_by_its_line() {
        for (text, complaint) in [
            ("", "two rows at least"),
            ("time_ps,amplitude\n0,1\n", "two rows at least"),
            ("0,1\nx,2\n", "line 2"),
            ("0,1\n1,-2\n", "line 2"),
            ("0,1\n1,nan\n", "line 2"),
            ("0,1\n1,2\n5,1\n", "equal steps"),
            ("0,1\n0,2\n", "equal steps"),
            ("0,0\n1,0\n", "add up to nothing"),
        ] {
            let error = WaveformCurve::from_csv(text, 16).expect_err(text);
            assert!(error.contains(complaint), "{text:?}: {error}");
        }
    }
}
