//! `genomctl lsp`, black box: a scripted editor over standard input and output.

use std::process::Command;

use genom_tests::program;
use serde_json::{Value, json};

use super::client::{Client, position, uri};

const ARM: &str = "#include \"types.gen\"\ncomponent arm {\n  doc \"\u{1f916}\"; port out point tip { doc \"Where it is.\"; };\n  task main { period 10 ms; };\n  activity go(in point goal) { task main; codel<start> arm_go(in goal, out tip) yield ether; };\n};\n";
const TYPES: &str = "struct point { double x; double y; };\n";

fn room() -> tempfile::TempDir {
    let room = tempfile::tempdir().unwrap();
    std::fs::write(room.path().join("types.gen"), TYPES).unwrap();
    room
}

/// A server with these arguments, and initialization options of the editor.
fn server(arguments: &[&str], options: &Value) -> (Client, Value) {
    let mut command = Command::new(program("genomctl"));
    Client::start(command.arg("lsp").args(arguments), json!({"initializationOptions": options}))
}

fn start() -> Client {
    server(&[], &Value::Null).0
}

#[test]
fn the_server_says_what_it_can_and_ends_well() {
    let (client, hello) = server(&["--stdio"], &Value::Null);
    let can = &hello["capabilities"];
    for provider in [
        "hoverProvider",
        "definitionProvider",
        "referencesProvider",
        "documentSymbolProvider",
        "documentFormattingProvider",
    ] {
        assert_eq!(can[provider], true, "{provider}");
    }
    assert!(can["completionProvider"].is_object());
    assert!(client.stop().success());
}

#[test]
fn an_editor_that_dies_takes_the_server_with_it() {
    assert!(start().end().success());
    let mut rude = start();
    rude.tell("exit", Value::Null);
    assert!(!rude.end().success(), "an exit without shutdown is a failure");
}

#[test]
fn mistakes_are_told_when_a_text_is_opened_and_go_when_they_are_corrected() {
    let room = room();
    let file = room.path().join("arm.gen");
    let mut editor = start();
    editor.open(&file, &ARM.replace("in point goal", "in piont goal"));
    assert_eq!(
        editor.diagnostics(&file),
        ["4:17 E0206 unknown type `piont`\nhelp: did you mean `point`?"]
    );
    editor.change(&file, 2, ARM);
    assert_eq!(editor.diagnostics(&file), [""; 0]);
    // Columns count UTF-16 units: the emoji before counts two.
    editor.change(&file, 3, &ARM.replace("point tip", "nothing tip"));
    assert_eq!(editor.diagnostics(&file), ["2:21 E0206 unknown type `nothing`"]);
    editor.tell("textDocument/didClose", json!({"textDocument": {"uri": uri(&file)}}));
    assert_eq!(editor.diagnostics(&file), [""; 0]);
    assert!(editor.stop().success());
}

#[test]
fn what_cannot_work_is_told_as_a_hint_while_it_is_typed() {
    let room = room();
    let file = room.path().join("loop.gen");
    let text = |wcet: &str| {
        format!(
            "component c {{\n  task t {{ period 5 ms; }};\n  activity go() {{ task t;\n    \
             codel<start> c_go() yield pause::start, ether {wcet};\n    \
             codel<stop> c_stop() yield ether; }};\n}};\n"
        )
    };
    let mut editor = start();
    editor.open(&file, &text("wcet 6 ms"));
    assert_eq!(
        editor.diagnostics(&file),
        ["3:17 overrun c_go takes up to 6 ms, and t has a tick each 5 ms"]
    );
    editor.change(&file, 2, &text("wcet 4 ms"));
    assert_eq!(editor.diagnostics(&file), [""; 0]);
    let sleeps = text("wcet 4 ms").replace("  task t", "  event alarm; task t").replace(
        "c_stop() yield ether;",
        "c_stop() yield sleep, ether; codel<alarm> c_alarm() yield ether;",
    );
    editor.change(&file, 3, &sleeps);
    assert_eq!(
        editor.diagnostics(&file),
        ["4:16 stop activity go may sleep in state stop once it was asked to stop: only an event \
             ends that"]
    );
    let (all, ordered) = (
        "  activity go()",
        "  function first() { codel f1(); after last; };\n  function last() { codel f2(); after \
         first; };\n  activity go()",
    );
    editor.change(&file, 4, &text("wcet 4 ms").replace(all, ordered));
    let order = |place: &str, of: &str, all: &str| {
        format!(
            "{place} order {of} can never run: there is no order of {all} in which `before` and \
             `after` hold"
        )
    };
    assert_eq!(
        editor.diagnostics(&file),
        [order("2:11", "first", "first, last"), order("3:11", "last", "last, first")]
    );
    assert!(editor.stop().success());
}

