//! Names and texts that we did not make, as they may be shown and written.
//!
//! A file may be called anything, and so may a source in a scene. A newline in a
//! name would end the comment that it stands in; an escape sequence would command
//! the terminal that it is printed on; a mark of writing direction would make a
//! line read as another. All of them become visible escapes, as Rust writes them:
//! `\n`, `\u{1b}`, and `\xff` for a byte that is not text.

use std::borrow::Cow;
use std::fmt::Write as _;
use std::path::Path;

/// Whether a character commands a terminal or a reader's eye in place of being
/// seen: control characters, line separators, marks of direction, and what is no
/// character.
pub fn is_unprintable(c: char) -> bool {
    c.is_control()
        || matches!(
            c,
            '\u{61c}'
                | '\u{200b}'..='\u{200f}'
                | '\u{2028}'..='\u{202e}'
                | '\u{2060}'..='\u{206f}'
                | '\u{feff}'
                | '\u{fff9}'..='\u{fffb}'
                | '\u{e0000}'..='\u{e007f}'
        )
        || (c as u32) & 0xfffe == 0xfffe
}

/// A field of a CSV file (RFC 4180).
pub fn csv_field(field: &str) -> String {
    if field.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", field.replace('"', "\"\""))
    } else {
        field.to_owned()
    }
}

/// One line of text: nothing in it that cannot be seen.
pub fn printable(text: &str) -> Cow<'_, str> {
    escaped(text, is_unprintable)
}

/// Text of several lines: line ends and tabs stay.
pub fn printable_lines(text: &str) -> Cow<'_, str> {
    escaped(text, |c| is_unprintable(c) && c != '\n' && c != '\t')
}

/// One line of ASCII, for the headers of files whose language knows no more.
pub fn printable_ascii(text: &str) -> Cow<'_, str> {
    escaped(text, |c| c.is_control() || !c.is_ascii())
}

/// A file's name on one line, bytes that are not text as `\xff`.
pub fn printable_path(path: &Path) -> String {
    let mut shown = String::new();
    for chunk in path.as_os_str().as_encoded_bytes().utf8_chunks() {
        shown += &printable(chunk.valid());
        for byte in chunk.invalid() {
            let _ = write!(shown, "\\x{byte:02x}");
        }
    }
    shown
}

/// A word as a shell reads it back: in quotation marks where it would be taken apart.
pub fn shell_word(word: &str) -> Cow<'_, str> {
    let is_plain = |c: char| c.is_alphanumeric() || "-_./=:,@%+".contains(c);
    match !word.is_empty() && word.chars().all(is_plain) {
        true => Cow::Borrowed(word),
        false => Cow::Owned(format!("'{}'", word.replace('\'', "'\\''"))),
    }
}

/// A line of which every character keeps its place: one that cannot be seen has a
/// picture in its stead. Tabs stay.
pub fn pictured(line: &str) -> String {
    line.chars()
        .map(|c| match c {
            '\t' => c,
            '\0'..='\u{1f}' => char::from_u32(0x2400 + c as u32).unwrap_or('\u{fffd}'),
            '\u{7f}' => '\u{2421}',
            _ if is_unprintable(c) => '\u{fffd}',
            _ => c,
        })
        .collect()
}

/// A JSON document in which what cannot be seen is escaped. JSON itself demands
/// it only below U+0020; a terminal obeys more.
pub fn printable_json(document: &str) -> Cow<'_, str> {
    let is_shown = |c: char| !is_unprintable(c) || c == '\n';
    if document.chars().all(is_shown) {
        return Cow::Borrowed(document);
    }
    let mut text = String::with_capacity(document.len());
    for c in document.chars() {
        if is_shown(c) {
            text.push(c);
        } else {
            for unit in c.encode_utf16(&mut [0; 2]) {
                let _ = write!(text, "\\u{unit:04x}");
            }
        }
    }
    Cow::Owned(text)
}

fn escaped(text: &str, must_be: impl Fn(char) -> bool) -> Cow<'_, str> {
    if !text.contains(&must_be) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            _ if !must_be(c) => shown.push(c),
            '\n' => shown.push_str("\\n"),
            '\r' => shown.push_str("\\r"),
            '\t' => shown.push_str("\\t"),
            _ => shown.extend(c.escape_unicode()),
        }
    }
    Cow::Owned(shown)
}

#[cfg(test)]
mod tests {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt as _;

    use super::*;

    #[test]
    fn what_can_be_seen_stays_as_it_is() {
        let text = "größe 场景 \\ \"a\" ~";
        assert_eq!(printable(text), text);
        assert_eq!(printable_lines("a\n\tb"), "a\n\tb");
        assert_eq!(pictured("\ta b"), "\ta b");
    }

    #[test]
    fn what_commands_a_terminal_is_escaped() {
        assert_eq!(printable("a\nb\t\u{1b}[31m"), "a\\nb\\t\\u{1b}[31m");
        // The one-character form of the escape sequence's start, and a mark that
        // turns the direction of reading.
        assert_eq!(printable_lines("\u{9b}2J\u{202e}"), "\\u{9b}2J\\u{202e}");
        assert_eq!(printable_ascii("größe"), "gr\\u{f6}\\u{df}e");
        assert_eq!(pictured("a\u{1b}b\u{85}"), "a\u{241b}b\u{fffd}");
    }

    #[test]
    fn a_word_is_what_a_shell_reads_back() {
        assert_eq!(shell_word("--out"), "--out");
        assert_eq!(shell_word("path.distance=5 m"), "'path.distance=5 m'");
        assert_eq!(shell_word("it's"), r"'it'\''s'");
        assert_eq!(shell_word(""), "''");
    }

    #[test]
    fn bytes_that_are_no_text_are_told_apart() {
        let path = |bytes| printable_path(Path::new(OsStr::from_bytes(bytes)));
        assert_eq!(path(b"a\xffb\n"), "a\\xffb\\n");
        assert_ne!(path(b"a\xff"), path(b"a\xfe"));
    }

    #[test]
    fn json_with_escapes_is_the_same_document() {
        let value = serde_json::json!({ "a": "\u{1b}\u{9b}\u{202e}\u{e0041}\"\\ü" });
        let document = serde_json::to_string_pretty(&value).unwrap();
        let shown = printable_json(&document);
        assert!(!shown.contains(|c| is_unprintable(c) && c != '\n'));
        let read: serde_json::Value = serde_json::from_str(&shown).unwrap();
        assert_eq!(read, value);
    }
}
