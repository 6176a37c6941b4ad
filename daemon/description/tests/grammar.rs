//! The grammar file for editors contains every word of the language.

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
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/editors/gen.tmLanguage.json");
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
    assert!(missing.is_empty(), "docs/editors/gen.tmLanguage.json lacks {missing:?}");
}

#[test]
fn every_include_of_the_grammar_leads_somewhere() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/editors/gen.tmLanguage.json");
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
