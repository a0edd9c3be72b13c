//! Text in columns: of words, as wide as the terminal, and of numbers.

/// Least width of a column that is wrapped; narrower, lines run over.
const LEAST_WRAPPED: usize = 24;

/// A row of a name, and of a value as `format!` takes it.
macro_rules! row {
    ($name:expr, $($value:tt)+) => { vec![$name.to_owned(), format!($($value)+)] };
}
pub(super) use row;

/// Lines of cells. Where `width` is given and too small for them, the last column is
/// wrapped, and the first if it leaves no room for the last; the others keep theirs.
pub(super) fn columns(rows: &[Vec<String>], indent: usize, width: Option<usize>) -> String {
    let Some(last) = rows.iter().map(Vec::len).max().and_then(|n| n.checked_sub(1)) else {
        return String::new();
    };
    let widest = |column: usize| {
        let cells = rows.iter().filter_map(|row| row.get(column));
        cells.map(|cell| cell.chars().count()).max().unwrap_or(0)
    };
    let mut widths: Vec<usize> = (0..last).map(widest).collect();
    let before = |widths: &[usize]| indent + widths.iter().map(|width| width + 2).sum::<usize>();
    if let (Some(width), true) = (width, last > 0) {
        let too_much = (before(&widths) + LEAST_WRAPPED.min(widest(last))).saturating_sub(width);
        let least = LEAST_WRAPPED.min(widths[0]);
        widths[0] = widths[0].saturating_sub(too_much).max(least);
    }
    let room =
        width.map_or(usize::MAX, |width| width.saturating_sub(before(&widths)).max(LEAST_WRAPPED));
    widths.push(room);
    rows.iter().map(|row| lines(row, indent, &widths)).collect()
}

/// Lines of one text.
pub(super) fn paragraph(text: impl Into<String>, width: Option<usize>) -> String {
    columns(&[vec![text.into()]], 0, width)
}

/// The lines of one row, each cell wrapped in its column.
fn lines(row: &[String], indent: usize, widths: &[usize]) -> String {
    let cells: Vec<Vec<String>> =
        row.iter().zip(widths).map(|(cell, &width)| wrap(cell, width)).collect();
    let height = cells.iter().map(Vec::len).max().unwrap_or(1);
    let mut text = String::new();
    for number in 0..height {
        let mut line = " ".repeat(indent);
        for (cell, &width) in cells.iter().zip(widths) {
            let part = cell.get(number).map_or("", String::as_str);
            // The last column has no end to be filled up to.
            let filled = if width == usize::MAX { 0 } else { width };
            line += &format!("{part:<filled$}  ");
        }
        text += line.trim_end();
        text.push('\n');
    }
    text
}

/// Lines of no more than `room` characters, where words are no longer.
fn wrap(text: &str, room: usize) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split(' ') {
        let line = lines.last_mut().expect("there is always one");
        if line.is_empty() {
            line.push_str(word);
        } else if line.chars().count() + 1 + word.chars().count() <= room {
            line.push(' ');
            line.push_str(word);
        } else {
            lines.push(word.to_owned());
        }
    }
    lines
}

/// Rows of numbers as lines for people, in columns of a fixed width, under their headings.
pub struct Lines<'a, T> {
    of: &'a [T],
    /// The headings, then a line for each row.
    lines: Vec<String>,
}

