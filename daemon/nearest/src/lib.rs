//! Suggests the name that was probably meant, for unknown names in descriptions, inputs,
//! configurations and command lines.

#![forbid(unsafe_code)]

/// The candidate nearest to `typed`, if it is near enough to be suggested; of several equally near
/// ones, the first. A candidate equal to `typed` is ignored.
///
/// The distance is the number of insertions, deletions, replacements and swaps of adjacent
/// characters, ignoring case. It may be 1, plus 1 for every four characters of the shorter name,
/// and must be less than the length of `typed`.
///
/// ```
/// use genom_nearest::nearest;
///
/// assert_eq!(nearest("set_sped", ["goto", "set_speed"]), Some("set_speed"));
/// assert_eq!(nearest("quit", ["goto", "set_speed"]), None);
/// ```
#[must_use]
pub fn nearest<'a>(typed: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let folded = typed.to_lowercase();
    let length = folded.chars().count();
    candidates
        .into_iter()
        .filter(|candidate| *candidate != typed)
        .filter_map(|candidate| {
            let other = candidate.to_lowercase();
            let distance = strsim::osa_distance(&folded, &other);
            let near = distance <= 1 + length.min(other.chars().count()) / 4 && distance < length;
            near.then_some((distance, candidate))
        })
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, candidate)| candidate)
}

/// The nearest key for an error message of serde about an unknown one: ``unknown field `x`,
/// expected one of `a`, `b` ``. `None` for other messages.
#[must_use]
pub fn nearest_key(message: &str) -> Option<String> {
    let mut quoted = message.split('`').skip(1).step_by(2);
    let unknown = message.starts_with("unknown field").then(|| quoted.next()).flatten()?;
    nearest(unknown, quoted).map(str::to_owned)
}

/// ``did you mean `x`?`` with the [`nearest`] candidate, if there is one.
#[must_use]
pub fn meant<'a>(typed: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<String> {
    nearest(typed, candidates).map(|near| format!("did you mean `{near}`?"))
}

/// ``did you mean `x`?`` with the [`nearest`] candidate, or a list of all candidates.
#[must_use]
pub fn suggest<'a>(typed: &str, candidates: impl IntoIterator<Item = &'a str>) -> String {
    let candidates: Vec<&str> = candidates.into_iter().collect();
    let meant = meant(typed, candidates.iter().copied());
    meant.unwrap_or_else(|| match candidates.is_empty() {
        true => "there is none".to_owned(),
        false => format!("there are: {}", candidates.join(", ")),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slip_is_suggested_and_a_guess_is_not() {
        for (typed, meant) in [
            ("gto", Some("goto")),
            ("set_sped", Some("set_speed")),
            ("Goto", Some("goto")),
            ("ogto", Some("goto")),
            ("quit", None),
            ("x", None),
            ("goto", None),
        ] {
            assert_eq!(nearest(typed, ["goto", "set_speed"]), meant, "{typed}");
        }
        assert_eq!(suggest("quit", ["goto"]), "there are: goto");
        let told = "unknown field `max_bdy`, expected one of `max_body`, `log` at line 1";
        assert_eq!(nearest_key(told).as_deref(), Some("max_body"));
    }
}
