//! ARCHITECTURE.md lists the path of a request, a sample and a description; each stop exists.

use std::fs;

use genom_tests::repository;

const TITLE: &str = "## One request, one sample, one description: where they go";

/// The lists by title, each with its stops: `1. FILE, FUNCTION: what happens there`.
fn ways() -> Vec<(String, Vec<String>)> {
    let text = fs::read_to_string(repository().join("ARCHITECTURE.md")).unwrap();
    let (_, page) = text.split_once(TITLE).expect("ARCHITECTURE.md has the page");
    let page = page.split("\n## ").next().unwrap();
    let mut ways: Vec<(String, Vec<String>)> = Vec::new();
    for line in page.lines() {
        if let Some(title) = line.strip_prefix("**") {
            ways.push((title.to_owned(), Vec::new()));
        } else if line.starts_with(|c: char| c.is_ascii_digit()) {
            let (_, stop) = line.split_once(". ").expect("`1. FILE, FUNCTION: TEXT`");
            ways.last_mut().expect("a title comes before its stops").1.push(stop.to_owned());
        }
    }
    ways
}

/// File and function of a stop, each in backquotes.
fn place(stop: &str) -> (&str, &str) {
    let mut quoted = stop.split('`').skip(1).step_by(2);
    match (quoted.next(), quoted.next()) {
        (Some(file), Some(function)) => (file, function),
        _ => panic!("no file and function in {stop:?}"),
    }
}

#[test]
fn every_stop_of_the_ways_is_a_function_of_a_file_that_exists() {
    let ways = ways();
    assert_eq!(ways.len(), 3, "a request, a sample, a description");
    let mut wrong = Vec::new();
    for (title, stops) in &ways {
        assert!((3..=12).contains(&stops.len()), "{title}: {} stops", stops.len());
        for stop in stops {
            let (file, function) = place(stop);
            let name = function.rsplit("::").next().unwrap();
            match fs::read_to_string(repository().join(file)) {
                Ok(text) => {
                    let said = [format!("fn {name}("), format!("fn {name}<")];
                    if !said.iter().any(|said| text.contains(said.as_str())) {
                        wrong.push(format!("{title}: no function {name} in {file}"));
                    }
                }
                Err(error) => wrong.push(format!("{title}: {file}: {error}")),
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}
