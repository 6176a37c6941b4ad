//! Input files: several, missing, directories, bytes that are not text.

use std::path::PathBuf;

use expect_test::expect;
use genom_text::preprocess::{Options, tokenize};
use genom_text::source::{Disk, Encoding, Files, SourceMap};
use genom_text::token::TokenKind;

use crate::support::Read;

fn read(inputs: &[PathBuf]) -> Read {
    let mut sources = SourceMap::new();
    let (tokens, diagnostics) = tokenize(inputs, &Options::default(), &Disk, &mut sources);
    Read { tokens, diagnostics, sources }
}

#[test]
fn several_inputs_are_one_unit_and_end_once() {
    let dir = tempfile::tempdir().unwrap();
    let inputs = [dir.path().join("a.gen"), dir.path().join("b.gen")];
    std::fs::write(&inputs[0], "#define A 1\na").unwrap();
    std::fs::write(&inputs[1], "A b\n").unwrap();
    let read = read(&inputs);
    assert_eq!((read.tokens().as_str(), read.messages().as_str()), ("a 1 b", ""));
    let ends = read.tokens.iter().filter(|token| token.kind == TokenKind::End);
    let end: Vec<_> = ends.map(|token| read.sources.location(token.span)).collect();
    assert_eq!((end.len(), end[0].basename().as_str(), end[0].column), (1, "b.gen", 4));
}

#[test]
fn missing_files_and_directories_are_errors_and_the_others_are_read() {
    let dir = tempfile::tempdir().unwrap();
    let good = dir.path().join("good.gen");
    std::fs::write(&good, "good").unwrap();
    let read = read(&[dir.path().join("none.gen"), dir.path().to_owned(), good]);
    assert_eq!(read.tokens(), "good");
    let shown = read.messages().replace(&dir.path().display().to_string(), "DIR");
    let name = dir.path().file_name().unwrap().to_string_lossy().into_owned();
    expect![[r#"
        none.gen:1:1: E0120 cannot read `DIR/none.gen`: there is no such file
        NAME:1:1: E0120 cannot read `DIR`: it is a directory, not a file
    "#]]
    .assert_eq(&shown.replace(&name, "NAME"));
}

#[test]
fn no_input_is_no_token() {
    let read = read(&[]);
    assert_eq!((read.tokens.len(), read.diagnostics.len()), (1, 0));
}

#[test]
fn bytes_that_are_no_utf8_are_latin1_and_nothing_is_lost() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.gen");
    let bytes = b"doc \"caf\xe9\"; // \xff\n\xe9";
    std::fs::write(&path, bytes).unwrap();
    let read = read(std::slice::from_ref(&path));
    assert_eq!(read.tokens(), "doc \"caf\u{e9}\" ;");
    expect![[r#"
        a.gen:1:9: W0104 `a.gen` is not UTF-8; it is read as Latin-1
        a.gen:2:1: E0101 stray character `é`
    "#]]
    .assert_eq(&read.messages());
    let (_, file) = read.sources.files().last().unwrap();
    assert_eq!(file.encoding(), Encoding::Latin1);
    assert_eq!(file.encoding().encode(file.text()), bytes);
    assert_eq!(Disk.read(&path).unwrap(), bytes);
}
