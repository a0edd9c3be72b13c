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
}
