//! Code in the chapters is that of files which tests build and run; configurations are accepted.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use genom_tests::{Home, Running, files, program, repository};

use super::chapters;

/// Languages whose blocks are taken from files, as `{{#include FILE:ANCHOR}}`.
const CODE: [&str; 7] = ["c", "c++", "rust", "python", "gen", "cmake", "xml"];

/// Languages of blocks that are text on the page: sessions are run (`sessions`), commands are run or
/// named with the reason why not (`tree::printed`), configurations are read below.
const TEXT: [&str; 4] = ["console", "sh", "text", "toml"];

/// The blocks of a page: language and text.
fn blocks(page: &str) -> Vec<(String, String)> {
    let mut found = Vec::new();
    let mut lines = page.lines();
    while let Some(line) = lines.next() {
        let Some(language) = line.strip_prefix("```") else { continue };
        let block: Vec<&str> = lines.by_ref().take_while(|line| *line != "```").collect();
        found.push((language.to_owned(), block.join("\n")));
    }
    found
}

fn written(chapter: &Path) -> bool {
    !chapter.components().any(|part| part.as_os_str() == "reference")
}

#[test]
fn code_on_the_pages_is_that_of_files_which_are_there() {
    let mut wrong = Vec::new();
    let mut included = 0;
    for chapter in chapters().into_iter().filter(|chapter| written(chapter)) {
        let page = fs::read_to_string(&chapter).unwrap();
        for (language, text) in blocks(&page) {
            let told = format!("{}: a block in `{language}`", chapter.display());
            if TEXT.contains(&language.as_str()) && !text.starts_with("{{#include") {
                continue;
            }
            let known = CODE.contains(&language.as_str()) || TEXT.contains(&language.as_str());
            if !known {
                wrong.push(format!("{told}: no such language"));
                continue;
            }
            for line in text.lines() {
                match part(&chapter, line) {
                    Ok(()) => included += 1,
                    Err(why) => wrong.push(format!("{told}: {why}")),
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
    assert!(included > 10, "{included} parts of files are shown: are they still found?");
}

/// Checks a line of a block: an include of a part that exists.
fn part(chapter: &Path, line: &str) -> Result<(), String> {
    let wanted = line.strip_prefix("{{#include ").and_then(|it| it.strip_suffix("}}"));
    let wanted = wanted.ok_or_else(|| format!("not from a file: {line}"))?;
    let (file, anchor) = wanted.split_once(':').map_or((wanted, None), |(f, a)| (f, Some(a)));
    let file = chapter.parent().unwrap().join(file);
    let text = fs::read_to_string(&file).map_err(|why| format!("{}: {why}", file.display()))?;
    let marks = |anchor: &str| {
        ["ANCHOR: ", "ANCHOR_END: "].iter().all(|mark| {
            let mark = format!("{mark}{anchor}");
            text.lines().any(|line| {
                line.split_once(&mark).is_some_and(|(_, rest)| {
                    !rest.starts_with(|c: char| c.is_alphanumeric() || c == '_')
                })
            })
        })
    };
    match anchor {
        Some(anchor) if !marks(anchor) => Err(format!("{}: no {anchor}", file.display())),
        _ => Ok(()),
    }
}

#[test]
fn configurations_and_scenarios_on_the_pages_are_accepted() {
    let mut read = 0;
    for chapter in chapters() {
        let page = fs::read_to_string(&chapter).unwrap();
        for (_, text) in blocks(&page).into_iter().filter(|(language, _)| language == "toml") {
            let manifest = ["[lib]", "[dependencies]"].iter().any(|it| text.contains(it));
            if text.starts_with("{{#include") || manifest {
                continue;
            }
            let home = Home::new();
            let file = home.path().join("page.toml");
            fs::write(&file, &text).unwrap();
            let (name, words) = match text.contains("[[scenario]]") {
                true => ("genomctl", ["test", "--list"]),
                false => ("genomd", ["--dump-config", "--config"]),
            };
            let mut command = Command::new(program(name));
            command.env_clear().args(words).arg(&file);
            let finished = Running::start(&mut command).finish();
            assert_eq!(
                finished.code,
                Some(0),
                "{}: this is refused:\n{text}\n{}",
                chapter.display(),
                finished.err
            );
            read += 1;
        }
    }
    assert!(read > 3, "{read} configurations were read: are they still found?");
}

/// The files of the examples with this ending.
fn examples(extension: &str) -> Vec<PathBuf> {
    let below = repository().join("docs/book/examples");
    files(extension).into_iter().filter(|file| file.starts_with(&below)).collect()
}

#[test]
fn descriptions_of_the_examples_have_no_mistakes() {
    let descriptions = examples("gen");
    assert!(descriptions.len() >= 3, "{descriptions:?}");
    for description in descriptions {
        for check in [&["check", "--deny-warnings"][..], &["fmt", "--check"]] {
            let mut command = Command::new(program("genomctl"));
            command.env_clear().args(check).arg(&description);
            Running::start(&mut command).finish().expect_code(0);
        }
    }
}
