//! The formatter keeps meaning and comments, and is idempotent.

use std::sync::LazyLock;

use expect_test::{Expect, expect};
use genom_description::{Analysis, Options, read_text};
use genom_description_tools::{FormatError, describe, format_text};
use proptest::prelude::*;

use crate::support::path;

#[track_caller]
fn check(text: &str, formatted: Expect) {
    let once = format_text(text).unwrap();
    formatted.assert_eq(&once);
    assert_eq!(format_text(&once).unwrap(), once, "formatting again changes the text");
}

#[test]
fn indentation_and_blanks_are_normal() {
    check(
        "component   demo{version\"1.0\";\n    lang \"c\" ;\n\n\n\n ids{long a ;struct s{double x,y[ 3 ];}b;};\ntask main{period 5ms;codel<start>init( out ::ids ,in a . b [ 2 ]::c )yield pause::start,ether;\n};};",
        expect![[r#"
            component demo {
              version "1.0";
              lang "c";

              ids { long a; struct s { double x, y[3]; } b; };
              task main {
                period 5ms;
                codel<start> init(out ::ids, in a.b[2]::c) yield pause::start, ether;
              };
            };
        "#]],
    );
}

#[test]
fn comments_and_directives_stay_where_they_are() {
    check(
        "// first\n/* block\n * of stars\n   and not */\n#pragma  require   \"x\"   \n  #define A(x) \\\n   x\ntypedef long a;// after\n\n\n// alone\nstruct s{ // open\nlong a; /* in */ long b;\n// last\n};\n#if A\nstruct t{\n#else\nstruct u{\n#endif\nlong a;\n};\n",
        expect![[r#"
            // first
            /* block
             * of stars
               and not */
            #pragma  require   "x"
            #define A(x) \
               x
            typedef long a; // after

            // alone
            struct s { // open
              long a; /* in */
              long b;
              // last
            };
            #if A
            struct t {
            #else
            struct u {
            #endif
              long a;
            };
        "#]],
    );
}

#[test]
fn lines_of_one_statement_are_kept_and_indented() {
    check(
        "component c {\nfunction f(in long a = 3:\"doc\",\nout s b = {.x=1,\n[2]={1,-2}}) {\ncodel g(in a,\nout b);\n};\nenum e {\nA,\nB\n};\nenum e2 {A,B};\n};\n",
        expect![[r#"
            component c {
              function f(in long a = 3: "doc",
                  out s b = {.x = 1,
                    [2] = {1, -2}}) {
                codel g(in a,
                    out b);
              };
              enum e {
                A,
                B
              };
              enum e2 { A, B };
            };
        "#]],
    );
}

#[test]
fn operators_have_blanks_and_signs_have_none() {
    check(
        "const long a=-1+2*(3-x)<<m::y|~z;\nclock-rate 5 ms;\nconst long b = a -1;\ntypedef sequence<sequence<long,4> > t;\ntypedef sequence< ::m::t> u;\nunion v switch(long){case -1:case 2:long a;default:long b;};",
        expect![[r#"
            const long a = -1 + 2 * (3 - x) << m::y | ~z;
            clock-rate 5 ms;
            const long b = a - 1;
            typedef sequence<sequence<long, 4> > t;
            typedef sequence< ::m::t> u;
            union v switch (long) { case -1: case 2: long a; default: long b; };
        "#]],
    );
}

#[test]
fn what_cannot_be_cut_into_tokens_is_left_alone() {
    let refused = |text: &str| format_text(text).unwrap_err();
    assert_eq!(refused("a\n/* b"), FormatError::Unclosed { line: 2, what: "comment" });
    assert_eq!(refused("a\n\"b"), FormatError::Unclosed { line: 2, what: "string" });
    assert_eq!(refused("a \\\n b"), FormatError::Joined { line: 1 });
    assert_eq!(refused("#define A \\ \nb"), FormatError::Joined { line: 1 });
    assert_eq!(refused("a // b \\ \nc"), FormatError::Joined { line: 1 });
    assert_eq!(refused("a; # b"), FormatError::Stray { line: 1, what: '#' });
    assert_eq!(refused("a ??< b"), FormatError::Joined { line: 1 });
}

/// The meaning of a description, without positions.
fn meaning(analysis: &Analysis) -> Vec<String> {
    let spec = &analysis.specification;
    let mut out: Vec<_> =
        analysis.diagnostics.iter().map(|d| format!("{} {}", d.code, d.message)).collect();
    out.sort();
    out.extend(spec.types.iter().map(|(id, kind)| format!("{} {kind:?}", spec.types.spelling(id))));
    out.extend(spec.constants.iter().map(|c| format!("{} {}", c.name, c.value)));
    out.extend(spec.components.iter().map(|c| describe(spec, c).to_string()));
    out
}

#[test]
fn formatted_descriptions_mean_the_same() {
    let mut formatted = 0;
    for folder in ["../description/tests/cases", "../description/tests/papers", "tests/tools"] {
        for entry in std::fs::read_dir(path(folder)).unwrap() {
            let file = entry.unwrap().path();
            if file.extension().is_none_or(|e| e != "gen") {
                continue;
            }
            let text = std::fs::read_to_string(&file).unwrap();
            let name = file.to_string_lossy();
            let Ok(once) = format_text(&text) else { continue };
            formatted += 1;
            assert_eq!(format_text(&once).unwrap(), once, "{name}: formatting again changes it");
            let before = read_text(&name, &text, &Options::default());
            let after = read_text(&name, &once, &Options::default());
            assert_eq!(meaning(&before), meaning(&after), "{name}");
        }
    }
    assert!(formatted > 90, "only {formatted} descriptions were formatted");
}

fn piece() -> impl Strategy<Value = &'static str> {
    prop::sample::select(vec![
        "component c ",
        "{",
        "}",
        ";",
        ",",
        "(",
        ")",
        "[",
        "]",
        "<",
        ">",
        ">>",
        "<<",
        "::",
        ":",
        "=",
        "-",
        "+",
        "~",
        ".",
        "\n",
        "\n\n\n",
        " ",
        "\t",
        "a",
        "5ms",
        "1",
        "clock-rate",
        "clock",
        "-rate",
        "\"s\"",
        "'c'",
        "// c\n",
        "/* c */",
        "/* a\n * b\n c */",
        "\n#if A\n",
        "\n#else\n",
        "\n#endif\n",
        "\n#define X \\\n y\n",
        "#",
        "enum e",
        "<%",
        "%>",
        "<:",
        ":>",
        "\r\n",
        "\u{e9}",
        "1e",
        "switch",
        "/",
        "*",
        "%",
        "?",
        "!",
        "\\",
    ])
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 3000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_text_is_formatted_once_for_all(pieces in prop::collection::vec(piece(), 0..40)) {
        let text = pieces.concat();
        match format_text(&text) {
            Ok(once) => {
                let twice = format_text(&once);
                prop_assert_eq!(twice.as_deref(), Ok(once.as_str()), "{:?}", text);
            }
            Err(error) => prop_assert_ne!(error, FormatError::Changed, "{:?}", text),
        }
    }
}

/// Small descriptions without strings, comments and directives: all blanks may be changed.
static PLAIN: LazyLock<Vec<String>> = LazyLock::new(|| {
    let mut files: Vec<_> = std::fs::read_dir(path("../description/tests/cases"))
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|file| file.extension().is_some_and(|e| e == "gen"))
        .collect();
    files.sort();
    let texts = files.iter().map(|file| std::fs::read_to_string(file).unwrap());
    texts.filter(|text| !text.contains(['"', '\'', '#', '\\']) && !text.contains("/")).collect()
});

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn however_it_is_written_it_is_formatted_to_the_same_meaning(
        case in any::<prop::sample::Index>(),
        blanks in prop::collection::vec(
            prop::sample::select(vec![" ", "\n", "\n\n\n", "\t", " // c\n", " /* c */ ", "/*\n * c */", "\r\n"]),
            1..40,
        ),
    ) {
        prop_assert!(PLAIN.len() > 40);
        let text = case.get(&PLAIN);
        let mut blanks = blanks.iter().cycle();
        let words: Vec<_> = text.split_whitespace().collect();
        let written: String = words.iter().flat_map(|word| [*word, blanks.next().unwrap_or(&" ")]).collect();
        let once = format_text(&written).unwrap();
        let twice = format_text(&once);
        prop_assert_eq!(twice.as_deref(), Ok(once.as_str()), "{:?}", written);
        let options = Options { standard_interface: false, ..Options::default() };
        let before = meaning(&read_text("a.gen", text, &options));
        prop_assert_eq!(before, meaning(&read_text("a.gen", &once, &options)), "{}", once);
    }
}

/// The formatter skips the same text as `check`.
#[test]
fn what_if_0_leaves_out_need_not_make_sense_and_is_kept() {
    check(
        "#if 0 // later\n   don't   /* #endif\n  */ \"unclosed\n# if X\n a\\\n#endif\n   #else\n#endif\n\t ` \\x ??\n\n #endif\ncomponent   c;\n# if 0\n'\n#else\ntypedef   long a;\n#endif\n",
        expect![[r#"
            #if 0 // later
               don't   /* #endif
              */ "unclosed
            # if X
             a\
            #endif
               #else
            #endif
            	 ` \x ??

            #endif
            component c;
            # if 0
            '
            #else
            typedef long a;
            #endif
        "#]],
    );
    let analysis =
        read_text("x.gen", "#if 0\ndon't \"\n#endif\ncomponent c;\n", &Options::default());
    assert!(!analysis.has_errors(), "{:?}", analysis.diagnostics);
    // Never closed: `check` reports it.
    assert!(format_text("#if 0\n'\n").is_ok());
    assert!(format_text("#if 1\n'\n#endif\n").is_err());
}
