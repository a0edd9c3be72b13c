//! Where a scene is wrong, and what would be right.

use std::cell::RefCell;
use std::fmt;
use std::ops::Range;

/// One thing that is wrong with a scene.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SceneError {
    /// File as it was named by the caller.
    pub file: String,
    /// Line, 1-based.
    pub line: usize,
    /// Column in characters, 1-based.
    pub column: usize,
    /// What is wrong, and what would be right.
    pub message: String,
    /// The line of the file, without its end.
    pub source_line: String,
    /// Characters of the line that the error is about, at least 1.
    pub marked: usize,
}

impl fmt::Display for SceneError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let SceneError {
            file,
            line,
            column,
            message,
            source_line,
            marked,
        } = self;
        writeln!(f, "{file}:{line}:{column}: {message}")?;
        let number = line.to_string();
        writeln!(f, "  {number} | {source_line}")?;
        // Tabs stay tabs, so that the caret stands below its character.
        let indent: String = source_line
            .chars()
            .take(column - 1)
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
    #[error("{file}: cannot read the scene: {source}")]
    Unreadable {
        /// File as it was named by the caller.
        file: String,
        /// What the system says.
        source: std::io::Error,
    },
    /// Everything that is wrong in the file, in its order.
    #[error("{}", join(.0))]
    Invalid(Vec<SceneError>),
}

fn join(errors: &[SceneError]) -> String {
    let texts: Vec<String> = errors.iter().map(SceneError::to_string).collect();
    texts.join("\n")
}

/// Collects what is wrong while a scene is read.
pub(super) struct Diagnostics<'t> {
    file: &'t str,
    text: &'t str,
    errors: RefCell<Vec<(usize, SceneError)>>,
}

impl<'t> Diagnostics<'t> {
    pub(super) fn new(file: &'t str, text: &'t str) -> Self {
        Diagnostics {
            file,
            text,
            errors: RefCell::new(Vec::new()),
        }
    }

    /// Adds an error about the bytes `span` of the text.
    pub(super) fn report(&self, span: Range<usize>, message: String) {
        let start = floor_char_boundary(self.text, span.start);
        let line_start = self.text[..start].rfind('\n').map_or(0, |at| at + 1);
        let source_line = self.text[line_start..].lines().next().unwrap_or_default();
        let line_end = line_start + source_line.len();
        let end = floor_char_boundary(self.text, span.end).clamp(start, line_end.max(start));
        let error = SceneError {
            file: self.file.to_owned(),
            line: self.text[..line_start].matches('\n').count() + 1,
            column: self.text[line_start..start].chars().count() + 1,
            message,
            source_line: source_line.to_owned(),
            marked: self.text[start..end].chars().count().max(1),
        };
        self.errors.borrow_mut().push((start, error));
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
        let mut errors = self.errors.into_inner();
        match value {
            Some(value) if errors.is_empty() => Ok(value),
            _ => {
                errors.sort_by_key(|(start, _)| *start);
                let errors = errors.into_iter().map(|(_, error)| error).collect();
                Err(SceneErrors::Invalid(errors))
            }
        }
    }
}

/// The last character boundary of `text` at or before byte `at`.
fn floor_char_boundary(text: &str, at: usize) -> usize {
    (0..=at.min(text.len()))
        .rev()
        .find(|&at| text.is_char_boundary(at))
        .unwrap_or(0)
}
