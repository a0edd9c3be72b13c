//! Text in columns, as wide as the terminal.

/// Least width of a column that is wrapped; narrower, lines run over.
const LEAST_WRAPPED: usize = 24;

/// Lines of cells. The last column is wrapped where `width` is given and too small for
/// it; the others keep theirs.
pub(super) fn columns(rows: &[Vec<String>], indent: usize, width: Option<usize>) -> String {
    let Some(last) = rows
        .iter()
        .map(Vec::len)
        .max()
        .and_then(|n| n.checked_sub(1))
    else {
        return String::new();
    };
    let widest = |column: usize| {
        let cells = rows.iter().filter_map(|row| row.get(column));
        cells.map(|cell| cell.chars().count()).max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..last).map(widest).collect();
    let before = indent + widths.iter().map(|width| width + 2).sum::<usize>();
    let room = width.map_or(usize::MAX, |width| {
        width.saturating_sub(before).max(LEAST_WRAPPED)
    });
    let mut text = String::new();
    for row in rows {
        let mut line = " ".repeat(indent);
        for (column, &width) in widths.iter().enumerate() {
            let cell = row.get(column).map_or("", String::as_str);
            line += &format!("{cell:<width$}  ");
        }
        let wrapped = wrap(row.get(last).map_or("", String::as_str), room);
        for (number, part) in wrapped.iter().enumerate() {
            if number > 0 {
                line = " ".repeat(before);
            }
            text += line.trim_end_matches(|_| part.is_empty());
            text += part;
            text.push('\n');
        }
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

#[cfg(test)]
mod tests {
    use super::*;

    fn row(cells: &[&str]) -> Vec<String> {
        cells.iter().map(|&cell| cell.to_owned()).collect()
    }

    #[test]
    fn the_last_column_is_wrapped_under_itself() {
        let rows = [
            row(&["a", "one two three four five six seven eight"]),
            row(&["longer", "short"]),
        ];
        let text = "  a       one two three four five
          six seven eight
  longer  short
";
        assert_eq!(columns(&rows, 2, Some(36)), text);
        assert_eq!(columns(&rows, 2, None).lines().count(), 2);
        // No terminal is too narrow for words.
        let narrow = columns(&rows, 2, Some(3));
        assert!(
            narrow.contains("one two") && narrow.lines().count() == 3,
            "{narrow}"
        );
    }
}
