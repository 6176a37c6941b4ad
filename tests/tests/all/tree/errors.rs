//! An error is a type with a case for each thing that can go wrong, not a text: callers tell cases
//! apart, and the cause stays.

use std::collections::BTreeMap;
use std::fs;

use genom_tests::{files, repository};

/// Files where a function may fail with a text, how many do, and why they may.
const TEXTS: &[(&str, usize, &str)] = &[
    ("daemon/genomctl/src/times.rs", 1, "a parser of clap, which prints the text"),
    ("daemon/genomctl/src/verbs/step.rs", 1, "a parser of clap, which prints the text"),
];

#[test]
fn functions_fail_with_errors_and_not_with_texts() {
    let mut found = BTreeMap::new();
    for path in files("rs") {
        let file = path.strip_prefix(repository()).unwrap_or(&path).display().to_string();
        let ours = ["daemon/", "middlewares/", "plugin-api/"];
        if !ours.iter().any(|folder| file.starts_with(folder)) || !file.contains("/src/") {
            continue;
        }
        let text = fs::read_to_string(&path).unwrap();
        let code = text.split("#[cfg(test)]\nmod ").next().unwrap_or_default();
        let count = results_with_text(code) + code.matches("type Err = String;").count();
        if count > 0 {
            found.insert(file, count);
        }
    }
    let wanted = TEXTS.iter().map(|&(file, count, _)| (file.to_owned(), count)).collect();
    assert_eq!(found, wanted, "write an error enum, or say here why a text is enough");
}

/// How many types `Result<_, String>` there are, on one line or on several, within others or not.
fn results_with_text(code: &str) -> usize {
    let types = code.match_indices("Result<").map(|(at, word)| &code[at + word.len()..]);
    types.filter(|rest| second_argument(rest).is_some_and(|one| one.trim() == "String")).count()
}

/// What stands after the first comma between the brackets that `rest` begins within.
fn second_argument(rest: &str) -> Option<&str> {
    let (mut depth, mut comma, mut before) = (0_i32, None, ' ');
    for (at, sign) in rest.char_indices() {
        match sign {
            '<' | '(' | '[' => depth += 1,
            // The end of an arrow closes nothing.
            '>' if before == '-' => {}
            '>' | ')' | ']' if depth == 0 => {
                let all = &rest[comma? + 1..at];
                return Some(all.trim_end().trim_end_matches(','));
            }
            '>' | ')' | ']' => depth -= 1,
            ',' if depth == 0 && comma.is_none() => comma = Some(at),
            ';' | '{' if depth == 0 => return None,
            _ => {}
        }
        before = sign;
    }
    None
}

#[test]
fn a_text_is_found_wherever_the_type_stands() {
    for (code, count) in [
        ("fn a() -> Result<(), String> {", 1),
        ("fn a() -> Result<\n    Vec<(u8, u8)>,\n    String,\n> {", 1),
        ("make: impl FnOnce() -> Result<Arc<T>, String>,", 1),
        ("fn a() -> Option<Result<Box<dyn Fn(u8) -> u8>, String>>", 1),
        ("fn a() -> Result<String, Error>", 0),
        ("fn a() -> io::Result<BTreeMap<String, String>>", 0),
        ("fn a() -> Result<BTreeMap<u8, String>, Error>", 0),
    ] {
        assert_eq!(results_with_text(code), count, "{code}");
    }
}
