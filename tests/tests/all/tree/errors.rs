//! Errors are enums with a variant for each cause, not texts, so that callers can distinguish them
//! and the cause is kept.

use std::collections::BTreeMap;
use std::fs;

use genom_tests::{files, repository};

/// Files in which functions may return an error as text, with their number and the reason.
const TEXTS: &[(&str, usize, &str)] = &[
    ("daemon/comparison/src/floor.rs", 1, "what another program printed, for the report"),
    ("daemon/comparison/src/report/runs.rs", 1, "goes into the report as it is"),
    ("daemon/genomctl/src/apart.rs", 2, "goes into a report as it is"),
    ("daemon/genomctl/src/bench/mod.rs", 3, "goes into the report as it is"),
    ("daemon/genomctl/src/times.rs", 1, "a parser of clap, which prints the text"),
    ("daemon/genomctl/src/verbs/test/mod.rs", 1, "goes into the report as it is"),
    (
        "daemon/genomctl/src/verbs/verify/given.rs",
        5,
        "parsers of clap, which prints the texts; a verdict",
    ),
    ("daemon/genomctl/src/verbs/verify/trace.rs", 1, "a parser of clap, which prints the text"),
    ("daemon/verdicts/src/rules.rs", 1, "a verdict"),
    ("daemon/verdicts/src/told.rs", 2, "a verdict"),
    ("middlewares/yarp/src/admin.rs", 1, "is answered to who asked, on YARP"),
    ("middlewares/yarp/src/inbound.rs", 1, "a command of YARP, not an error"),
    ("middlewares/yarp/src/io/commands.rs", 1, "is answered to who asked, on YARP"),
    ("daemon/genomctl/src/verbs/model.rs", 1, "a parser of clap, which prints the text"),
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

/// Number of types `Result<_, String>`, on one line or several, nested in others or not.
fn results_with_text(code: &str) -> usize {
    let types = code.match_indices("Result<").map(|(at, word)| &code[at + word.len()..]);
    types.filter(|rest| second_argument(rest).is_some_and(|one| one.trim() == "String")).count()
}

/// The text after the first comma at the level at which `rest` begins.
fn second_argument(rest: &str) -> Option<&str> {
    let (mut depth, mut comma, mut before) = (0_i32, None, ' ');
    for (at, sign) in rest.char_indices() {
        match sign {
            '<' | '(' | '[' => depth += 1,
            // The `>` of `->` is not a closing bracket.
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
