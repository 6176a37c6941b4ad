//! Code and tests cite `docs/reference` by section; each cited section exists.

use std::collections::BTreeSet;
use std::path::Path;

use genom_tests::{files, repository};

/// Section numbers of a reference: `7` from `## 7. ...`, `7.5` from `### 7.5 ...`, `A`.
fn sections(reference: &str) -> BTreeSet<String> {
    let text = std::fs::read_to_string(repository().join("docs/reference").join(reference));
    let text = text.expect("the reference is there");
    let headings = text.lines().filter_map(|line| line.strip_prefix('#'));
    let number = |heading: &str| {
        let first = heading.trim_start_matches('#').split_whitespace().next()?;
        Some(first.trim_end_matches('.').to_owned())
    };
    headings.filter_map(number).collect()
}

/// The text right after each `genom3.md ` in a file: `7.5`, `K24`, `appendix`, ...
fn citations(file: &Path, reference: &str) -> Vec<String> {
    let text = std::fs::read_to_string(file).unwrap_or_default();
    let mut after = text.split(reference).skip(1).map(str::to_owned).collect::<Vec<_>>();
    for text in &mut after {
        let cited =
            text.trim_start().split(|c: char| !c.is_ascii_alphanumeric() && c != '.').next();
        *text = cited.unwrap_or_default().trim_end_matches('.').to_owned();
    }
    after
}

#[test]
fn every_section_that_is_cited_exists() {
    let mut seen = 0;
    for reference in ["genom3.md", "dialects.md"] {
        let sections = sections(reference);
        assert!(sections.len() > 2, "{reference} has sections: {sections:?}");
        for file in files("rs") {
            for cited in citations(&file, reference) {
                // A rule of section 3 (K24) or a word is not a section number.
                if !cited.starts_with(|c: char| c.is_ascii_digit()) {
                    continue;
                }
                seen += 1;
                // `7.3.6` is step 6 of 7.3.
                let known = sections.contains(&cited)
                    || cited.rsplit_once('.').is_some_and(|(up, _)| sections.contains(up));
                assert!(known, "{}: {reference} has no section {cited}", file.display());
            }
        }
    }
    assert!(seen > 100, "only {seen} citations were found");
}
