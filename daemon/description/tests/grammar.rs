//! The grammar file for editors contains every word of the language.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail them")]

use std::collections::BTreeSet;

use serde_json::Value;

/// genom3.md 2.2: reserved words, then contextual ones but `s`, `ms`, `us`, `k` and `M`.
const WORDS: &str = "module FALSE TRUE unsigned short long fixed float double char wchar string \
    wstring boolean octet object any const enum union switch case default struct sequence optional \
    typedef xor bitand bitor compl not interface component task function activity codel port handle \
    ids attribute doc version lang email require requires codels-require codels-requires clock-rate \
    period delay priority scheduling stack validate yield yields pause throw throws interrupt \
    interrupts before after async extend extends provide provides use uses in out inout local remote \
    multiple real-time native exception";

/// Every alternative between parentheses in the patterns of the grammar.
fn alternatives(value: &Value, out: &mut Vec<String>) {
    match value {
        Value::String(text) => {
            for group in text.split('(').skip(1) {
                let group = group.split(')').next().unwrap_or_default();
                out.extend(group.split('|').map(str::to_owned));
            }
        }
        Value::Array(list) => list.iter().for_each(|part| alternatives(part, out)),
        Value::Object(object) => object.values().for_each(|part| alternatives(part, out)),
        _ => {}
    }
}

#[test]
fn the_grammar_for_editors_knows_every_word() {
    let file =
        concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/editors/vscode/gen.tmLanguage.json");
    let grammar: Value = serde_json::from_str(&std::fs::read_to_string(file).unwrap()).unwrap();
    assert_eq!(grammar["scopeName"], "source.gen");
    let mut known = Vec::new();
    alternatives(&grammar, &mut known);
    let knows = |word: &str| {
        // `requires?` stands for both forms.
        let plural = format!("{word}?");
        let singular = format!("{word}s?");
        known.iter().any(|k| *k == word || *k == plural || *k == singular)
    };
    let missing: Vec<_> = WORDS.split_whitespace().filter(|word| !knows(word)).collect();
    assert!(missing.is_empty(), "docs/editors/vscode/gen.tmLanguage.json lacks {missing:?}");
}

/// Literals in these lines.
fn literals<'a>(lines: impl Iterator<Item = &'a str>) -> BTreeSet<String> {
    lines.flat_map(|line| line.split('"').skip(1).step_by(2)).map(str::to_owned).collect()
}

/// The left sides of a function's `match`, without those of a `match` within it.
fn cases(source: &str, begin: &str) -> BTreeSet<String> {
    let body = source.split_once(begin).unwrap().1.split_once('{').unwrap().1;
    let body = body.split_once("match ").map_or(body, |(_, body)| body);
    let mut lines = body.lines().skip(1).peekable();
    let depth = |line: &str| line.len() - line.trim_start().len();
    let own = depth(lines.peek().unwrap());
    let lines = lines.take_while(|line| depth(line) >= own).filter(|line| depth(line) == own);
    literals(lines.filter_map(|line| line.split_once("=>")).map(|(left, _)| left))
}

/// The words between parentheses in one part of the grammar.
fn part(name: &str) -> BTreeSet<String> {
    let file =
        concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/editors/vscode/gen.tmLanguage.json");
    let grammar: Value = serde_json::from_str(&std::fs::read_to_string(file).unwrap()).unwrap();
    let mut known = Vec::new();
    alternatives(&grammar["repository"][name], &mut known);
    let both = |word: String| match word.strip_suffix("s?") {
        Some(one) => vec![one.to_owned(), format!("{one}s")],
        None => vec![word],
    };
    known.into_iter().flat_map(both).collect()
}

#[test]
fn the_grammar_reserves_the_words_that_the_lexer_reserves_and_no_others() {
    let words = include_str!("../../text/src/lex/words.rs");
    let mut reserved = cases(words, "fn keyword(");
    assert!(reserved.contains("typedef") && reserved.len() > 20, "{reserved:?}");
    reserved.extend(cases(words, "fn word_operator("));
    assert_eq!(part("reserved"), reserved);
}

#[test]
fn the_grammar_knows_every_property_that_the_parser_reads() {
    let properties = cases(include_str!("../src/parse/property.rs"), "fn property(");
    assert!(properties.contains("stack") && properties.len() > 25, "{properties:?}");
    let known = part("word");
    let missing: Vec<_> = properties.difference(&known).collect();
    assert!(missing.is_empty(), "docs/editors/vscode/gen.tmLanguage.json lacks {missing:?}");
}

#[test]
fn every_include_of_the_grammar_leads_somewhere() {
    let file =
        concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/editors/vscode/gen.tmLanguage.json");
    let text = std::fs::read_to_string(file).unwrap();
    let grammar: Value = serde_json::from_str(&text).unwrap();
    let includes = text.split("\"include\": \"#").skip(1).filter_map(|rest| rest.split('"').next());
    let mut seen = 0;
    for name in includes {
        seen += 1;
        assert!(grammar["repository"].get(name).is_some(), "no rule `{name}`");
    }
    assert!(seen > 8);
}
