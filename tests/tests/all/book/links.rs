//! Every chapter is in the summary, and every link leads somewhere. `.ci/release` has mdBook build the
//! book of these chapters.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Component, Path, PathBuf};

use super::{chapters, source};

/// A chapter as a reader sees it: with the page that it includes.
fn text(chapter: &Path) -> String {
    let text = fs::read_to_string(chapter).unwrap();
    let mut out = String::new();
    for line in text.lines() {
        let wanted = line.strip_prefix("{{#include ").and_then(|it| it.strip_suffix("}}"));
        match wanted.filter(|wanted| wanted.ends_with(".md")) {
            Some(wanted) => {
                let page = chapter.parent().unwrap().join(wanted);
                let page = fs::read_to_string(&page)
                    .unwrap_or_else(|why| panic!("{}: {wanted}: {why}", chapter.display()));
                out.push_str(&page);
            }
            None => {
                out.push_str(line);
                out.push('\n');
            }
        }
    }
    out
}

/// The lines outside code blocks.
fn prose(text: &str) -> impl Iterator<Item = &str> {
    let mut code = false;
    text.lines().filter(move |line| {
        let fence = line.trim_start().starts_with("```");
        code ^= fence;
        !code && !fence
    })
}

/// The names of headings, as mdBook makes them.
fn anchors(text: &str) -> BTreeSet<String> {
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    let mut names = BTreeSet::new();
    for heading in prose(text).filter(|line| line.starts_with('#')) {
        let heading = heading.trim_start_matches('#').trim().to_lowercase();
        let name: String = heading
            .chars()
            .filter_map(|letter| match letter {
                ' ' => Some('-'),
                '_' | '-' => Some(letter),
                letter => letter.is_alphanumeric().then_some(letter),
            })
            .collect();
        let count = counts.entry(name.clone()).or_default();
        names.insert(if *count == 0 { name } else { format!("{name}-{count}") });
        *count += 1;
    }
    names
}

/// The addresses of links and pictures, `[WORDS](ADDRESS)`, outside of code.
fn links(text: &str) -> Vec<String> {
    let mut found = Vec::new();
    for line in prose(text) {
        let words: String = line.split('`').step_by(2).collect::<Vec<_>>().join("`");
        for piece in words.split("](").skip(1) {
            found.extend(piece.split(')').next().map(str::to_owned));
        }
    }
    found
}

/// A path without `.` and `..`; `None` if it leaves the book.
fn plain(path: &Path) -> Option<PathBuf> {
    let mut out = PathBuf::new();
    for part in path.components() {
        match part {
            Component::Normal(name) => out.push(name),
            Component::ParentDir if !out.pop() => return None,
            _ => {}
        }
    }
    Some(out)
}

#[test]
fn every_link_of_the_book_leads_somewhere() {
    let texts: BTreeMap<PathBuf, String> = chapters()
        .into_iter()
        .map(|chapter| (chapter.strip_prefix(source()).unwrap().to_owned(), text(&chapter)))
        .collect();
    let anchors: BTreeMap<&PathBuf, BTreeSet<String>> =
        texts.iter().map(|(chapter, text)| (chapter, anchors(text))).collect();
    let (mut wrong, mut seen) = (Vec::new(), 0);
    for (chapter, text) in &texts {
        for link in links(text) {
            if link.starts_with("http") {
                continue;
            }
            seen += 1;
            let (file, anchor) = link.split_once('#').unwrap_or((&link, ""));
            let target = match file {
                "" => Some(chapter.clone()),
                file => plain(&chapter.parent().unwrap().join(file)),
            };
            let there = target.is_some_and(|target| match anchors.get(&target) {
                Some(names) => anchor.is_empty() || names.contains(anchor),
                None => anchor.is_empty() && source().join(&target).is_file(),
            });
            if !there {
                wrong.push(format!("{}: {link}", chapter.display()));
            }
        }
    }
    assert!(wrong.is_empty(), "links that lead nowhere: {wrong:#?}");
    assert!(seen > 80, "{seen} links: are they still found?");
}

#[test]
fn every_chapter_is_in_the_summary() {
    let summary = fs::read_to_string(source().join("SUMMARY.md")).unwrap();
    let missing: Vec<_> = chapters()
        .into_iter()
        .map(|chapter| chapter.strip_prefix(source()).unwrap().display().to_string())
        .filter(|chapter| chapter != "SUMMARY.md" && !summary.contains(&format!("({chapter})")))
        .collect();
    assert!(missing.is_empty(), "chapters that nobody finds: {missing:?}");
}

#[test]
fn pictures_can_be_read_on_a_light_and_on_a_dark_page() {
    let mut pictures = 0;
    for file in fs::read_dir(source().join("pictures")).unwrap() {
        let file = file.unwrap().path();
        let text = fs::read_to_string(&file).unwrap();
        assert!(text.contains("<title>"), "{}: no title", file.display());
        // Lines and words beside boxes have a tone between; boxes bring their own background.
        for colour in ["\"black\"", "\"white\"", "\"#000", "\"#fff"] {
            assert!(!text.contains(colour), "{}: {colour}", file.display());
        }
        pictures += 1;
    }
    assert!(pictures >= 4, "{pictures} pictures");
}