#[test]
fn a_text_made_to_take_memory_is_refused_and_the_server_goes_on() {
    let room = room();
    let file = room.path().join("arm.gen");
    let mut editor = start();
    let (open, close) = ("q(".repeat(60), ")".repeat(60));
    editor.open(
        &file,
        &format!("#define s(x) #x\n#define q(x) s(x)\nconst string a = {open}\"\\\\\"{close};\n"),
    );
    let said = editor.diagnostics(&file);
    assert_eq!(said.len(), 1, "{said:?}");
    assert!(said[0].contains("E0127 macros expand to more than 16 MiB of text"), "{said:?}");
    editor.change(&file, 2, ARM);
    assert_eq!(editor.diagnostics(&file), [""; 0]);
    assert!(editor.stop().success());
}

#[test]
fn an_unsaved_include_counts_and_its_mistakes_are_told_where_they_are() {
    let room = room();
    let (file, types) = (room.path().join("arm.gen"), room.path().join("types.gen"));
    let mut editor = start();
    editor.open(&file, ARM);
    assert_eq!(editor.diagnostics(&file), [""; 0]);
    editor.open(&types, "struct pose { double x; };\n");
    let said = editor.diagnostics(&file);
    assert!(said.iter().any(|one| one.contains("unknown type `point`")), "{said:?}");
    assert_eq!(editor.diagnostics(&types), [""; 0]);
    editor.change(&types, 2, "struct point { double x; nothing y; };\n");
    assert_eq!(editor.diagnostics(&file), [""; 0]);
    // Found twice, from the file itself and from the one that includes it, but published once.
    assert_eq!(editor.diagnostics(&types), ["0:25 E0206 unknown type `nothing`"]);
    assert!(editor.stop().success());
}

#[test]
fn options_come_from_the_command_line_and_from_the_editor() {
    let room = room();
    std::fs::create_dir(room.path().join("inc")).unwrap();
    std::fs::write(room.path().join("inc/unit.h"), "typedef double metre;\n").unwrap();
    let file = room.path().join("arm.gen");
    let text = "#include <unit.h>\nstruct s { NUMBER a; metre b; };\n";
    let include = room.path().join("inc").display().to_string();
    let (mut one, _) = server(&["-I", &include, "-D", "NUMBER=long"], &Value::Null);
    one.open(&file, text);
    assert_eq!(one.diagnostics(&file), [""; 0]);
    let options = json!({"include": [include], "defines": ["NUMBER=long"]});
    let (mut other, _) = server(&[], &options);
    other.open(&file, text);
    assert_eq!(other.diagnostics(&file), [""; 0]);
}

/// A request about the position of `|` in the arm.
fn ask(editor: &mut Client, room: &tempfile::TempDir, method: &str, marked: &str) -> Value {
    let file = room.path().join("arm.gen");
    editor.ask(
        &format!("textDocument/{method}"),
        json!({
            "textDocument": {"uri": uri(&file)}, "position": position(ARM, marked),
            "context": {"includeDeclaration": true, "triggerKind": 1},
        }),
    )
}

