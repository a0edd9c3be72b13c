//! A code and its correlation properties, for people and as JSON.

use std::fmt::Write as _;

use serde::Serialize;

use super::{
    CodeError, CodeSpec, Family, Generator, GoldSet, Lfsr, chips_text, polynomial_text,
    value_counts,
};
use crate::document::Body;

/// A code and its correlation properties.
#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
pub struct CodesReport {
    /// Family, as scenes name it.
    pub family: String,
    /// Degree n of the polynomials; none without LFSRs.
    pub degree: Option<u32>,
    /// Code of the Gold set; none for other families.
    pub index: Option<i64>,
    /// Interleaving depth nu.
    pub interleaving_depth: u32,
    /// Chips per period, L'.
    pub length_chips: u64,
    /// One period, first chip first.
    pub chips: String,
    /// Number of chips that are 1.
    pub weight_chips: u64,
    /// Whether ones and zeros are as equal in number as the length allows.
    pub balanced: bool,
    /// Periodic autocorrelation.
    pub autocorrelation: Autocorrelation,
    /// Exponents of each polynomial, descending; of both polynomials of a Gold
    /// set even for the codes that are one of its m-sequences.
    pub polynomials: Vec<Vec<u32>>,
    /// Seed of each polynomial, first chip first, before the index advances v.
    pub seeds: Vec<String>,
    /// The Gold set that the code is from; none for other families.
    pub gold_set: Option<GoldSetReport>,
}

impl Body for CodesReport {
    const NAME: &'static str = "codes";
}

/// Periodic autocorrelation over one period.
#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
pub struct Autocorrelation {
    /// Value without delay, L'.
    pub peak: i64,
    /// The distinct values at all other lags, ascending.
    pub values: Vec<i64>,
    /// At how many lags each of `values` occurs.
    pub counts: Vec<u64>,
}

/// Properties of a Gold set.
#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
pub struct GoldSetReport {
    /// Codes in the set, 2^n + 1.
    pub members: u64,
    /// Codes with 2^(n-1) ones.
    pub balanced_members: u64,
    /// Whether its pair is preferred.
    pub preferred: bool,
    /// Gold's bound t(n).
    pub bound: i64,
    /// The distinct values of the cross-correlation of u and v, ascending.
    pub cross_correlation_values: Vec<i64>,
    /// At how many lags each of them occurs.
    pub cross_correlation_counts: Vec<u64>,
}

/// Makes a code and works out its correlation properties.
///
/// # Errors
/// If the parameters make no code.
pub fn report(spec: &CodeSpec) -> Result<CodesReport, CodeError> {
    let code = spec.build()?;
    let gold_set = match spec.family {
        Family::Gold => Some(spec.gold_set()?),
        Family::MSequence | Family::Square | Family::Chips => None,
    };
    let registers: Vec<&Lfsr> = match (&gold_set, &code.generator) {
        (Some(set), _) => vec![&set.u, &set.v],
        (None, Generator::MSequence(lfsr)) => vec![lfsr],
        (None, _) => Vec::new(),
    };
    let mut correlation = code.autocorrelation();
    let peak = correlation.next().unwrap_or_default();
    let (values, counts) = value_counts(correlation).into_iter().unzip();
    Ok(CodesReport {
        family: spec.family.to_string(),
        degree: registers.first().map(|lfsr| lfsr.degree),
        index: gold_set.as_ref().map(|_| spec.index.unwrap_or(0)),
        interleaving_depth: code.interleave,
        length_chips: code.len(),
        chips: chips_text(&code.chips),
        weight_chips: code.weight(),
        balanced: code.is_balanced(),
        autocorrelation: Autocorrelation { peak, values, counts },
        polynomials: registers.iter().map(|r| r.exponents.clone()).collect(),
        seeds: registers.iter().map(|r| r.seed_text()).collect(),
        gold_set: gold_set.as_ref().map(GoldSetReport::of),
    })
}

impl GoldSetReport {
    fn of(set: &GoldSet) -> GoldSetReport {
        let (values, counts) = set.cross_correlation_counts().into_iter().unzip();
        GoldSetReport {
            members: set.members(),
            balanced_members: set.balanced_members(),
            preferred: set.check_preferred().is_ok(),
            bound: set.bound(),
            cross_correlation_values: values,
            cross_correlation_counts: counts,
        }
    }
}

impl CodesReport {
    /// The report for people.
    pub fn to_text(&self) -> String {
        const MOST_CHIPS_SHOWN: usize = 64;
        let mut text = format!("{} code of {} chips", self.family, self.length_chips);
        if let Some(degree) = self.degree {
            let _ = write!(text, ", degree {degree}");
        }
        if let Some(index) = self.index {
            let _ = write!(text, ", index {index}");
        }
        if self.interleaving_depth > 0 {
            let _ = write!(text, ", interleaved to depth {}", self.interleaving_depth);
        }
        text.push('\n');
        for (polynomial, seed) in self.polynomials.iter().zip(&self.seeds) {
            let polynomial = polynomial_text(polynomial);
            let _ = writeln!(text, "polynomial       {polynomial}, seed {seed}");
        }
        let shown: String = self.chips.chars().take(MOST_CHIPS_SHOWN).collect();
        let more = if shown.len() < self.chips.len() { "..." } else { "" };
        let _ = writeln!(text, "chips            {shown}{more}");
        let balanced = if self.balanced { "balanced" } else { "not balanced" };
        let _ = writeln!(text, "weight           {} ({balanced})", self.weight_chips);
        let _ = writeln!(
            text,
            "autocorrelation  peak {}, elsewhere {}",
            self.autocorrelation.peak,
            with_counts(&self.autocorrelation.values, &self.autocorrelation.counts)
        );
        if let Some(set) = &self.gold_set {
            let preferred = if set.preferred { "preferred" } else { "not preferred" };
            let _ = writeln!(
                text,
                "Gold set         {} codes, {} of them balanced; u and v are {preferred}, \
                 their cross-correlation {} (t = {})",
                set.members,
                set.balanced_members,
                with_counts(&set.cross_correlation_values, &set.cross_correlation_counts),
                set.bound
            );
        }
        text
    }
}

/// `-9 (6x), -1 (15x)`; a long list is cut to its ends.
fn with_counts(values: &[i64], counts: &[u64]) -> String {
    const MOST_VALUES_SHOWN: usize = 9;
    if values.len() > MOST_VALUES_SHOWN {
        let (first, last) = (values[0], values[values.len() - 1]);
        return format!("{} different values from {first} to {last}", values.len());
    }
    values
        .iter()
        .zip(counts)
        .map(|(value, count)| format!("{value} ({count}x)"))
        .collect::<Vec<_>>()
        .join(", ")
}
