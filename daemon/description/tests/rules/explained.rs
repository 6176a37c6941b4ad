//! The examples of `genomctl explain` cause what they explain.

use genom_description::diagnostic::explanations;

use crate::analyse;

#[test]
fn every_example_makes_its_diagnostic() {
    let mut wrong = Vec::new();
    let mut count = 0;
    for row in explanations().filter(|row| !row.example.is_empty()) {
        count += 1;
        let analysis = analyse(row.example);
        let found: Vec<_> = analysis.diagnostics.iter().map(|d| d.code).collect();
        if !found.contains(&row.code) {
            wrong.push(format!("{}: {found:?} from {}", row.code, row.example));
        }
    }
    assert!(count > 90, "{count}");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
