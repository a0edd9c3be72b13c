//! What needs no photons: correlations of codes (Fig. 3).

use super::prelude::*;
use crate::code::{CodeError, bound, correlate};

/// Degree of the article's codes.
const DEGREE: u32 = 11;
/// A target near the end of the unambiguous range of 2.45 km: 2.4 km.
const FAR_TARGET_PS: f64 = 16_011_076.6;

/// Fig. 3, which decides C5 and C8.
pub fn code_correlation(run: &mut FigureScans) -> Result<Figure, FigureError> {
    let mut rows = Vec::new();
    for nu in 0..=2 {
        let code = balanced_gold(0, nu)?;
        rows.extend(
            normalised(&code).into_iter().map(|(lag, value)| (format!("ν = {nu}"), lag, value)),
        );
    }
    let table = Table::of(&rows)
        .column("series", |row| row.0.as_str())
        .column("lag_chips", |row| row.1)
        .column("correlation", |row| row.2)
        .table();
    let panel = |label: &str| {
        let y = ChartAxis::linear("correlation", "autocorrelation, share of the peak");
        Panel::new(ChartAxis::linear("lag_chips", label), y)
    };
    // The longest at the back, where it hides nothing.
    let mut whole = table.clone();
    whole.rows.reverse();
    let near = whole.only(|table, row| {
        table.value(row, "lag_chips").number().is_some_and(|lag| lag.abs() <= 10.0)
    });
    let panels = vec![
        panel("lag (chips), the whole period").curves(&whole, Mark::Line),
        panel("lag (chips), near the peak").curves(&near, Mark::LineAndDots),
    ];
    let title = "Fig. 3: autocorrelation of Gold code and interleaved codes, L = 2047";
    let claims = vec![unambiguous_range(run)?, side_lobes()?];
    Ok(Figure { claims, ..Figure::new(title, table, panels) })
}

/// Lag in chips from minus to plus half a period, and the autocorrelation over its peak.
fn normalised(code: &Code) -> Vec<(f64, f64)> {
    let theta = correlate(&code.chips, &code.chips);
    let length = theta.len() as i64;
    let half = length / 2;
    let value = |lag: i64| theta[lag.rem_euclid(length) as usize] as f64 / theta[0] as f64;
    (-half..=(length - 1) / 2).map(|lag| (lag as f64, value(lag))).collect()
}

/// The smallest lag above 0 at which a code equals itself, in chips.
fn period_chips(code: &Code) -> u64 {
    let theta = correlate(&code.chips, &code.chips);
    let repeats = (1..theta.len()).find(|&lag| theta[lag] == theta[0]);
    repeats.unwrap_or(theta.len()) as u64
}

/// C5, with scans of a target near the end of the range.
fn unambiguous_range(run: &mut FigureScans) -> Result<Claim, FigureError> {
    let (code, square) = (balanced_gold(0, 0)?, square()?);
    let range_m = |code: &Code| distance_m(period_chips(code) as f64 * CHIP_PERIOD_PS);
    let times = range_m(&code) / range_m(&square);
    let light = PathLight::new(&code, POWER_PW).at(FAR_TARGET_PS);
    let found: Measured = run.search(&sensor(&[light], 104.8e-6))?;
    let claim = [
        "C5",
        "unambiguous range up a thousandfold, 2.45 km for n = 11 at 8 ns",
        "the code's smallest period, as a distance, is 2.45 km and at least 1000 times the square \
         wave's; every scan finds a target at 2.4 km",
    ];
    let is_met = (range_m(&code) - 2450.0).abs() < 5.0 && times >= 1000.0 && found.value >= 1.0;
    let remark = format!(
        "{times:.1} times the square wave's {:.2} m. Scans over the whole range at {POWER_PW} pW \
         and 104.8 us find the target at 2.4 km in {}; at low light the search fails (figure coarse)",
        range_m(&square),
        in_percent(found),
    );
    Ok(Claim::exact(claim, range_m(&code), "m", ClaimVerdict::exact(is_met), remark))
}

/// C8: every code's autocorrelation, and the figures' code against every other.
fn side_lobes() -> Result<Claim, CodeError> {
    // t(n) = 2^((n + 1) / 2) + 1 for odd n.
    let t = bound(DEGREE);
    let allowed = [-1, -t, t - 2];
    let own = balanced_index(0)?;
    let first = gold(own, 0)?;
    let (mut codes, mut lobes, mut outside, mut largest) = (0_u64, 0_u64, 0_u64, 0);
    for index in -2..first.len() as i64 {
        let code = gold(index, 0)?;
        let auto = correlate(&code.chips, &code.chips);
        let cross = correlate(&first.chips, &code.chips);
        let cross = if index == own { &[][..] } else { &cross[..] };
        for value in auto[1..].iter().chain(cross) {
            lobes += 1;
            outside += u64::from(!allowed.contains(value));
            largest = largest.max(value.abs());
        }
        codes += 1;
    }
    let claim = [
        "C8",
        "side lobes within Gold's three values",
        "no autocorrelation side lobe of any code of the set, and no cross-correlation of the \
         figures' code with another, is any other value than -1, -65, 63",
    ];
    let remark = format!(
        "{lobes} side lobes of {codes} codes; the largest is {largest}, {:.1} % of the peak. \
         Integrating other than whole code periods (13,100 chips are 6.4) adds side lobes of \
         partial correlation, and interleaving adds the near peaks of eq. 24",
        100.0 * largest as f64 / first.len() as f64
    );
    let verdict = ClaimVerdict::exact(outside == 0);
    Ok(Claim::exact(claim, outside as f64, "other values", verdict, remark))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gold_code_repeats_after_all_its_chips_and_a_square_wave_after_two() {
        assert_eq!(period_chips(&balanced_gold(0, 0).expect("a Gold code")), 2047);
        assert_eq!(period_chips(&square().expect("a square wave")), 2);
    }
}
