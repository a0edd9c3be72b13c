//! Table `sampler` of a detector: samples that are not equally far apart.

use std::ops::Range;

use super::declare::*;
use crate::scan::{Clock, Sampler};

/// Widths add up to a chip, but for what is lost in writing them.
const ROUNDING: f64 = 1e-3;
/// A second pin may be moved by no more than so much of a sample.
const MOST_SKEW: f64 = 0.99;

/// Name of the key that names a file.
pub(super) const FILE: &str = "file";
/// Largest such file.
pub(super) const MOST_FILE_BYTES: u64 = 1 << 20;
/// Its columns that are read; others may follow.
const COLUMNS: [&str; 2] = ["sample", "width_samples"];
/// Most samples of a chip.
const MOST_SAMPLES: usize = 64;

tables! {
    SAMPLER = "detector.sampler" {
        widths = number(0.01, 64.0), Otherwise("none"), "1.02";
            "list of the widths of the samples' bins in sample periods, one for each sample of a \
             chip: from the sample before to this one, of sample 0 from the last of the chip before"
            "together they are a chip; a hundredth of a sample is less than any sampler has";
        file = words("the name of a CSV file, from the scene's folder", Form::Text),
            Otherwise("none"), "\"sampler.csv\"";
            "in place of `widths` the file that `goldtof calibrate` has measured them into";
        second_pin_skew = quantity(Time, "-10 ms", "10 ms"), Otherwise("none"), "30 ps";
            "in place of `widths` how much later than it should a second pin takes the odd samples"
            "less than a sample, else samples would change places";
    }
}

/// The sampler of a detector; even where its table is left out. `None` where it is wrong, which is
/// reported.
pub(super) fn read(detector: &Section, clock: Option<Clock>) -> Option<Sampler> {
    let Some(section) = detector.section("sampler") else {
        // A value that is not a table has been reported.
        return detector.get("sampler").is_none().then(Sampler::default);
    };
    let widths = section.numbers("widths", "[0.98, 1.02, 0.98, 1.02]");
    let skew_ps = section.quantity("second_pin_skew");
    let given = ["widths", "second_pin_skew", "file"].map(|key| section.get(key).is_some());
    let sampler = match given {
        [true, false, false] => of_widths(&section, &widths, clock),
        [false, true, false] => of_skew(&section, skew_ps, clock),
        [false, false, true] => {
            section.report(
                "file",
                "the file is read with a scene that is loaded from its folder; a scene without \
                 one has its widths in `widths`",
            );
            None
        }
        [false, false, false] => {
            section.complain(
                "one of `widths`, `file` and `second_pin_skew` is needed; write for example \
                 second_pin_skew = \"30 ps\"",
            );
            None
        }
        _ => {
            section
                .complain("`widths`, `file` and `second_pin_skew` say the same; give one of them");
            None
        }
    };
    section.finish();
    sampler
}

/// The widths of a file's samples, in the order of their numbers; wrong is a place in the text, and
/// what would be right there.
pub(super) fn widths_of_csv(text: &str) -> Result<Vec<f64>, (Range<usize>, String)> {
    let mut at = 0;
    let lines = text.split_inclusive('\n').map(|line| {
        let start = at;
        at += line.len();
        (start..start + line.trim_end().len(), line.trim())
    });
    let mut rows = lines.filter(|(_, line)| !line.is_empty() && !line.starts_with('#'));
    let (place, heading) = rows.next().unwrap_or((0..0, ""));
    if !heading.split(',').map(str::trim).take(2).eq(COLUMNS) {
        let right = COLUMNS.join(",");
        return Err((place, format!("the heading is \"{heading}\"; write {right}")));
    }
    let mut widths: Vec<Option<f64>> = Vec::new();
    for (place, row) in rows {
        let mut fields = row.split(',').map(str::trim);
        let (sample, width) = (fields.next().unwrap_or(""), fields.next().unwrap_or(""));
        let number = sample.parse().ok().filter(|number: &usize| *number < MOST_SAMPLES);
        let Some(number) = number else {
            let message = format!(
                "\"{sample}\" is not a sample; write its number, 0 to {}",
                MOST_SAMPLES - 1
            );
            return Err((place, message));
        };
        let Some(value) = width.parse::<f64>().ok().filter(|width| width.is_finite()) else {
            let message =
                format!("\"{width}\" is not a width; write it in sample periods, for example 1.02");
            return Err((place, message));
        };
        widths.resize(widths.len().max(number + 1), None);
        if widths[number].replace(value).is_some() {
            return Err((place, format!("sample {number} stands there already; write each once")));
        }
    }
    let end = text.trim_end().len();
    let missing = widths.iter().position(Option::is_none);
    let missing = missing.or(widths.is_empty().then_some(0));
    match missing {
        Some(sample) => {
            Err((end..end, format!("sample {sample} is missing; write each from 0 on")))
        }
        None => Ok(widths.into_iter().flatten().collect()),
    }
}

