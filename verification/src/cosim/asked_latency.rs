//! Which latency a design is held to, as options say it.

use std::str::FromStr;

/// Longest latency that can be asked for, in clocks.
pub(crate) const MOST_CLOCKS: u32 = 4096;
/// Which latency a design is held to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Latency {
    /// The emitted design's.
    #[default]
    Emitted,
    /// Its own, which a short run of photons shows.
    Auto,
    /// This one, in clocks as `result_latency_clocks` and `peak.latency_clocks` of
    /// `manifest.json` are. Without a peak's own it moves by as much as the results.
    Clocks {
        /// From a group's last word to its first result.
        result: u32,
        /// From a scan's last word to its peak.
        peak: Option<u32>,
    },
}

impl FromStr for Latency {
    type Err = String;

    fn from_str(text: &str) -> Result<Latency, String> {
        let clocks = |text: &str| {
            let clocks = text.trim().parse().ok();
            clocks.filter(|&clocks: &u32| clocks <= MOST_CLOCKS).ok_or_else(|| {
                format!(
                    "write auto, or clocks from 0 to {MOST_CLOCKS}: N of the results, or N,P \
                         with those of the peak"
                )
            })
        };
        if text == "auto" {
            return Ok(Latency::Auto);
        }
        let (result, peak) = match text.split_once(',') {
            Some((result, peak)) => (result, Some(clocks(peak)?)),
            None => (text, None),
        };
        Ok(Latency::Clocks { result: clocks(result)?, peak })
    }
}

impl Latency {
    /// `--latency`: nothing for that of the emitted design.
    pub fn of_option(text: &str) -> Result<Latency, String> {
        if text.is_empty() { Ok(Latency::Emitted) } else { text.parse() }
    }
}
