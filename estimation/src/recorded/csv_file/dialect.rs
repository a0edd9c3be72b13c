//! How a CSV file is written: encoding, delimiter and decimal sign, as they show in the file itself.
//! RFC 4180 has commas alone; spreadsheets write what their country's settings say.

use std::io;

use serde::Serialize;

use super::Wrong;
use crate::files::utf8_text;

/// What may stand between fields: the characters, and their names.
const DELIMITERS: [(char, &str); 3] = [(',', "comma"), (';', "semicolon"), ('\t', "tab")];
/// A line that begins with it is a comment.
const COMMENT: &str = "#";

/// The dialect of a CSV file.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, schemars::JsonSchema)]
pub struct Dialect {
    /// `UTF-8`, `UTF-16LE` or `UTF-16BE`.
    pub encoding: &'static str,
    /// Whether a byte order mark stands first. UTF-16 must have one.
    pub byte_order_mark: bool,
    /// Name of what stands between fields: `comma`, `semicolon` or `tab`.
    pub delimiter: &'static str,
    /// Whether a line `sep=;`, as spreadsheets write it, names the delimiter; the heading shows it
    /// elsewhere.
    pub delimiter_line: bool,
    /// `.` or `,`; never the delimiter.
    pub decimal_sign: char,
}

/// A text, the name of its encoding, and whether a byte order mark stood first.
pub(super) struct Decoded {
    pub text: String,
    pub encoding: &'static str,
    pub byte_order_mark: bool,
}

/// The text of bytes.
pub(super) fn decoded(bytes: Vec<u8>) -> io::Result<Decoded> {
    let (encoding, byte_order_mark, text) = match bytes.as_slice() {
        [0xff, 0xfe, units @ ..] => ("UTF-16LE", true, utf16_text(units, u16::from_le_bytes)),
        [0xfe, 0xff, units @ ..] => ("UTF-16BE", true, utf16_text(units, u16::from_be_bytes)),
        [0xef, 0xbb, 0xbf, text @ ..] => ("UTF-8", true, utf8_text(text.to_vec())),
        _ => ("UTF-8", false, utf8_text(bytes)),
    };
    let text = text?;
    match text.contains('\0') {
        true => Err(no_text("it has NUL characters, as UTF-16 without a byte order mark has")),
        false => Ok(Decoded { text, encoding, byte_order_mark }),
    }
}

fn no_text(why: &str) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, format!("{why}; save it as UTF-8"))
}

fn utf16_text(bytes: &[u8], unit: fn([u8; 2]) -> u16) -> io::Result<String> {
    let (pairs, rest) = bytes.as_chunks();
    let text = char::decode_utf16(pairs.iter().map(|&pair| unit(pair))).collect();
    let text: Option<String> = Result::ok(text).filter(|_| rest.is_empty());
    text.ok_or_else(|| no_text("its byte order mark is that of UTF-16, and its text is not"))
}

impl Dialect {
    /// The dialect of a text, and the text with line feeds at the ends of its lines, and a line
    /// `sep=;` made a comment.
    pub(super) fn of(decoded: Decoded) -> Result<(Dialect, String), Wrong> {
        let Decoded { text, encoding, byte_order_mark } = decoded;
        let mut text = text.replace("\r\n", "\n").replace('\r', "\n");
        let named = text.lines().next().and_then(named_delimiter);
        if named.is_some() {
            let end = text.find('\n').unwrap_or(text.len());
            text.replace_range(..end, COMMENT);
        }
        let heading = text.lines().find(|line| !is_skipped(line)).unwrap_or_default();
        let is_known = |c: char| DELIMITERS.iter().any(|&(known, _)| known == c);
        let delimiter = named.or_else(|| heading.chars().find(|&c| is_known(c)));
        let words = heading.split(|c: char| !c.is_alphanumeric() && c != '_');
        if delimiter.is_none() && words.filter(|word| !word.is_empty()).count() > 1 {
            let line = 1 + text.lines().take_while(|line| is_skipped(line)).count() as u64;
            let says = "has neither comma, semicolon nor tab between its columns; write one there";
            return Err((line, format!("the heading \"{}\" {says}", heading.trim())));
        }
        let delimiter = delimiter.unwrap_or(',');
        let is_between_digits = |three: &[u8]| {
            three[1] == b',' && three[0].is_ascii_digit() && three[2].is_ascii_digit()
        };
        let has_decimal_commas =
            delimiter != ',' && text.as_bytes().windows(3).any(is_between_digits);
        let name = DELIMITERS.iter().find(|&&(known, _)| known == delimiter);
        let Some(&(_, delimiter)) = name else {
            let says = format!("\"sep={delimiter}\": only a comma, semicolon or tab is read");
            return Err((1, says));
        };
        let decimal_sign = if has_decimal_commas { ',' } else { '.' };
        let delimiter_line = named.is_some();
        let dialect =
            Dialect { encoding, byte_order_mark, delimiter, delimiter_line, decimal_sign };
        Ok((dialect, text))
    }

