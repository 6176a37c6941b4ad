//! Types of the control plane are defined in the protocol crate only; neither the daemon nor its
//! client defines its own.

use std::fs;

use genom_tests::{files, repository};

/// Lines of code in a folder, without tests, with file and line number.
fn code(folder: &str) -> Vec<(String, usize, String)> {
    let root = repository().join(folder);
    let mut all = Vec::new();
    for path in files("rs").into_iter().filter(|path| path.starts_with(&root)) {
        let file = path.strip_prefix(&root).unwrap().display().to_string();
        let text = fs::read_to_string(&path).unwrap();
        let product = text.split("#[cfg(test)]").next().unwrap_or_default();
        let lines = product.lines().enumerate();
        let lines = lines.filter(|(_, line)| !line.trim_start().starts_with("//"));
        all.extend(lines.map(|(at, line)| (file.clone(), at + 1, line.trim().to_owned())));
    }
    assert!(!all.is_empty(), "there is nothing below {folder}");
    all
}

/// Whether a line contains a word, not as part of a longer one.
fn says(line: &str, word: &str) -> bool {
    line.split(|c: char| !c.is_alphanumeric() && c != '_').any(|found| found == word)
}

/// Whether a line accesses a member by a literal name: `["name"]`, `.get("name")`,
/// `.pointer("/name")`.
fn looks_up(line: &str) -> bool {
    let quoted = |open: &str| {
        line.match_indices(open).any(|(at, _)| {
            let before = line[..at].chars().next_back();
            // A list of texts, `["a", "b"]`, follows an operator or an opening bracket.
            open != "[\"" || before.is_some_and(|c| c.is_alphanumeric() || "_)]?".contains(c))
        })
    };
    ["[\"", ".get(\"", ".get_mut(\"", ".pointer(\"", ".remove(\""].iter().any(|open| quoted(open))
}

#[track_caller]
fn none(wrong: Vec<String>) {
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn what_the_daemon_says_has_its_types_in_the_protocol_alone() {
    let mut wrong = Vec::new();
    for (file, at, line) in code("daemon") {
        if file.starts_with("protocol/") {
            continue;
        }
        let schema = ["ToSchema", "IntoParams", "ToResponse"].iter().any(|word| says(&line, word));
        let told = file.starts_with("genomd/src/rpc/")
            && ["Serialize", "Deserialize"].iter().any(|word| says(&line, word))
            // Calls the trait's function, to read a type of the protocol crate.
            && !line.contains("Deserialize as _");
        if schema || told {
            wrong.push(format!("daemon/{file}:{at}: {line}"));
        }
    }
    none(wrong);
}

/// Files of genomctl that deserialise something other than replies, and what.
const READ: &[(&str, &str)] = &[("lsp/mod.rs", "options that an editor sends")];

/// Files of genomctl that access members of something other than replies, and of what.
const LOOKED_UP: &[(&str, &str)] = &[
    ("agreement.rs", "lines of a manifest"),
    ("verbs/fmt.rs", "what it prints itself"),
    ("verbs/verify/mod.rs", "what it prints itself"),
    ("verbs/schedule/mod.rs", "what it prints itself"),
];

#[test]
fn genomctl_reads_replies_as_types_of_the_protocol_alone() {
    let mut wrong = Vec::new();
    let exempt = |list: &[(&str, &str)], file: &str| list.iter().any(|(path, _)| *path == file);
    for (file, at, line) in code("daemon/genomctl/src") {
        let type_of_its_own = says(&line, "Deserialize") && !exempt(READ, &file);
        let look_up = looks_up(&line) && !exempt(LOOKED_UP, &file);
        if type_of_its_own || look_up {
            wrong.push(format!("daemon/genomctl/src/{file}:{at}: {line}"));
        }
    }
    none(wrong);
}

#[test]
fn a_look_up_is_told_from_a_list() {
    for line in [
        "let name = reply[\"name\"].take();",
        "one[\"a\"][\"b\"]",
        "known()[\"ports\"]",
        "reply.get(\"name\")",
        "reply.pointer(\"/error/code\")",
    ] {
        assert!(looks_up(line), "{line}");
    }
    for line in
        ["vec![\"NAME\", \"STATE\"]", "let all = [\"a\", \"b\"];", "f(&[\"x\"])", "map.get(name)"]
    {
        assert!(!looks_up(line), "{line}");
    }
}