impl<'a, T> Lines<'a, T> {
    /// A line for each of these, whose columns are to be declared; all lines begin with `indent`.
    pub fn of(rows: &'a [T], indent: &str) -> Lines<'a, T> {
        Lines { of: rows, lines: vec![indent.to_owned(); rows.len() + 1] }
    }

    /// Declares a column: its heading, and what a row has there; `pad` brings either to its width.
    fn column(
        mut self,
        heading: &str,
        value: impl Fn(&'a T) -> String,
        pad: impl Fn(&str) -> String,
    ) -> Lines<'a, T> {
        let cells = std::iter::once(heading.to_owned()).chain(self.of.iter().map(value));
        self.lines.iter_mut().zip(cells).for_each(|(line, cell)| *line += &pad(&cell));
        self
    }

    /// Declares the first column, or the last, to the left.
    pub fn left(
        self,
        heading: &str,
        width: usize,
        value: impl Fn(&'a T) -> String,
    ) -> Lines<'a, T> {
        self.column(heading, value, |cell| format!("{cell:width$}"))
    }

    /// Declares a column to the right, behind a blank.
    pub fn right(
        self,
        heading: &str,
        width: usize,
        value: impl Fn(&'a T) -> String,
    ) -> Lines<'a, T> {
        self.column(heading, value, |cell| format!(" {cell:>width$}"))
    }

    /// The lines.
    pub fn text(&self) -> String {
        self.lines.iter().map(|line| format!("{}\n", line.trim_end())).collect()
    }
}

/// Digits grouped by threes from 10,000 on.
pub(super) fn number(number: u64) -> String {
    let digits = number.to_string();
    if number < 10_000 {
        return digits;
    }
    let mut text = String::new();
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// A share in percent, rounded down: what is not whole is not shown as whole.
pub(crate) fn percent(share: f64) -> String {
    format!("{:.2} %", (share * 1e4).floor() / 1e2)
}

/// Seconds.
pub(super) fn time(seconds: f64) -> String {
    match seconds {
        s if s >= 172_800.0 => format!("{} days", digits(s / 86_400.0)),
        s if s >= 7200.0 => format!("{} h", digits(s / 3600.0)),
        s if s >= 120.0 => format!("{} min", digits(s / 60.0)),
        s => scaled(s, "s"),
    }
}

/// Metres.
pub(super) fn length(metres: f64) -> String {
    match metres.abs() {
        m if m >= 10_000.0 => format!("{} km", digits(metres / 1e3)),
        m if m >= 1.0 => format!("{} m", digits(metres)),
        _ => scaled(metres, "m"),
    }
}

/// Hertz.
pub(super) fn frequency(hertz: f64) -> String {
    scaled(hertz, "Hz")
}

/// Counts per second.
pub(super) fn rate(per_second: f64) -> String {
    scaled(per_second, "cps")
}

/// Bits per second.
pub(super) fn bit_rate(bits_per_s: f64) -> String {
    scaled(bits_per_s, "bit/s")
}

fn scaled(value: f64, unit: &str) -> String {
    const SCALES: [(f64, &str); 8] = [
        (1e9, "G"),
        (1e6, "M"),
        (1e3, "k"),
        (1.0, ""),
        (1e-3, "m"),
        (1e-6, "\u{b5}"),
        (1e-9, "n"),
        (1e-12, "p"),
    ];
    // 999.9999 of a unit is one of the next.
    let scale = SCALES.iter().find(|(scale, _)| value.abs() >= 0.999_95 * scale);
    match scale {
        Some((scale, prefix)) => format!("{} {prefix}{unit}", digits(value / scale)),
        None => format!("0 {unit}"),
    }
}

/// Four significant digits, without zeros at the end.
fn digits(value: f64) -> String {
    let before = (value.abs().max(1e-300).log10().floor() as i32 + 1).max(1);
    let text = format!("{value:.*}", (4 - before).max(0) as usize);
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(cells: &[&str]) -> Vec<String> {
        cells.iter().map(|&cell| cell.to_owned()).collect()
    }

    #[test]
    fn numbers_stand_under_their_headings() {
        let text = Lines::of(&[(1, 2.5), (20, 0.5)], "  ")
            .left("n", 4, |row| row.0.to_string())
            .right("x mm", 6, |row| format!("{:.1}", row.1))
            .left("", 0, |row| if row.0 > 1 { "  many".to_owned() } else { String::new() })
            .text();
        assert_eq!(text, "  n      x mm\n  1       2.5\n  20      0.5  many\n");
    }

    #[test]
    fn the_last_column_is_wrapped_under_itself() {
        let rows =
            [row(&["a", "one two three four five six seven eight"]), row(&["longer", "short"])];
        let text = "  a       one two three four five
          six seven eight
  longer  short
";
        assert_eq!(columns(&rows, 2, Some(36)), text);
        assert_eq!(columns(&rows, 2, None).lines().count(), 2);
        // A name that leaves no room is wrapped as well.
        let long = [row(&["a name of many words that says it all", "and what it is"])];
        let text = "  a name of many words      and what it is
  that says it all
";
        assert_eq!(columns(&long, 2, Some(42)), text);
        // No terminal is too narrow for words.
        let narrow = columns(&rows, 2, Some(3));
        assert!(narrow.contains("one two") && narrow.lines().count() == 3, "{narrow}");
    }

    #[test]
    fn quantities_have_four_digits_and_the_unit_that_suits() {
        assert_eq!(number(9999), "9999");
        assert_eq!(number(214_525_612), "214,525,612");
        assert_eq!(time(8e-9), "8 ns");
        assert_eq!(time(104.8e-6), "104.8 \u{b5}s");
        assert_eq!(time(1.716_204_8), "1.716 s");
        assert_eq!(time(90.0 * 86_400.0), "90 days");
        assert_eq!(length(2454.52), "2455 m");
        assert_eq!(length(0.149_896), "149.9 mm");
        assert_eq!(length(-0.002), "-2 mm");
        assert_eq!(length(0.0), "0 m");
        assert_eq!(frequency(125e6), "125 MHz");
        assert_eq!(frequency(999.999_99e3), "1 MHz");
    }
}
