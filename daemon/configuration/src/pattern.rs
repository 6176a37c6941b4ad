//! Patterns of names, where `*` stands for any run of characters.

/// Whether a text matches a pattern.
#[must_use]
pub fn matches(pattern: &str, text: &str) -> bool {
    let mut pieces = pattern.split('*');
    let first = pieces.next().unwrap_or_default();
    let Some(mut rest) = text.strip_prefix(first) else { return false };
    let Some(last) = pieces.next_back() else { return rest.is_empty() };
    for piece in pieces {
        // Matching the first occurrence is sufficient: it leaves the longest rest for the pieces
        // that follow.
        let Some((_, after)) = rest.split_once(piece) else { return false };
        rest = after;
    }
    rest.ends_with(last)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_star_stands_for_anything() {
        for (pattern, text) in [
            ("*", ""),
            ("*", "demo/kill"),
            ("*/kill", "demo/kill"),
            ("demo/*", "demo/kill"),
            ("d*o/*_*", "demo/set_speed"),
            ("demo/kill", "demo/kill"),
            ("*a*a", "aa"),
        ] {
            assert!(matches(pattern, text), "{pattern} {text}");
        }
        for (pattern, text) in [
            ("demo", "demo/kill"),
            ("*/kill", "demo/kill2"),
            ("demo/*", "demo2/x"),
            ("", "x"),
            ("a*a", "a"),
            ("*a*a", "a"),
        ] {
            assert!(!matches(pattern, text), "{pattern} {text}");
        }
    }
}
