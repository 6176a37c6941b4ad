//! `docs/backend.md` shows the example backend's actual code.

use genom_tests::repository;

#[test]
fn what_the_page_on_backends_shows_is_the_text_of_the_example() {
    let read = |path: &str| std::fs::read_to_string(repository().join(path)).unwrap();
    let sources = ["src/lib.rs", "tests/conformance.rs"].map(|file| {
        let path = format!("middlewares/example/{file}");
        read(&path)
    });
    let page = read("docs/backend.md");
    let shown: Vec<&str> = page
        .split("\n```rust\n")
        .skip(1)
        .filter_map(|after| Some(after.split_once("\n```\n")?.0))
        .collect();
    for block in &shown {
        let is_there = sources.iter().any(|source| source.contains(block));
        assert!(is_there, "middlewares/example says otherwise by now:\n{block}");
    }
    // Both directions of a sample, and the test, are on the page.
    for part in ["impl Publisher for", "impl Subscription for", "impl Ports for", "conformance!"] {
        assert!(shown.iter().any(|block| block.contains(part)), "the page shows no `{part}`");
    }
}
