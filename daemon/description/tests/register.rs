//! The register of codes: each example causes the diagnostic that it stands for.

use genom_description::diagnostic::{explain, explanations, render};
use genom_description::{Options, read_text};

#[test]
fn every_example_makes_its_diagnostic() {
    let mut wrong = String::new();
    let mut examples = 0;
    for row in explanations().filter(|row| !row.example.is_empty()) {
        examples += 1;
        let analysis = read_text("example.gen", row.example, &Options::default());
        if !analysis.diagnostics.iter().any(|d| d.code == row.code) {
            let said = render::short(&analysis.diagnostics, &analysis.sources);
            wrong.push_str(&format!("{}: {}\n{said}\n", row.code, row.example));
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
    assert!(examples > 90, "only {examples} examples");
}

#[test]
fn a_code_is_found_whatever_its_case() {
    assert_eq!(explain("e0206").map(|row| row.rule), Some("N6"));
    assert_eq!(explain("E0000"), None);
}