    /// Reads the records of a text, the first of which is the heading.
    pub(super) fn reader<'t>(&self, text: &'t str) -> csv::Reader<&'t [u8]> {
        let delimiter = DELIMITERS.iter().find(|&&(_, name)| name == self.delimiter);
        csv::ReaderBuilder::new()
            .delimiter(delimiter.map_or(b',', |&(character, _)| character as u8))
            .comment(Some(COMMENT.as_bytes()[0]))
            .trim(csv::Trim::All)
            .from_reader(text.as_bytes())
    }

    /// The value of a field; `None` if it is not a number, or has the other decimal sign.
    pub(super) fn number(&self, field: &str) -> Option<f64> {
        let has_other = field.contains(['.', ',']) && !field.contains(self.decimal_sign);
        let number = field.replacen(self.decimal_sign, ".", 1).parse().ok()?;
        Some(number).filter(|number: &f64| number.is_finite() && !has_other)
    }

    /// The value of a field that is a whole number, `-14.0` too; `None` if a sign may separate groups of
    /// digits.
    pub(super) fn whole(&self, field: &str) -> Option<i128> {
        /// Up to here every whole number is an `f64`.
        const MOST: f64 = (1_u64 << 53) as f64;
        let is_whole = |number: &f64| number.fract() == 0.0 && number.abs() <= MOST;
        let rounded = || self.number(field).filter(is_whole).map(|number| number as i128);
        field.parse().ok().or_else(|| rounded().filter(|_| digits_of_grouped(field).is_none()))
    }

    /// Why a field that looks like a number is refused.
    pub(super) fn doubt(&self, field: &str) -> String {
        if let Some(digits) = digits_of_grouped(field) {
            return format!(", which is {digits} or {digits}000");
        }
        match (self.decimal_sign, field.contains('.'), field.contains(',')) {
            (',', true, _) => ", with a point in a file with decimal commas".to_owned(),
            ('.', _, true) => ", with a comma; a decimal comma takes a semicolon or tab between \
                               fields"
                .to_owned(),
            _ => String::new(),
        }
    }
}

/// Whether a line is neither heading nor row.
pub(super) fn is_skipped(line: &str) -> bool {
    line.is_empty() || line.starts_with(COMMENT)
}

/// The delimiter that a line `sep=;` names.
fn named_delimiter(line: &str) -> Option<char> {
    let line = line.trim_matches(['"', ' ']);
    let (key, value) = line.split_at_checked(4)?;
    value.chars().next().filter(|_| key.eq_ignore_ascii_case("sep="))
}

/// The digits before the sign of a number that is twelve, or twelve thousand, as `12.000`.
fn digits_of_grouped(field: &str) -> Option<&str> {
    let (head, tail) = field.trim_start_matches(['+', '-']).split_once(['.', ','])?;
    let is_group = tail == "000" && (1..=3).contains(&head.len()) && !head.starts_with('0');
    Some(head).filter(|_| is_group)
}
