//! Conditions, includes, lines, messages and pragmas (genom3.md 1).

use expect_test::{Expect, expect};

use crate::support::{read, read_with};
use genom_text::preprocess::Options;

#[track_caller]
fn check(texts: &[(&str, &str)], tokens: Expect, messages: Expect) {
    let read = read(texts);
    tokens.assert_eq(&read.tokens());
    messages.assert_eq(&read.messages());
}

#[track_caller]
fn gives(text: &str, tokens: Expect) {
    check(&[("a.gen", text)], tokens, expect![""]);
}

#[test]
fn conditions_read_one_group() {
    gives(
        "#define A 2\n#if A == 1\none\n#elif A == 2\ntwo\n#elif A == 2\nagain\n#else\nother\n#endif\n\
         #ifdef A\nyes\n#else\nno\n#endif\n#ifndef A\nno\n#endif\nend",
        expect!["two yes end"],
    );
}

#[test]
fn skipped_groups_may_hold_anything() {
    gives(
        "#if 0\ndon't \" $\n/*\n#endif\n*/\n#if 1\nno\n#else\nno\n#endif\n#error no\n#include \"no\"\n#endif\nend",
        expect!["end"],
    );
}

#[test]
fn expressions_have_the_operators_of_c() {
    for expression in [
        "1 + 2 * 3 == 7",
        "(1 || 1/0) && !(0 && 1/0)",
        "-1 < 0 && -1 > 0u",
        "1 << 4 >> 2 == 4",
        "~0 == -1",
        "0 ? 0 : 1 ? 2 : 0",
        "'a' == 97",
        "undefined == 0",
        "0x10 == 020 && 16UL",
        "defined A && defined(A) && !defined B",
        "A - 1",
        "5 % 3 == 2 && (6 & 3 | 8 ^ 8) == 2",
        "2 <= 2 && 2 >= 2 && 2 != 3",
        "-9223372036854775807 - 1 < 0",
        "F(2) == 3",
    ] {
        let text =
            format!("#define A 2\n#define F(x) x + 1\n#if {expression}\nyes\n#else\nno\n#endif");
        let read = read(&[("a.gen", text.as_str())]);
        assert_eq!((read.tokens().as_str(), read.messages().as_str()), ("yes", ""), "{expression}");
    }
}

// As GenoM3's preprocessor reads it: the part before the first point.
#[test]
fn the_version_of_genom_is_a_number_in_conditions() {
    for (condition, holds) in [
        ("__GENOM__", true),
        ("__GENOM__ >= 2", true),
        ("__GENOM__ == 2", true),
        ("__GENOM__ >= 3", false),
        ("defined __GENOM__ && __GENOM__ < 3", true),
    ] {
        let text = format!("#if {condition}\nyes\n#else\nno\n#endif");
        let read = read(&[("a.gen", text.as_str())]);
        let wanted = if holds { "yes" } else { "no" };
        assert_eq!((read.tokens().as_str(), read.messages().as_str()), (wanted, ""), "{condition}");
    }
}

