//! The meaning of every code: the rule, its reason, and an example that violates it.
//!
//! Codes never change their meaning. E01xx to E08xx are errors by group of genom3.md section 3
//! (row N6 is E0206); W0xxx are warnings.

mod codels;
mod components;
mod constants;
mod initializers;
mod lexical;
mod names;
mod pauses;
mod preprocessor;
mod properties;
mod row;
mod services;
mod warnings;

pub use row::Explanation;

const GROUPS: [&[Explanation]; 11] = [
    lexical::ROWS,
    preprocessor::ROWS,
    names::ROWS,
    constants::ROWS,
    components::ROWS,
    properties::ROWS,
    services::ROWS,
    codels::ROWS,
    initializers::ROWS,
    warnings::ROWS,
    pauses::ROWS,
];

/// The meaning of a code; case does not matter.
#[must_use]
pub fn explain(code: &str) -> Option<&'static Explanation> {
    explanations().find(|row| row.code.eq_ignore_ascii_case(code))
}

/// All codes in order.
pub fn explanations() -> impl Iterator<Item = &'static Explanation> {
    GROUPS.into_iter().flatten()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_are_in_order_and_explained() {
        let codes: Vec<_> = explanations().map(|row| row.code).collect();
        let mut sorted = codes.clone();
        sorted.sort_unstable();
        sorted.dedup();
        assert_eq!(codes, sorted);
        for row in explanations() {
            assert!(!row.title.is_empty() && !row.text.is_empty(), "{}", row.code);
            assert_eq!(explain(&row.code.to_lowercase()), Some(row));
        }
        assert_eq!(explain("E9999"), None);
    }

    #[test]
    fn every_code_in_use_is_explained() {
        let own = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
        let mut folders = vec![own.join("src"), own.join("../description/src")];
        let mut missing = std::collections::BTreeSet::new();
        let mut seen = 0;
        while let Some(folder) = folders.pop() {
            for entry in std::fs::read_dir(folder).unwrap() {
                let path = entry.unwrap().path();
                if path.is_dir() {
                    folders.extend(Some(path).filter(|path| !path.ends_with("register")));
                    continue;
                }
                let text = std::fs::read_to_string(path).unwrap();
                let quoted = text.split('"').filter(|word| word.len() == 5);
                let code = |word: &&str| {
                    word.starts_with(['E', 'W']) && word[1..].bytes().all(|b| b.is_ascii_digit())
                };
                for word in quoted.filter(code) {
                    seen += 1;
                    if explain(word).is_none() {
                        missing.insert(word.to_owned());
                    }
                }
            }
        }
        assert!(seen > 20, "the codes of the sources were not found");
        assert!(missing.is_empty(), "add rows to src/diagnostic/register for {missing:?}");
    }
}
