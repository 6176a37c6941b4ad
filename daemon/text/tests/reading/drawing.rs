//! Diagnostics as shown to people and editors.

use expect_test::{Expect, expect};
use genom_text::diagnostic::{Diagnostic, Rest, render};
use genom_text::source::SourceMap;
use genom_text::source::Span;

use crate::support::{Read, read};

#[track_caller]
fn draws(texts: &[(&str, &str)], picture: Expect) {
    let read = read(texts);
    picture.assert_eq(&render::human(&read.diagnostics, &read.sources, false));
}

#[test]
fn the_source_line_is_drawn_with_label_and_help() {
    draws(
        &[("d/a.gen", "component c {\n\ttask main { period 500us; };\n};\n")],
        expect![[r#"
            warning[W0101]: `500us` is read as 500 microseconds
             --> d/a.gen:2:21
              |
            2 |     task main { period 500us; };
              |                        ^^^^^ GenoM3 2.99 reads 500 s here
              |
              = help: write `500 us` for the same meaning everywhere
        "#]],
    );
}

#[test]
fn the_include_chain_is_told() {
    draws(
        &[
            ("a.gen", "\n#include \"b.gen\"\n"),
            ("b.gen", "#include \"c.gen\""),
            ("c.gen", "typedef $long t;\n"),
        ],
        expect![[r#"
            error[E0101]: stray character `$`
             --> c.gen:1:9
              |
            1 | typedef $long t;
              |         ^ it has no meaning here
              |
              = note: in file included from b.gen:1
                      included from a.gen:2
        "#]],
    );
}

#[test]
fn other_places_are_drawn_near_or_apart() {
    let far =
        "#define A 1\n".to_owned() + &"\n".repeat(40) + "#define A 2\n#define B\n#define B 1\n";
    draws(
        &[("a.gen", &far)],
        expect![[r#"
        warning[W0103]: macro `A` is redefined
          --> a.gen:42:9
           |
        42 | #define A 2
           |         ^
           |
          ::: a.gen:1:9
           |
         1 | #define A 1
           |         - first defined here
           |
           = help: write `#undef A` before, if this is meant

        warning[W0103]: macro `B` is redefined
          --> a.gen:44:9
           |
        43 | #define B
           |         - first defined here
        44 | #define B 1
           |         ^
           |
           = help: write `#undef B` before, if this is meant
    "#]],
    );
}

#[test]
fn a_mistake_in_a_macro_tells_the_macro() {
    draws(
        &[("a.gen", "#define PERIOD 5us\nperiod PERIOD;\n")],
        expect![[r#"
        warning[W0101]: `5us` is read as 5 microseconds
         --> a.gen:2:8
          |
        2 | period PERIOD;
          |        ^^^^^^ GenoM3 2.99 reads 5 s here
          |
          = note: in the expansion of macro `PERIOD`, defined at a.gen:1
          = help: write `5 us` for the same meaning everywhere
    "#]],
    );
}

#[test]
fn short_lines_are_for_build_tools_and_echoes_are_dropped() {
    let read =
        read(&[("d/a.gen", "#include \"b.gen\"\n#include \"b.gen\"\n$"), ("d/b.gen", "$ 5us")]);
    expect![[r#"
        d/b.gen:1:1: error: stray character `$` [E0101]
        d/b.gen:1:3: warning: `5us` is read as 5 microseconds [W0101]
        d/a.gen:3:1: error: stray character `$` [E0101]
    "#]]
    .assert_eq(&render::short(&read.diagnostics, &read.sources));
}

#[test]
fn json_is_one_document_for_editors() {
    let read =
        read(&[("a.gen", "#include \"b.gen\"\n#define X 1\n#define X 2"), ("b.gen", "\u{e9}")]);
    expect![[r#"
        {
          "errors": 1,
          "warnings": 1,
          "diagnostics": [
            {
              "code": "E0101",
              "severity": "error",
              "message": "stray character `é`",
              "file": "b.gen",
              "line": 1,
              "column": 1,
              "end_line": 1,
              "end_column": 2,
              "label": "it has no meaning here",
              "notes": [],
              "included_from": [
                {
                  "file": "a.gen",
                  "line": 1,
                  "column": 10,
                  "end_line": 1,
                  "end_column": 17
                }
              ],
              "help": null
            },
            {
              "code": "W0103",
              "severity": "warning",
              "message": "macro `X` is redefined",
              "file": "a.gen",
              "line": 3,
              "column": 9,
              "end_line": 3,
              "end_column": 10,
              "notes": [
                {
                  "file": "a.gen",
                  "line": 2,
                  "column": 9,
                  "end_line": 2,
                  "end_column": 10,
                  "message": "first defined here"
                }
              ],
              "included_from": [],
              "help": "write `#undef X` before, if this is meant"
            }
          ]
        }
    "#]]
    .assert_eq(&render::json(&read.diagnostics, Rest::default(), &read.sources));
}

#[test]
fn colours_are_only_added_around_the_same_text() {
    let read = read(&[("a.gen", "5us $")]);
    let plain = render::human(&read.diagnostics, &read.sources, false);
    let coloured = render::human(&read.diagnostics, &read.sources, true);
    assert!(coloured.contains("\u{1b}[") && !plain.contains("\u{1b}["));
    assert!(coloured.contains("E0101") && plain.contains("E0101"));
}

#[test]
fn any_place_can_be_drawn() {
    let long = "x".repeat(10_000);
    let Read { mut sources, .. } = read(&[("a.gen", &long)]);
    let mut diagnostics = Vec::new();
    for (start, end) in [(0, 0), (0, 10_000), (10_000, 10_000), (20_000, 30_000)] {
        let span = Span { file: 2, start, end };
        diagnostics.push(Diagnostic::error("E0101", span, "x").note(span, "y"));
    }
    diagnostics.push(Diagnostic::error("E0101", Span { file: 99, start: 1, end: 2 }, "z"));
    let draw = |sources: &SourceMap| {
        let picture = render::human(&diagnostics, sources, false);
        assert!(picture.len() < 4000, "{}", picture.len());
        assert!(render::short(&diagnostics, sources).contains("z [E0101]"));
        assert!(render::json(&diagnostics, Rest::default(), sources).contains("\"errors\": 5"));
    };
    draw(&sources);
    sources = SourceMap::new();
    draw(&sources);
}