#[test]
fn names_are_explained_and_followed() {
    let room = room();
    let (file, types) = (room.path().join("arm.gen"), room.path().join("types.gen"));
    let mut editor = start();
    editor.open(&file, ARM);
    let hover = ask(&mut editor, &room, "hover", "port out po|int tip");
    let told = hover["contents"]["value"].as_str().unwrap();
    assert!(told.contains("struct point { double x; double y; }"), "{told}");
    assert!(told.contains("16 bytes, alignment 8"), "{told}");
    assert_eq!(hover["range"]["start"], json!({"line": 2, "character": 21}));
    let hover = ask(&mut editor, &room, "hover", "out t|ip)");
    assert!(hover["contents"]["value"].as_str().unwrap().contains("Where it is."), "{hover}");
    assert_eq!(ask(&mut editor, &room, "hover", "per|iod"), Value::Null);

    let at = |path, line: u32, start: u32, end: u32| {
        json!({"uri": uri(path), "range": {
            "start": {"line": line, "character": start}, "end": {"line": line, "character": end},
        }})
    };
    for (marked, wanted) in [
        ("in poi|nt goal", at(&types, 0, 7, 12)),
        ("out t|ip)", at(&file, 2, 27, 30)),
        ("task mai|n;", at(&file, 3, 7, 11)),
        ("in g|oal,", at(&file, 4, 23, 27)),
        ("\"typ|es.gen", at(&types, 0, 0, 0)),
    ] {
        assert_eq!(ask(&mut editor, &room, "definition", marked), wanted, "{marked}");
    }
    let places = ask(&mut editor, &room, "references", "out t|ip)");
    assert_eq!(places.as_array().unwrap().len(), 2, "{places}");
}

#[test]
fn completions_fit_the_text_as_it_is_being_written() {
    let room = room();
    let file = room.path().join("arm.gen");
    let mut editor = start();
    editor.open(&file, ARM);
    let labels = |found: &Value| -> Vec<String> {
        let found = found.as_array().unwrap().iter();
        found.map(|one| one["label"].as_str().unwrap().to_owned()).collect()
    };
    let tasks = labels(&ask(&mut editor, &room, "completion", "task |main;"));
    assert_eq!(tasks, ["main"]);
    // The text has not been read yet when the request arrives.
    let marked = "component arm { port in |";
    let text = ARM.replace("component arm {", "component arm { port in ");
    editor.change(&file, 2, &text);
    let asked = json!({"textDocument": {"uri": uri(&file)}, "position": position(&text, marked)});
    let types = editor.ask("textDocument/completion", asked);
    assert!(labels(&types).contains(&"point".to_owned()), "{types}");
    let point = types.as_array().unwrap().iter().find(|one| one["label"] == "point").unwrap();
    assert_eq!(point["detail"], "struct point { double x; double y; }");
}

#[test]
fn symbols_and_formatting_are_of_the_open_text() {
    let room = room();
    let file = room.path().join("arm.gen");
    let mut editor = start();
    editor.open(&file, "component arm {\n  task main { period 1 s; };\n      task slow {};\n};\n");
    let document = json!({"textDocument": {"uri": uri(&file)}});
    let symbols = editor.ask("textDocument/documentSymbol", document.clone());
    assert_eq!(symbols[0]["name"], "arm");
    assert_eq!(symbols[0]["range"]["end"], json!({"line": 3, "character": 2}));
    assert_eq!(symbols[0]["children"][1]["name"], "slow");
    let asked = json!({
        "textDocument": {"uri": uri(&file)}, "options": {"tabSize": 2, "insertSpaces": true},
    });
    let edits = editor.ask("textDocument/formatting", asked.clone());
    assert_eq!(
        edits,
        json!([{
            "range": {"start": {"line": 2, "character": 0}, "end": {"line": 3, "character": 0}},
            "newText": "  task slow {};\n",
        }])
    );
    editor.change(&file, 2, "/* never closed");
    let refused = editor.reply("textDocument/formatting", asked);
    assert_eq!(refused["error"]["message"], "line 1: this comment is never closed");
}

#[test]
fn what_is_not_understood_is_refused_and_the_server_lives_on() {
    let room = room();
    let mut editor = start();
    let unknown = editor.reply("textDocument/moniker", json!({}));
    assert_eq!(unknown["error"]["code"], -32601);
    let wrong = editor.reply("textDocument/hover", json!({"place": 3}));
    assert_eq!(wrong["error"]["code"], -32602);
    let closed = ask(&mut editor, &room, "hover", "port out po|int");
    assert_eq!(closed, Value::Null, "a text that is not open");
    editor.tell("workspace/didChangeConfiguration", json!({}));
    assert!(editor.stop().success());
}

