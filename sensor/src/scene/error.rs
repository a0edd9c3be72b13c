//! Where a scene is wrong, and what would be right.

use std::cell::RefCell;
use std::fmt;
use std::ops::Range;

use crate::printable::{pictured, printable};

/// One thing that is wrong with a scene.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SceneError {
    /// File as it was named by the caller, or the setting that is not in the file.
    pub file: String,
    /// Line, 1-based; 0 of a setting.
    pub line: usize,
    /// Column in characters, 1-based.
    pub column: usize,
    /// What is wrong, and what would be right.
    pub message: String,
    /// The line of the file, without its end; of a long line what surrounds the
    /// error.
    pub source_line: String,
    /// Character of `source_line` at which the error begins, 0-based.
    pub marked_at: usize,
    /// Characters of the line that the error is about, at least 1.
    pub marked: usize,
}

impl SceneError {
    /// An error that is on no line of the scene.
    pub(super) fn without_line(file: String, message: String) -> SceneError {
        let source_line = String::new();
        SceneError { file, line: 0, column: 0, message, source_line, marked_at: 0, marked: 1 }
    }
}

impl fmt::Display for SceneError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let SceneError { file, line, column, message, source_line, marked_at, marked } = self;
        if *line == 0 {
            return write!(f, "{file}: {message}");
        }
        writeln!(f, "{file}:{line}:{column}: {message}")?;
        let number = line.to_string();
        writeln!(f, "  {number} | {source_line}")?;
        // Tabs stay tabs, so that the caret stands below its character.
        let indent: String = source_line
            .chars()
            .take(*marked_at)
            .map(|c| if c == '\t' { '\t' } else { ' ' })
            .collect();
        let gutter = " ".repeat(number.len());
        write!(f, "  {gutter} | {indent}{}", "^".repeat(*marked))
    }
}

/// Why a scene cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum SceneErrors {
    /// The file cannot be read.
    #[error("{file}: cannot read the scene: {source}{}", meant(.similar))]
    Unreadable {
        /// File as it was named by the caller.
        file: String,
        /// What the system says.
        source: std::io::Error,
        /// A scene beside it, of which the name may be a slip.
        similar: Option<String>,
    },
    /// What is wrong in the file, in its order.
    #[error("{}{}", join(.errors), more(*.left_out))]
    Invalid {
        /// The first errors.
        errors: Vec<SceneError>,
        /// How many more there are.
        left_out: usize,
    },
}

fn meant(similar: &Option<String>) -> String {
    let question = |name: &String| format!("; did you mean {name}?");
    similar.as_ref().map(question).unwrap_or_default()
}

fn join(errors: &[SceneError]) -> String {
    let texts: Vec<String> = errors.iter().map(SceneError::to_string).collect();
    texts.join("\n")
}

fn more(left_out: usize) -> String {
    match left_out {
        0 => String::new(),
        1 => "\nand one more error".to_owned(),
        _ => format!("\nand {left_out} more errors"),
    }
}

/// Most errors that are told: who has more has another kind of file.
const MOST_ERRORS: usize = 50;
/// Longest message; of a longer one, which quotes something long, the middle is
/// left out.
const MOST_MESSAGE_CHARACTERS: usize = 600;
/// Longest source line that is shown whole, and what is shown of a longer one
/// on either side of the mark's start.
const MOST_LINE_CHARACTERS: usize = 240;
const CONTEXT_CHARACTERS: usize = 60;

/// Collects the errors of a scene while it is read.
pub(super) struct Diagnostics<'t> {
    file: &'t str,
    text: &'t str,
    /// Where in the text settings from outside of the file stand, and what they are.
    settings: Vec<(Range<usize>, String)>,
    errors: RefCell<Vec<(Range<usize>, String)>>,
}

impl<'t> Diagnostics<'t> {
    pub(super) fn new(file: &'t str, text: &'t str) -> Self {
        Diagnostics { file, text, settings: Vec::new(), errors: RefCell::new(Vec::new()) }
    }

    /// Diagnostics of a text that settings stand in behind the file's own.
    pub(super) fn with_settings(
        file: &'t str,
        text: &'t str,
        settings: Vec<(Range<usize>, String)>,
    ) -> Self {
        Diagnostics { settings, ..Diagnostics::new(file, text) }
    }

