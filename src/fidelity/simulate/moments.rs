//! Mean and scatter of a sample.

/// Mean and scatter; what the sample is too small for is not there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moments {
    pub mean: Option<f64>,
    pub std: Option<f64>,
    /// Standard error of the mean.
    pub std_error: Option<f64>,
    /// Standard error of the standard deviation, for normal values.
    pub std_std_error: Option<f64>,
}

impl Moments {
    pub fn of(values: &[f64]) -> Moments {
        let n = values.len() as f64;
        let mean = (!values.is_empty()).then(|| values.iter().sum::<f64>() / n);
        let std = mean.filter(|_| values.len() > 1).map(|mean| {
            let squares: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
            (squares / (n - 1.0)).sqrt()
        });
        Moments {
            mean,
            std,
            std_error: std.map(|std| std / n.sqrt()),
            std_std_error: std.map(|std| std / (2.0 * (n - 1.0)).sqrt()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_sample_is_too_small_for_is_not_there() {
        let nothing = Moments::of(&[]);
        assert_eq!((nothing.mean, nothing.std), (None, None));
        let one = Moments::of(&[2.0]);
        assert_eq!((one.mean, one.std), (Some(2.0), None));
        // 1, 3: mean 2, squared deviations 1 + 1 over n - 1 = 1.
        let two = Moments::of(&[1.0, 3.0]);
        assert_eq!((two.mean, two.std), (Some(2.0), Some(2.0f64.sqrt())));
        assert_eq!(two.std_error, Some(1.0));
    }
}