#[test]
fn a_name_is_changed_everywhere_also_in_files_that_are_included() {
    let room = room();
    let (file, types) = (room.path().join("arm.gen"), room.path().join("types.gen"));
    let mut editor = start();
    editor.open(&file, ARM);
    let asked = |marked: &str, name: &str| {
        json!({
            "textDocument": {"uri": uri(&file)}, "position": position(ARM, marked),
            "newName": name,
        })
    };
    let range = editor.ask("textDocument/prepareRename", asked("port out po|int tip", ""));
    assert_eq!(range["start"], json!({"line": 2, "character": 21}));
    let edit = editor.ask("textDocument/rename", asked("port out po|int tip", "place"));
    let changes = edit["changes"].as_object().unwrap();
    let count = |path| changes[uri(path).as_str()].as_array().unwrap().len();
    assert_eq!(count(&types), 1, "{edit}");
    assert_eq!(count(&file), ARM.matches("point").count(), "{edit}");
    assert!(
        changes.values().flat_map(|of| of.as_array().unwrap()).all(|e| e["newText"] == "place")
    );
    for (marked, name, why) in [
        ("port out po|int tip", "two words", "cannot be a name"),
        ("port out po|int tip", "struct", "cannot be a name"),
        ("<st|art>", "begin", "keeps its name"),
    ] {
        let refused = editor.reply("textDocument/rename", asked(marked, name));
        let message = refused["error"]["message"].as_str().unwrap_or_default();
        assert!(message.contains(why), "{marked}: {refused}");
    }
    assert!(editor.stop().success());
}

#[test]
fn mistakes_are_put_right_as_their_help_says() {
    let room = room();
    let file = room.path().join("arm.gen");
    let mut editor = start();
    let wrong = ARM.replace("in point goal", "in piont goal");
    editor.open(&file, &wrong);
    let place = position(&wrong, "in pi|ont goal");
    let actions = editor.ask(
        "textDocument/codeAction",
        json!({
            "textDocument": {"uri": uri(&file)}, "range": {"start": place, "end": place},
            "context": {"diagnostics": []},
        }),
    );
    assert_eq!(actions[0]["title"], "change `piont` to `point`");
    assert_eq!(actions[0]["kind"], "quickfix");
    let edit = &actions[0]["edit"]["changes"][uri(&file).as_str()][0];
    assert_eq!(edit["newText"], "point");
    assert_eq!(
        edit["range"]["start"]["character"],
        position(&wrong, "in |piont goal")["character"]
    );
    assert_eq!(actions.as_array().unwrap().len(), 1);
}

#[test]
fn words_are_coloured_by_what_they_mean() {
    let room = room();
    let file = room.path().join("arm.gen");
    let (mut editor, hello) = server(&[], &Value::Null);
    let legend = &hello["capabilities"]["semanticTokensProvider"]["legend"]["tokenTypes"];
    let text = "component arm {\n  ids { long n; };\n  function f() { codel go(in n); };\n};\n";
    editor.open(&file, text);
    let document = json!({"textDocument": {"uri": uri(&file)}});
    let found = editor.ask("textDocument/semanticTokens/full", document);
    let data: Vec<usize> =
        found["data"].as_array().unwrap().iter().map(|n| n.as_u64().unwrap() as usize).collect();
    let (mut line, mut column, mut shown) = (0, 0, Vec::new());
    for token in data.chunks(5) {
        column = if token[0] == 0 { column + token[1] } else { token[1] };
        line += token[0];
        let word = &text.lines().nth(line).unwrap()[column..column + token[2]];
        let kind = legend[token[3]].as_str().unwrap();
        shown.push(format!("{word}:{kind}{}", if token[4] == 1 { "!" } else { "" }));
    }
    assert_eq!(
        shown.join(" "),
        "component:keyword arm:class! ids:keyword long:keyword n:property! function:keyword \
         f:method! codel:keyword go:function! in:keyword n:property"
    );
}
