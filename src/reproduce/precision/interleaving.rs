//! Fig. 6: what interleaving wins back.

use super::{Curve, POWER, figure};
use crate::reproduce::figure::{Claim, Figure};
use crate::reproduce::run::{Run, RunError};
use crate::reproduce::sensor::{Light, gold, square};
use crate::reproduce::statistics::{Measured, mean};

/// Fig. 6, which decides C4.
pub fn interleaving(run: &mut Run) -> Result<Figure, RunError> {
    const INTEGRATION_S: f64 = 209.608e-6;
    let mut curves = Vec::new();
    for nu in 0..=3 {
        let code = gold(0, nu)?;
        let label = format!("Gold code, ν = {nu}");
        curves.push(Curve::measure(run, &label, INTEGRATION_S, |p| {
            vec![Light::new(&code, p)]
        })?);
    }
    let square = square()?;
    curves.push(Curve::measure(run, "square wave", INTEGRATION_S, |p| {
        vec![Light::new(&square, p)]
    })?);
    let claims = recovery(&curves).into_iter().collect();
    let title = "Fig. 6: precision by interleaving depth ν, 209.6 µs per phase step";
    Ok(figure(title, POWER, &curves, claims))
}

/// C4, from the curves for nu = 0..3 and the square wave.
fn recovery(curves: &[Curve]) -> Option<Claim> {
    let [plain, once, _, thrice, square] = curves else {
        return None;
    };
    let average = |above: &Curve, below: &Curve| {
        let losses = above.decibels_above(below);
        let values: Vec<Measured> = losses.iter().map(|(_, loss)| *loss).collect();
        (!values.is_empty()).then(|| mean(&values))
    };
    let loss = average(plain, square)?;
    let once_wins = average(plain, once)?;
    let thrice_wins = average(once, thrice)?;
    // Both share the plain curve's errors; taking them as independent widens
    // the interval.
    let share = once_wins.value / loss.value;
    let relative = |m: Measured| m.standard_error() / m.value;
    let share = Measured::normal(share, share * relative(once_wins).hypot(relative(loss)));
    Some(Claim {
        id: "C4",
        article: "interleaving wins the loss back, nu = 1 most of it, nu > 1 little more (eq. 25)",
        criterion: "nu = 1 wins back more than half of the loss in dB (lower end of the \
                    interval), and nu = 3 wins less than half as much again",
        measured: share.value,
        unit: "of the loss",
        ci: Some(share.interval()),
        holds: share.low > 0.5 && thrice_wins.value < 0.5 * once_wins.value,
        remark: format!(
            "means over the powers where the coarse stage is right in 99 % of the scans, nu = 0 \
             against the square wave {:.2} dB ({:.2} to {:.2}), nu = 0 against 1 {:.2} dB ({:.2} \
             to {:.2}), nu = 1 against 3 {:.2} dB ({:.2} to {:.2}). Eq. 25's amplitudes 1, 1.5, \
             1.75, 1.875 alone would give 1.76 dB for nu = 1 and 0.97 dB more for nu = 3. The \
             price is side peaks at 2 T_c of 0, 0.5, 0.75 of the peak, and with them coarse slips",
            loss.value,
            loss.low,
            loss.high,
            once_wins.value,
            once_wins.low,
            once_wins.high,
            thrice_wins.value,
            thrice_wins.low,
            thrice_wins.high,
        ),
    })
}

#[cfg(test)]
mod tests {
    use super::super::tests::curve;
    use super::*;

    #[test]
    fn the_share_won_back_is_that_of_logarithms() {
        // 2 to 1 is the loss; 2 to 2^0.25 wins back three quarters of it.
        let curves = [2.0, 2f64.powf(0.25), 2f64.powf(0.2), 2f64.powf(0.1), 1.0].map(curve);
        let claim = recovery(&curves).expect("powers are compared");
        assert!((claim.measured - 0.75).abs() < 1e-12 && claim.holds);
        // No gain from the first step is no recovery.
        assert!(
            !recovery(&[2.0, 1.9, 1.5, 1.2, 1.0].map(curve))
                .expect("compared")
                .holds
        );
    }
}
