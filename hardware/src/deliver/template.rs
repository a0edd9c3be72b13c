//! Files that stand beside the source as they are written, but for what follows from the design.

/// A template with each `@NAME@` of these in it replaced by its value, in which nothing is replaced.
pub(super) fn filled(template: &str, values: &[(&str, &str)]) -> String {
    let mut text = String::new();
    let mut rest = template;
    while let Some((before, after)) = rest.split_once('@') {
        text += before;
        let found = after.split_once('@').and_then(|(name, behind)| {
            let (_, value) = values.iter().find(|(known, _)| *known == name)?;
            Some((value, behind))
        });
        rest = match found {
            Some((value, behind)) => {
                text += value;
                behind
            }
            None => {
                text.push('@');
                after
            }
        };
    }
    text + rest
}