fn of_widths(section: &Section, widths: &[f64], clock: Option<Clock>) -> Option<Sampler> {
    let samples = clock?.samples_per_chip;
    let listed = section.get("widths")?.get_ref().as_array()?.len();
    if listed != samples as usize {
        let message = format!(
            "{listed} widths for {samples} samples of a chip; write one for each, as many as \
             clock.samples_per_chip"
        );
        section.report("widths", &message);
        return None;
    }
    // Those that are not widths have been reported.
    if widths.len() < listed {
        return None;
    }
    let (sum, samples) = (widths.iter().sum::<f64>(), f64::from(samples));
    if (sum - samples).abs() > ROUNDING * samples {
        let message = format!(
            "they add up to {sum:.4} sample periods, and a chip has {samples}; write each in \
             sample periods, 1 for one that is right"
        );
        section.report("widths", &message);
        return None;
    }
    Some(Sampler::of_widths(widths))
}

fn of_skew(section: &Section, skew_ps: Option<f64>, clock: Option<Clock>) -> Option<Sampler> {
    let (skew_ps, clock) = (skew_ps?, clock?);
    let sample_ps = clock.sample_period_ps();
    let skew = skew_ps / sample_ps;
    if clock.samples_per_chip < 2 {
        section.report("second_pin_skew", "one sample in a chip has no second pin");
        return None;
    }
    if skew.abs() > MOST_SKEW {
        let message = format!(
            "a skew of {skew_ps} ps is as long as a sample, which lasts {sample_ps} ps; write less \
             than {:.3} ps",
            MOST_SKEW * sample_ps
        );
        section.report("second_pin_skew", &message);
        return None;
    }
    let widths =
        (0..clock.samples_per_chip).map(|k| if k % 2 == 0 { 1.0 - skew } else { 1.0 + skew });
    Some(Sampler::of_widths(&widths.collect::<Vec<_>>()))
}

#[cfg(test)]
mod tests {
    use super::super::parse;
    use super::*;

    const QUICK: &str = include_str!("../../../scenes/quick.toml");

    fn read(keys: &str) -> Result<Sampler, String> {
        let name = "name = \"spad\"";
        assert!(QUICK.contains(name));
        let text = QUICK.replacen(name, &format!("{name}\nsampler = {{ {keys} }}"), 1);
        let scene = parse("quick.toml", &text).map_err(|error| error.to_string())?;
        Ok(scene.detectors[0].sampler.clone())
    }

    #[test]
    fn widths_and_a_second_pin_say_when_samples_are_taken() {
        let widths = "widths = [1, 0.5, 1.5, 1, 1, 1, 1, 1]";
        let sampler = read(widths).expect("a sampler");
        let instants: Vec<f64> = (0..=8).map(|sample| sampler.instant(sample)).collect();
        assert_eq!(instants, [0.0, 0.5, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0]);
        // A sample of the quick scene lasts 1 ns.
        let sampler = read("second_pin_skew = \"-250 ps\"").expect("a sampler");
        let instants: Vec<f64> = (0..4).map(|sample| sampler.instant(sample)).collect();
        assert_eq!(instants, [0.0, 0.75, 2.0, 2.75]);
        for even in ["second_pin_skew = \"0 ps\"", "widths = [1, 1, 1, 1, 1, 1, 1, 1]"] {
            assert!(read(even).expect("a sampler").is_even());
        }
        // Rounded to three digits.
        let thirds = "widths = [1.333, 1.333, 1.333, 0.8, 0.8, 0.8, 0.8, 0.8]";
        assert!((read(thirds).expect("a sampler").instant(8) - 8.0).abs() < 1e-12);
    }

    #[test]
    fn what_is_no_sampler_is_refused_with_what_would_be_right() {
        for (keys, complaint) in [
            ("widths = [1, 1]", "2 widths for 8 samples of a chip"),
            ("widths = [1, 1, 1, 1, 1, 1, 1, 2]", "add up to 9.0000 sample periods"),
            ("widths = [0, 2, 1, 1, 1, 1, 1, 1]", "0 is outside 0.01 to 64"),
            ("widths = [\"1 ns\", 1, 1, 1, 1, 1, 1, 1]", "a plain number is needed"),
            ("widths = 3", "an array is needed"),
            ("second_pin_skew = \"1 ns\"", "as long as a sample, which lasts 1000 ps"),
            ("second_pin_skew = 30", "30 has no unit"),
            ("file = \"sampler.csv\"", "loaded from its folder"),
            ("", "one of `widths`, `file` and `second_pin_skew` is needed"),
            ("width = [1]", "did you mean `widths`?"),
            (
                "widths = [1, 1, 1, 1, 1, 1, 1, 1], second_pin_skew = \"30 ps\"",
                "say the same; give one of them",
            ),
        ] {
            let error = read(keys).expect_err(keys);
            assert!(error.contains(complaint), "{keys}: {error}");
        }
    }
}
