//! Phrases of error messages that offer names to choose from.

/// Longest name for which a slip is looked for.
const MOST_CHARACTERS: usize = 64;
/// Most names that are offered.
const MOST_NAMES: usize = 32;

/// The candidate that `name` is most likely a slip for, if any is close.
pub(super) fn nearest<'n>(name: &str, candidates: &[&'n str]) -> Option<&'n str> {
    if name.len() > MOST_CHARACTERS {
        return None;
    }
    let edits = |candidate: &str| strsim::damerau_levenshtein(name, candidate);
    let similarity = |candidate: &str| strsim::jaro_winkler(name, candidate);
    candidates
        .iter()
        .copied()
        .filter(|c| edits(c) <= 1 + c.chars().count() / 4 || similarity(c) > 0.85)
        .max_by(|a, b| similarity(a).total_cmp(&similarity(b)))
}

/// `a`, `a or b`, `a, b or c`; of very many names the first ones.
pub(super) fn alternatives<S: AsRef<str>>(names: &[S]) -> String {
    let names: Vec<&str> = names.iter().map(AsRef::as_ref).collect();
    match names.as_slice() {
        [first @ .., _] if first.len() >= MOST_NAMES => {
            let more = names.len() - MOST_NAMES;
            format!("{} or one of {more} more", first[..MOST_NAMES].join(", "))
        }
        [] => "nothing".to_owned(),
        [only] => (*only).to_owned(),
        [first @ .., last] => format!("{} or {last}", first.join(", ")),
    }
}

/// Each name in quotation marks.
pub(super) fn quoted(names: &[&str]) -> Vec<String> {
    names.iter().map(|name| format!("\"{name}\"")).collect()
}
