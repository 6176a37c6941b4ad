//! One word a concept: names that were given up do not come back.

use std::fs;

use genom_tests::{files, repository};

/// Names of types, functions and modules that say too little, or say what another word says, and
/// what to write.
const GIVEN_UP: &[(&str, &str)] = &[
    ("Ending", "Outcome"),
    ("ending", "outcome"),
    ("Wiring", "Supervision, or a connection"),
    ("wiring", "connections"),
    ("wires", "connections"),
    ("hosting", "what it does"),
    ("done", "what was done"),
    ("shown", "what is shown, and to whom"),
];
/// Crates of the daemon whose parts talk of the same things.
const CRATES: &[&str] =
    &["configuration", "genomd", "host", "ports", "registry", "runtime", "supervisor"];

#[test]
fn names_that_were_given_up_do_not_come_back() {
    let mut wrong = Vec::new();
    for path in files("rs") {
        let file = path.strip_prefix(repository()).unwrap_or(&path).display().to_string();
        if !CRATES.iter().any(|name| file.starts_with(&format!("daemon/{name}/src/"))) {
            continue;
        }
        for (number, line) in fs::read_to_string(&path).unwrap().lines().enumerate() {
            let given_up = defined(line)
                .and_then(|name| GIVEN_UP.iter().find(|(given_up, _)| *given_up == name));
            if let Some((name, instead)) = given_up {
                wrong.push(format!("{file}:{}: {name}: write {instead}", number + 1));
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// The name that a line defines, if it defines one.
fn defined(line: &str) -> Option<&str> {
    const WORDS: [&str; 7] = ["fn", "struct", "enum", "trait", "type", "mod", "static"];
    if line.trim_start().starts_with("//") {
        return None;
    }
    let mut words = line.split(|c: char| !c.is_ascii_alphanumeric() && c != '_');
    words.find(|word| WORDS.contains(word))?;
    words.next()
}
