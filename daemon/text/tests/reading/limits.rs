//! Hostile inputs: no panic, no hang, no quadratic time; limits are reported as errors.

use std::fmt::Write;
use std::time::{Duration, Instant};

use expect_test::{Expect, expect};
use genom_text::token::TokenKind;
use proptest::prelude::*;

use crate::support::read;

#[track_caller]
fn refuses(text: &str, messages: Expect) {
    messages.assert_eq(&read(&[("a.gen", text)]).messages());
}

#[test]
fn a_macro_bomb_is_refused() {
    let mut text = String::from("#define x0 x\n");
    for rank in 1..60 {
        writeln!(text, "#define x{rank} x{0} x{0}", rank - 1).unwrap();
    }
    text.push_str("x59\n");
    refuses(
        &text,
        expect![[r#"
            a.gen:61:1: E0127 macros expand to more than 1048576 tokens
        "#]],
    );
    let twice = "#define f(x) x x\n".to_owned() + &"f(".repeat(60) + "y" + &")".repeat(60);
    refuses(
        &twice,
        expect![[r#"
            a.gen:2:83: E0127 macros expand to more than 1048576 tokens
        "#]],
    );
}

#[test]
fn deep_nesting_is_refused() {
    let arguments = "#define f(x) x\n".to_owned() + &"f(".repeat(1000) + &")".repeat(1000);
    refuses(
        &arguments,
        expect![[r#"
            a.gen:2:201: E0127 macro arguments are nested more than 100 deep
        "#]],
    );
    for open in ["(", "-", "!"] {
        let condition = format!("#if {}\n#endif", open.repeat(100_000));
        let read = read(&[("a.gen", condition.as_str())]);
        assert!(read.messages().contains("nested more than 100 deep"), "{}", read.messages());
    }
}

#[test]
fn a_fan_of_includes_is_refused() {
    let names: Vec<_> = (0..40).map(|rank| format!("{rank}.gen")).collect();
    let lines: Vec<_> = (1..41).map(|n| format!("#include \"{n}.gen\"\n").repeat(2)).collect();
    let mut texts: Vec<_> =
        names.iter().map(String::as_str).zip(lines.iter().map(String::as_str)).collect();
    texts.push(("40.gen", "x"));
    let read = read(&texts);
    assert_eq!(read.diagnostics.len(), 1);
    assert!(read.messages().ends_with("E0122 more than 65536 files are included\n"));
}

/// Compares the time for a text of `n` pieces with that for `8 n`: far below 64 times as long.
#[track_caller]
fn is_linear(what: &str, text: impl Fn(usize) -> String) {
    let time = |n| {
        let text = text(n);
        let start = Instant::now();
        read(&[("a.gen", text.as_str())]);
        start.elapsed()
    };
    // The fastest of several runs: other work on the machine only adds time.
    let (mut short, mut long) = (time(2000), time(16_000));
    let linear = |short: Duration, long: Duration| long < short * 30 + Duration::from_millis(20);
    for _ in 0..10 {
        if linear(short, long) {
            return;
        }
        (short, long) = (short.min(time(2000)), long.min(time(16_000)));
    }
    panic!("{what}: {short:?} for 2000 pieces, {long:?} for 16000");
}

#[test]
fn reading_takes_linear_time() {
    is_linear("names", |n| "abc 12ms \"x\" ;\n".repeat(n));
    is_linear("quotes", |n| "\"a\\\"\n".repeat(n));
    is_linear("escaped quotes", |n| "\\\"".repeat(n));
    is_linear("lone quotes", |n| "' ".repeat(n));
    is_linear("long strings", |n| "\"\n\" ".repeat(n));
    is_linear("conditions", |n| "#if 1\n".repeat(n) + &"#endif\n".repeat(n));
    is_linear("skipped conditions", |n| "#if 0\n".repeat(n) + &"#endif\n".repeat(n));
    is_linear("definitions", |n| (0..n).map(|i| format!("#define m{i} m{}\n", i + 1)).collect());
    is_linear("stray", |n| "$ ".repeat(n));
    is_linear("joined lines", |n| "a\\\n".repeat(n));
    is_linear("one long line", |n| "$a".repeat(n));
    is_linear("uses", |n| "#define f(x) (x)\n".to_owned() + &"f(1)\n".repeat(n));
    is_linear("open comments", |n| "/*".repeat(n));
    is_linear("line marks", |n| "#line 3\nx\n".repeat(n));
}

/// Pieces of text that interact in unusual ways.
fn piece() -> impl Strategy<Value = String> {
    let fixed = prop::sample::select(vec![
        "#",
        "##",
        "\n",
        "\n#define ",
        "\n#define f(x) ",
        "f(",
        ")",
        ",",
        "(",
        "x",
        "f",
        "__VA_ARGS__",
        "...",
        "\n#if ",
        "\n#elif ",
        "\n#else\n",
        "\n#endif\n",
        "\n#include ",
        "\"a.gen\"",
        "<a.gen>",
        "\n#undef f\n",
        "\n#pragma once\n",
        "\n#pragma provides x\n",
        "_Pragma(\"x\")",
        "defined ",
        "\\\n",
        "??/",
        "??=",
        "\"",
        "'",
        "/*",
        "*/",
        "//",
        "\\",
        " ",
        "1",
        "0x",
        "5us",
        "1e",
        ".",
        "-",
        "::",
        "<:",
        "clock-rate",
        "clock",
        "-rate",
        "\u{e9}",
        "\0",
        "\r\n",
        "\n#line 3 \"b\"\n",
        "\n# 3\n",
        "__LINE__",
        "__FILE__",
        "\n#error ",
        "?",
        ":",
        "&&",
        "||",
        "/",
        "%",
        "\n#ifdef x\n",
        "\u{feff}",
        "08",
        "9d",
    ]);
    prop_oneof![4 => fixed.prop_map(str::to_owned), 1 => any::<char>().prop_map(String::from)]
}

fn holds(bytes: &[u8]) -> Result<(), TestCaseError> {
    use genom_text::preprocess::{Options, tokenize};
    let mut files = genom_text::source::Memory::new();
    files.insert("a.gen", bytes);
    let mut sources = genom_text::source::SourceMap::new();
    let inputs = ["a.gen".into()];
    let (tokens, diagnostics) = tokenize(&inputs, &Options::default(), &files, &mut sources);
    let ends = tokens.iter().filter(|token| token.kind == TokenKind::End).count();
    prop_assert_eq!(ends, 1);
    prop_assert!(matches!(tokens.last(), Some(token) if token.kind == TokenKind::End));
    let spans = tokens.iter().map(|token| token.span).chain(diagnostics.iter().map(|d| d.span));
    for span in spans {
        let file = sources.file(span.file).ok_or_else(|| TestCaseError::fail("no such file"))?;
        prop_assert!(span.start <= span.end, "{span:?}");
        prop_assert!(file.text().get(span.start as usize..span.end as usize).is_some(), "{span:?}");
        prop_assert!(sources.location(span).line > 0);
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_pieces_are_read_without_panic(pieces in prop::collection::vec(piece(), 0..60)) {
        holds(pieces.concat().as_bytes())?;
    }

    #[test]
    fn any_bytes_are_read_without_panic(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        holds(&bytes)?;
    }
}
