//! The nearest of some names, for suggestions.

/// The candidate nearest to what was typed, if one is near enough to be meant.
#[must_use]
pub fn nearest<'a>(typed: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    candidates
        .into_iter()
        .map(|candidate| (strsim::osa_distance(typed, candidate), candidate))
        .min()
        .filter(|(distance, candidate)| *distance <= (candidate.chars().count() / 3).max(1))
        .map(|(_, candidate)| candidate)
}

/// Serde says ``unknown field `x`, expected one of `a`, `b` ``: the nearest of what it expects.
#[must_use]
pub fn nearest_key(message: &str) -> Option<String> {
    let mut quoted = message.split('`').skip(1).step_by(2);
    let unknown = message.starts_with("unknown field").then(|| quoted.next()).flatten()?;
    nearest(unknown, quoted).map(str::to_owned)
}

/// ``did you mean `x`? ``, or the whole list when nothing is near and the list is short.
#[must_use]
pub fn suggest<'a>(typed: &str, candidates: impl IntoIterator<Item = &'a str>) -> String {
    let candidates: Vec<&str> = candidates.into_iter().collect();
    match nearest(typed, candidates.iter().copied()) {
        Some(near) => format!("did you mean `{near}`?"),
        None if candidates.is_empty() => "there is none".to_owned(),
        None => format!("there are: {}", candidates.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slip_is_suggested_and_a_guess_is_not() {
        assert_eq!(nearest("gto", ["goto", "set_speed"]), Some("goto"));
        assert_eq!(nearest("set_sped", ["goto", "set_speed"]), Some("set_speed"));
        assert_eq!(nearest("quit", ["goto", "set_speed"]), None);
        assert_eq!(suggest("quit", ["goto"]), "there are: goto");
    }
}
