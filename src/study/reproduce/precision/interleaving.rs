//! Fig. 6: what interleaving wins back.

use std::sync::Arc;

use super::{ErrorCurve, POWER, POWERS_PW, mean_loss, panels, table, with_interval};
use crate::study::reproduce::prelude::*;

/// Fig. 6, which decides C4.
pub fn interleaving(run: &mut FigureScans) -> Result<Figure, FigureError> {
    const INTEGRATION_S: f64 = 209.608e-6;
    let mut codes = Vec::new();
    for nu in 0..=3 {
        codes.push((format!("Gold code, ν = {nu}"), balanced_gold(0, nu)?));
    }
    codes.push(("square wave".to_owned(), square()?));
    let mut curves = Vec::new();
    for (label, code) in &codes {
        curves.push(ErrorCurve::measure(run, label, &POWERS_PW, |power_pw| {
            sensor(&[PathLight::new(code, power_pw)], INTEGRATION_S)
        })?);
    }
    let claims = recovery(&curves, &by_amplitude(&codes)).into_iter().collect();
    let title = "Fig. 6: precision by interleaving depth ν, 209.6 µs per phase step";
    let figure = Figure::new(title, table(&curves), panels(POWER, &curves).into());
    Ok(Figure { claims, ..figure })
}

/// What the amplitudes of eq. 25 alone would give, in words.
fn by_amplitude(codes: &[(String, Arc<Code>)]) -> String {
    let amplitudes: Vec<f64> =
        codes.iter().map(|(_, code)| code.decorrelation_amplitude()).collect();
    let wins_db = |nu: usize, over: usize| 10.0 * (amplitudes[nu] / amplitudes[over]).log10();
    let texts: Vec<String> = amplitudes.iter().map(|a| format!("{a:.3}")).collect();
    format!(
        "The triangles' amplitudes, {} (eq. 25; the last is the square wave's), alone would give \
         {:.2} dB for nu = 1 and {:.2} dB more for nu = 3",
        texts.join(", "),
        wins_db(1, 0),
        wins_db(3, 1),
    )
}

/// C4, from the curves for nu = 0..3 and the square wave.
fn recovery(curves: &[ErrorCurve], by_amplitude: &str) -> Option<Claim> {
    let [plain, once, _, thrice, square] = curves else {
        return None;
    };
    let loss = mean_loss(plain, square)?;
    let once_wins = mean_loss(plain, once)?;
    let thrice_wins = mean_loss(once, thrice)?;
    // Both share the plain curve's errors; taking them as independent widens
    // the interval.
    let share = once_wins.value / loss.value;
    let relative = |m: Measured| m.standard_error() / m.value;
    let share = Measured::normal(share, share * relative(once_wins).hypot(relative(loss)));
    // What nu = 3 wins beyond half of what nu = 1 does.
    let beyond = Measured::normal(
        thrice_wins.value - 0.5 * once_wins.value,
        thrice_wins.standard_error().hypot(0.5 * once_wins.standard_error()),
    );
    let little_more = ClaimVerdict::below(beyond, 0.0);
    let claim = [
        "C4",
        "interleaving wins the loss back, nu = 1 most of it, nu > 1 little more (eq. 25)",
        "nu = 1 wins back more than half of the loss in dB (lower end of the interval), and nu = 3 \
         wins less than half as much again, intervals included",
    ];
    let remark = format!(
        "means in dB over the powers where the coarse stage is right in 99 % of the scans, nu = 0 \
         against the square wave {}, nu = 0 against 1 {}, nu = 1 against 3 {}. {by_amplitude}. The \
         price is side peaks at 2 T_c of 0, 0.5, 0.75 of the peak, and with them coarse slips",
        with_interval(loss),
        with_interval(once_wins),
        with_interval(thrice_wins),
    );
    let verdict = ClaimVerdict::at_least(share, 0.5).and(little_more);
    Some(Claim::measured(claim, share, "of the loss", verdict, remark))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::reproduce::precision::tests::curve;

    #[test]
    fn the_share_won_back_is_that_of_logarithms() {
        // 2 to 1 is the loss; 2 to 2^0.25 wins back three quarters of it.
        let curves = [2.0, 2f64.powf(0.25), 2f64.powf(0.2), 2f64.powf(0.1), 1.0].map(curve);
        let claim = recovery(&curves, "").expect("powers are compared");
        assert!((claim.measured - 0.75).abs() < 1e-12);
        assert_eq!(claim.verdict, ClaimVerdict::Holds);
        // No gain from the first step is not a recovery.
        let claim = recovery(&[2.0, 1.9, 1.5, 1.2, 1.0].map(curve), "").expect("compared");
        assert_eq!(claim.verdict, ClaimVerdict::DoesNotHold);
    }
}
