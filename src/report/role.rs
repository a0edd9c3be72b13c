//! What is drawn in figures by what it means, and the colours of that.

/// What is drawn, by what it means: each has its colour, the same in every figure.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DrawingRole {
    /// What was counted, or simulated.
    Counts,
    /// The phase estimator.
    Phase,
    /// The model fit.
    Fit,
    /// The Cramer-Rao bound.
    Bound,
    /// What theory expects.
    Expected,
    /// The truth, limits, and what else is given.
    Truth,
    /// One of several of a kind, by its number.
    Other(usize),
}

/// Colours on light and on dark ground, in the order of the roles. People with any colour vision tell
/// those of two roles apart; a test simulates it.
const COLOURS: [[&str; 2]; 7] = [
    ["#0a4fd6", "#4a86f0"],
    ["#c2500a", "#ea7638"],
    ["#0a5c31", "#2ff18d"],
    ["#9e347f", "#c06aa0"],
    ["#1499c8", "#a6caff"],
    ["#1b2330", "#e4e9f0"],
    ["#8a6400", "#d9b84a"],
];
/// Of several of a kind: none twice, and that of the truth last.
pub(super) const OF_A_KIND: [usize; 7] = [0, 1, 2, 3, 4, 6, 5];

impl DrawingRole {
    /// What a name tells.
    pub(super) fn named(name: &str) -> Option<DrawingRole> {
        let has = |words: &[&str]| words.iter().any(|word| name.contains(word));
        if has(&["bound"]) {
            Some(DrawingRole::Bound)
        } else if has(&["expected", "exact"]) {
            Some(DrawingRole::Expected)
        } else if name.starts_with("phase") {
            Some(DrawingRole::Phase)
        } else {
            name.starts_with("model").then_some(DrawingRole::Fit)
        }
    }

    /// Its class, by which the style has its colour.
    pub(super) fn class(self) -> String {
        format!("s{}", self.colour())
    }

    /// Number of its colour.
    pub(super) fn colour(self) -> usize {
        match self {
            DrawingRole::Counts => 0,
            DrawingRole::Phase => 1,
            DrawingRole::Fit => 2,
            DrawingRole::Bound => 3,
            DrawingRole::Expected => 4,
            DrawingRole::Truth => 5,
            DrawingRole::Other(number) => OF_A_KIND[number % OF_A_KIND.len()],
        }
    }
}

/// Colours as CSS, of the classes `s0` and so on: for the page, on ground of either kind, or for a
/// drawing of its own, whose readers know no variables.
pub(super) fn colours(on_page: bool) -> String {
    let mut style = String::new();
    if on_page {
        let variables = |ground: usize| {
            let all = COLOURS.iter().enumerate();
            all.map(|(number, of)| format!("--s{number}:{};", of[ground])).collect::<String>()
        };
        let [light, dark] = [0, 1].map(variables);
        style = format!(":root{{{light}}}@media (prefers-color-scheme: dark){{:root{{{dark}}}}}\n");
    }
    for (number, colour) in COLOURS.iter().enumerate() {
        let colour = match on_page {
            true => format!("var(--s{number})"),
            false => colour[0].to_owned(),
        };
        let stroked =
            ["curve", "bar", "mark", "block"].map(|kind| format!("svg .{kind}.s{number}"));
        style += &format!(
            "{}{{stroke:{colour}}}svg .dot.s{number},svg .band.s{number}{{fill:{colour}}}",
            stroked.join(",")
        );
    }
    style
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Linear light of a colour, 0 to 1 (IEC 61966-2-1).
    fn light(colour: &str) -> [f64; 3] {
        [1, 3, 5].map(|at| {
            let share = f64::from(u8::from_str_radix(&colour[at..at + 2], 16).unwrap()) / 255.0;
            if share <= 0.04045 { share / 12.92 } else { ((share + 0.055) / 1.055).powf(2.4) }
        })
    }

    fn times(matrix: [[f64; 3]; 3], light: [f64; 3]) -> [f64; 3] {
        matrix.map(|row| (0..3).map(|i| row[i] * light[i]).sum::<f64>())
    }

    const TO_XYZ: [[f64; 3]; 3] =
        [[0.412_4, 0.357_6, 0.180_5], [0.212_6, 0.715_2, 0.072_2], [0.019_3, 0.119_2, 0.950_5]];

    /// CIELAB, white D65.
    fn lab(light: [f64; 3]) -> [f64; 3] {
        let xyz = times(TO_XYZ, light.map(|part| part.clamp(0.0, 1.0)));
        let [x, y, z] =
            [xyz[0] / 0.950_47, xyz[1], xyz[2] / 1.088_83].map(|t| match t > 0.008_856 {
                true => f64::cbrt(t),
                false => 7.787 * t + 16.0 / 116.0,
            });
        [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
    }

    /// What people without one kind of cones see, red, green, blue: G. M. Machado, M. M. Oliveira
    /// and L. A. F. Fernandes, IEEE Trans. Vis. Comput. Graph. 15, 1291 (2009), severity 1.
    const VISIONS: [[[f64; 3]; 3]; 4] = [
        [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        [
            [0.152_286, 1.052_583, -0.204_868],
            [0.114_503, 0.786_281, 0.099_216],
            [-0.003_882, -0.048_116, 1.051_998],
        ],
        [
            [0.367_322, 0.860_646, -0.227_968],
            [0.280_085, 0.672_501, 0.047_413],
            [-0.011_820, 0.042_940, 0.968_881],
        ],
        [
            [1.255_528, -0.076_749, -0.178_779],
            [-0.078_411, 0.930_809, 0.147_602],
            [0.004_733, 0.691_367, 0.303_900],
        ],
    ];

    /// Of colours of one ground, the least difference of two in CIELAB by any vision.
    fn least_difference(colours: &[&str]) -> f64 {
        let mut least = f64::INFINITY;
        for vision in VISIONS {
            let seen: Vec<_> = colours.iter().map(|c| lab(times(vision, light(c)))).collect();
            for (i, a) in seen.iter().enumerate() {
                for b in &seen[..i] {
                    let squares = (0..3).map(|part| (a[part] - b[part]).powi(2));
                    least = least.min(squares.sum::<f64>().sqrt());
                }
            }
        }
        least
    }

    #[test]
    fn people_of_any_colour_vision_tell_the_roles_apart_on_either_ground() {
        use DrawingRole::{Bound, Counts, Expected, Fit, Phase, Truth};
        let roles = [Counts, Phase, Fit, Bound, Expected, Truth];
        for (ground, behind) in [(0, ["#ffffff", "#f5f7fa"]), (1, ["#12161c", "#1a2029"])] {
            let colours = roles.map(|role| COLOURS[role.colour()][ground]);
            let least = least_difference(&colours);
            assert!(least > 20.0, "{ground}: {least}");
            // Graphics: 3 to 1 (WCAG 2.2, 1.4.11).
            let luminance = |colour: &str| times(TO_XYZ, light(colour))[1] + 0.05;
            for (colour, behind) in colours.iter().flat_map(|c| behind.map(|b| (c, b))) {
                let ratio = luminance(colour) / luminance(behind);
                assert!(ratio.max(1.0 / ratio) >= 3.0, "{colour} on {behind}: {ratio}");
            }
        }
        // Red and green of the same lightness are not.
        assert!(least_difference(&["#c2500a", "#6f7d00"]) < 20.0);
        assert!((least_difference(&["#ffffff", "#000000"]) - 100.0).abs() < 0.1);
    }
}