#[test]
fn a_line_that_begins_with_two_signs_is_passed_over() {
    check(
        &[("a.gen", "a\n##\nb\n  ## \"c d\n## \ne")],
        expect!["a b e"],
        expect![[r##"
            a.gen:2:1: W0105 a line that begins with `##` is ignored
            a.gen:4:3: W0105 a line that begins with `##` is ignored
            a.gen:5:1: W0105 a line that begins with `##` is ignored
        "##]],
    );
}

#[test]
fn expressions_that_make_no_sense_are_refused() {
    check(
        &[(
            "a.gen",
            "#if\n#endif\n#if 1 +\n#endif\n#if 1 2\n#endif\n#if 1/0\n#endif\n#if (1\n#endif\n#if 1.5\n#endif\n#if 0\n#elif 1 ? 2\n#endif\n#ifdef\n#endif",
        )],
        expect![""],
        expect![[r#"
            a.gen:1:2: E0128 in `#if`: a value is expected
            a.gen:3:7: E0128 in `#if`: a value is expected
            a.gen:5:7: E0128 in `#if`: an operator is expected here
            a.gen:7:6: E0128 in `#if`: division by zero
            a.gen:9:6: E0128 in `#if`: `)` is expected
            a.gen:11:5: E0128 in `#if`: `1.5` is not an integer
            a.gen:14:11: E0128 in `#elif`: `:` is expected
            a.gen:16:2: E0123 `#ifdef` must name a macro
        "#]],
    );
}

#[test]
fn unbalanced_conditions_are_refused() {
    check(
        &[(
            "a.gen",
            "#endif\n#else\n#elif 1\n#if 1\n#else\n#else\n#endif\n#if 0\n#else\n#elif 1\n#endif\n#if 1\nx",
        )],
        expect!["x"],
        expect![[r#"
            a.gen:1:1: E0129 `#endif` without `#if`
            a.gen:2:1: E0129 `#else` without `#if`
            a.gen:3:1: E0129 `#elif` without `#if`
            a.gen:6:1: E0129 `#else` after `#else`
            a.gen:10:1: E0129 `#elif` after `#else`
            a.gen:12:1: E0129 this condition is never closed
        "#]],
    );
}

#[test]
fn quoted_names_are_looked_for_beside_the_including_file_first() {
    let texts = [
        ("d/a.gen", "#include \"b.gen\"\n#include <b.gen>\n#include \"e/f.gen\""),
        ("d/b.gen", "beside"),
        ("i/b.gen", "on_path"),
        ("d/e/f.gen", "#include \"g.gen\""),
        ("d/e/g.gen", "deep"),
    ];
    let options = Options { include_dirs: vec!["none".into(), "i".into()], ..Options::default() };
    let read = read_with(&texts, &options);
    assert_eq!((read.tokens().as_str(), read.messages().as_str()), ("beside on_path deep", ""));
}

#[test]
fn angles_do_not_look_beside_the_including_file() {
    check(
        &[("a.gen", "#include <b.gen>\n#include \"c.gen\"\nend"), ("b.gen", "no")],
        expect!["end"],
        expect![[r#"
            a.gen:1:10: E0121 cannot find `b.gen`
            a.gen:2:10: E0121 cannot find `c.gen`
        "#]],
    );
}

#[test]
fn names_of_files_may_come_from_macros() {
    check(
        &[
            ("a.gen", "#define F \"b.gen\"\n#include F\n#define X(n) <n.gen>\n#include X(b)"),
            ("b.gen", "b"),
        ],
        expect!["b"],
        expect![[r#"
            a.gen:4:10: E0121 cannot find `b.gen`
        "#]],
    );
}

#[test]
fn an_include_without_a_name_is_refused() {
    check(
        &[("a.gen", "#include\n#include b\n#include <b\n#include \"\"\nend")],
        expect!["end"],
        expect![[r#"
            a.gen:1:2: E0123 `#include` must name a file
            a.gen:2:10: E0123 `#include` must name a file
            a.gen:3:10: E0123 `#include` must name a file
            a.gen:4:10: E0123 `#include` must name a file
        "#]],
    );
}

#[test]
fn a_file_that_includes_itself_is_refused_once() {
    check(
        &[
            ("a.gen", "#include \"b.gen\"\na"),
            ("b.gen", "#include \"a.gen\"\n#include \"a.gen\"\nb"),
        ],
        expect![""],
        expect![[r#"
            b.gen:1:10: E0122 files include each other without end: a.gen -> b.gen -> a.gen
        "#]],
    );
}

#[test]
fn pragma_once_and_guards_stop_the_second_reading() {
    check(
        &[
            (
                "a.gen",
                "#include \"b.gen\"\n#include \"./b.gen\"\n#include \"c.gen\"\n#include \"c.gen\"",
            ),
            ("b.gen", "#pragma once\n#include \"a.gen\"\nb"),
            ("c.gen", "#ifndef C\n#define C\nc\n#endif"),
        ],
        expect!["c b"],
        expect![""],
    );
}

#[test]
fn the_include_chain_of_a_place_is_known() {
    let read = read(&[
        ("a.gen", "\n#include \"b.gen\""),
        ("b.gen", "#include \"c.gen\""),
        ("c.gen", "\n$"),
    ]);
    let span = read.diagnostics[0].span;
    let place = |span| {
        let place = read.sources.location(span);
        format!("{}:{}", place.basename(), place.line)
    };
    let chain: Vec<_> = read.sources.include_chain(span).map(place).collect();
    assert_eq!(
        (place(span).as_str(), chain),
        ("c.gen:2", vec!["b.gen:1".to_owned(), "a.gen:2".to_owned()])
    );
}

#[test]
fn error_and_warning_say_their_text() {
    check(
        &[("a.gen", "#error don't \"do\" this // really\n#warning careful\n#error\nend")],
        expect!["end"],
        expect![[r#"
            a.gen:1:2: E0130 don't "do" this
            a.gen:2:2: W0102 careful
            a.gen:3:2: E0130 #error
        "#]],
    );
}

#[test]
fn line_directives_and_markers_move_lines() {
    check(
        &[(
            "a.gen",
            "#line 10\n$\n# 20 \"b.gen\" 1 3\n$\n#line 30 \"c.gen\"\n__LINE__ __FILE__ $\n#line x\n# 3 x y\n",
        )],
        expect![[r#"30 "c.gen""#]],
        expect![[r#"
            a.gen:10:1: E0101 stray character `$`
            b.gen:20:1: E0101 stray character `$`
            c.gen:30:19: E0101 stray character `$`
            c.gen:31:2: E0123 this line directive cannot be understood
        "#]],
    );
}

#[test]
fn a_line_marker_of_zero_means_the_first_line() {
    check(
        &[("a.gen", "# 0 \"b.gen\"\n$")],
        expect![""],
        expect![[r#"
            b.gen:1:1: E0101 stray character `$`
        "#]],
    );
}

#[test]
fn joined_lines_and_trigraphs_are_understood_everywhere() {
    check(
        &[("a.gen", "#def\\\nine A 1 \\\n + 2\nA comp\\\nonent ??<??>\n??=define B 3\nB $")],
        expect!["1 + 2 component { } 3"],
        expect![[r#"
            a.gen:7:3: E0101 stray character `$`
        "#]],
    );
}

#[test]
fn unknown_directives_are_dropped_with_a_hint() {
    check(
        &[("a.gen", "#\n#ident \"x\"\n#inlcude \"b\"\n#xyzzy don't\nend # x")],
        expect!["end x"],
        expect![[r#"
            a.gen:3:2: W0105 unknown directive `#inlcude` is ignored
            a.gen:4:2: W0105 unknown directive `#xyzzy` is ignored
            a.gen:5:5: E0101 stray character `#`
        "#]],
    );
}

#[test]
fn pragmas_come_with_their_words() {
    check(
        &[(
            "a.gen",
            "a\n#pragma provides i j // k\n#pragma provide k\n#pragma masquerade ros2 ::m::t geometry_msgs/msg/Pose\n#pragma masquerade \"x y\"z\n#pragma pack 1\n#pragma\nb _Pragma(\"provides \\\"i\\\"\") c",
        )],
        expect![
            "a #provides <i> <j> #provides <k> #masquerade <ros2> <::m::t> <geometry_msgs/msg/Pose> #masquerade <x y> <z> b #provides <i> c"
        ],
        expect![""],
    );
}

#[test]
fn a_malformed_pragma_operator_is_refused() {
    check(
        &[(
            "a.gen",
            "_Pragma(x) a\n#pragma requires\n#pragma requires a b c d e f g h i\n#pragma requires --x",
        )],
        expect!["a #requires  #requires <a> <b> <c> <d> <e> <f> <g> <h> <i> #requires <--x>"],
        expect![[r#"
            a.gen:1:1: E0132 `_Pragma` takes one string
            a.gen:2:9: E0132 `#pragma requires` takes 1 to 8 packages, 0 given
            a.gen:3:9: E0132 `#pragma requires` takes 1 to 8 packages, 9 given
            a.gen:4:18: E0132 `--x` is no name of a package
        "#]],
    );
}