    /// Adds an error about the bytes `span` of the text.
    pub(super) fn report(&self, span: Range<usize>, message: String) {
        let message = printable(&message).into_owned();
        self.errors.borrow_mut().push((span, abridged(message)));
    }

    /// How many errors there are so far.
    pub(super) fn reported(&self) -> usize {
        self.errors.borrow().len()
    }

    /// The error as one of a setting, if the span is in one.
    fn of_setting(&self, span: &Range<usize>, message: &str) -> Option<SceneError> {
        let is_there = |setting: &&(Range<usize>, String)| setting.0.contains(&span.start);
        let (_, origin) = self.settings.iter().find(is_there)?;
        Some(SceneError::without_line(printable(origin).into_owned(), message.to_owned()))
    }

    fn error(&self, span: Range<usize>, message: String) -> SceneError {
        if let Some(error) = self.of_setting(&span, &message) {
            return error;
        }
        let start = floor_char_boundary(self.text, span.start);
        let line_start = self.text[..start].rfind('\n').map_or(0, |at| at + 1);
        let line = self.text[line_start..].lines().next().unwrap_or_default();
        let line_end = line_start + line.len();
        let end = floor_char_boundary(self.text, span.end).clamp(start, line_end.max(start));
        let column = self.text[line_start..start].chars().count() + 1;
        let (source_line, marked_at) = window(line, column - 1);
        let shown_after_mark = source_line.chars().count().saturating_sub(marked_at);
        SceneError {
            file: printable(self.file).into_owned(),
            line: self.text[..line_start].matches('\n').count() + 1,
            column,
            message,
            source_line: pictured(&source_line),
            marked_at,
            marked: self.text[start..end].chars().count().clamp(1, shown_after_mark.max(1)),
        }
    }

    /// The text of `span`, cut to one short line.
    pub(super) fn excerpt(&self, span: Range<usize>) -> String {
        const MOST_CHARACTERS: usize = 40;
        let text = self.text.get(span).unwrap_or_default();
        let line = text.lines().next().unwrap_or_default();
        if line.chars().count() > MOST_CHARACTERS || line.len() < text.len() {
            let start: String = line.chars().take(MOST_CHARACTERS).collect();
            format!("{start}...")
        } else {
            line.to_owned()
        }
    }

    /// `value` if nothing was reported, else the errors in the file's order.
    pub(super) fn finish<T>(self, value: Option<T>) -> Result<T, SceneErrors> {
        let mut found = self.errors.take();
        match value {
            Some(value) if found.is_empty() => Ok(value),
            _ => {
                found.sort_by_key(|(span, _)| span.start);
                let left_out = found.len().saturating_sub(MOST_ERRORS);
                let told = found.into_iter().take(MOST_ERRORS);
                Err(SceneErrors::Invalid {
                    errors: told.map(|(span, message)| self.error(span, message)).collect(),
                    left_out,
                })
            }
        }
    }
}

/// A message without the middle of what is too long to read.
fn abridged(message: String) -> String {
    let characters = message.chars().count();
    if characters <= MOST_MESSAGE_CHARACTERS {
        return message;
    }
    let half = MOST_MESSAGE_CHARACTERS / 2;
    let start: String = message.chars().take(half).collect();
    let end: String = message.chars().skip(characters - half).collect();
    format!("{start} ... {end}")
}

/// The line, or of a long one what surrounds the character `at`; and where that
/// character then is.
fn window(line: &str, at: usize) -> (String, usize) {
    if line.chars().count() <= MOST_LINE_CHARACTERS {
        return (line.to_owned(), at);
    }
    let skipped = at.saturating_sub(CONTEXT_CHARACTERS);
    let shown: String = line.chars().skip(skipped).take(2 * CONTEXT_CHARACTERS).collect();
    let ahead = if skipped > 0 { "... " } else { "" };
    let after = if line.chars().count() > skipped + 2 * CONTEXT_CHARACTERS { " ..." } else { "" };
    (format!("{ahead}{shown}{after}"), at - skipped + ahead.len())
}

/// The last character boundary of `text` at or before byte `at`.
fn floor_char_boundary(text: &str, at: usize) -> usize {
    (0..=at.min(text.len())).rev().find(|&at| text.is_char_boundary(at)).unwrap_or(0)
}
