//! Puts a declaration into the text of a description, where one would write it by hand: after the
//! last of its kind, indented as the others.

use super::body::{Body, Kind, Part};

/// A declaration: its lines, each with how deep it is below the component's body.
pub(super) type Block = Vec<(usize, String)>;

/// The text with `block`.
pub(super) fn inserted(text: &str, body: &Body, kind: Kind, block: &Block) -> String {
    let ending = if text.contains("\r\n") { "\r\n" } else { "\n" };
    let before = anchor(&body.parts, kind);
    let indent = before
        .or(body.parts.first())
        .map_or_else(|| "  ".to_owned(), |part| indentation(text, part.bytes.start).to_owned());
    let indent = if indent.is_empty() { "  ".to_owned() } else { indent };
    let unit = if indent.contains('\t') { "\t" } else { "  " };
    let mut lines: Vec<String> = Vec::new();
    let tall = block.len() > 1 || before.is_some_and(|part| is_tall(text, part));
    // One-line declarations stand below each other, others apart.
    if before.is_some() && tall {
        lines.push(String::new());
    }
    lines
        .extend(block.iter().map(|(depth, line)| format!("{indent}{}{line}", unit.repeat(*depth))));
    let at = before.map_or(body.open, |part| part.bytes.end);
    let (at, alone) = end_of_line(text, at);
    let rest = text.get(at..).unwrap_or_default();
    let mut new: String = lines.iter().map(|line| format!("{ending}{line}")).collect();
    if alone {
        let next = rest.lines().nth(1).unwrap_or_default().trim_start();
        if tall && !next.is_empty() && !next.starts_with('}') {
            new.push_str(ending);
        }
    } else {
        // What follows in the line goes on in the next one.
        new.push_str(ending);
    }
    let rest = if alone { rest } else { rest.trim_start_matches([' ', '\t']) };
    format!("{}{new}{rest}", text.get(..at).unwrap_or_default())
}

/// The part after which one of this kind belongs.
fn anchor(parts: &[Part], kind: Kind) -> Option<&Part> {
    if let Some(last) = parts.iter().rfind(|part| part.kind == kind) {
        return Some(last);
    }
    match kind {
        // Before what uses ports, after the types that they have.
        Kind::Port => {
            let others = parts.iter().take_while(|part| part.kind == Kind::Other);
            others.last()
        }
        _ => parts.last(),
    }
}

fn indentation(text: &str, at: usize) -> &str {
    let before = text.get(..at).unwrap_or_default();
    let line = before.rsplit('\n').next().unwrap_or_default();
    // A part that begins within a line has no indentation of its own.
    if line.trim().is_empty() { line } else { "" }
}

fn is_tall(text: &str, part: &Part) -> bool {
    text.get(part.bytes.clone()).is_some_and(|text| text.contains('\n'))
}

/// The end of the line, with the comment that follows there; or `at` itself and false if something
/// else follows.
fn end_of_line(text: &str, at: usize) -> (usize, bool) {
    let rest = text.get(at..).unwrap_or_default();
    let line = rest.split('\n').next().unwrap_or_default();
    let line = line.strip_suffix('\r').unwrap_or(line);
    let comment = line.trim();
    let whole = comment.strip_prefix("/*").and_then(|inner| inner.strip_suffix("*/"));
    let alone = comment.is_empty()
        || comment.starts_with("//")
        || whole.is_some_and(|inner| !inner.contains("*/"));
    if alone { (at + line.len(), true) } else { (at, false) }
}

#[cfg(test)]
mod tests {
    use super::super::body::find;
    use super::*;
    use genom_description::preprocess::tokenize_text;
    use genom_description::source::SourceMap;

    #[track_caller]
    fn check(text: &str, kind: Kind, block: &[(usize, &str)], wanted: &str) {
        let mut sources = SourceMap::new();
        let (tokens, _) = tokenize_text("arm.gen", text, &mut sources);
        let file = sources.files().find(|(_, file)| !file.is_synthetic()).unwrap().0;
        let body = find(&tokens, file, "arm").unwrap();
        let block = block.iter().map(|(depth, line)| (*depth, (*line).to_owned())).collect();
        assert_eq!(inserted(text, &body, kind, &block), wanted);
    }

    const PORT: &[(usize, &str)] = &[(0, "port in s q;")];
    const TASK: &[(usize, &str)] = &[(0, "task u {"), (1, "period 1 s;"), (0, "};")];

    #[test]
    fn a_declaration_follows_the_last_of_its_kind_and_its_comment() {
        check(
            "component arm {\n  port out s p; /* where */\n  ids { s a; };\n};\n",
            Kind::Port,
            PORT,
            "component arm {\n  port out s p; /* where */\n  port in s q;\n  ids { s a; };\n};\n",
        );
        check(
            "component arm {\n\ttask t { /* t */\n\t\tdoc \"t\";\n\t};  // the first\n\n\t/* f */\n\tfunction f();\n};\n",
            Kind::Task,
            TASK,
            "component arm {\n\ttask t { /* t */\n\t\tdoc \"t\";\n\t};  // the first\n\n\ttask u {\n\t\tperiod 1 s;\n\t};\n\n\t/* f */\n\tfunction f();\n};\n",
        );
    }

    #[test]
    fn the_first_of_its_kind_goes_where_it_belongs() {
        check(
            "component arm {\n  version \"1\";\n  struct s { long a; };\n\n  /* Kept. */\n  ids { s a; };\n};\n",
            Kind::Port,
            PORT,
            "component arm {\n  version \"1\";\n  struct s { long a; };\n  port in s q;\n\n  /* Kept. */\n  ids { s a; };\n};\n",
        );
        check(
            "component arm {\n  ids { s a; };\n};\n",
            Kind::Task,
            TASK,
            "component arm {\n  ids { s a; };\n\n  task u {\n    period 1 s;\n  };\n};\n",
        );
    }

    #[test]
    fn what_stands_in_one_line_stays_in_order() {
        let one = "component arm { task t; };\n";
        check(one, Kind::Port, PORT, "component arm {\n  port in s q;\ntask t; };\n");
        check("component arm {};", Kind::Port, PORT, "component arm {\n  port in s q;\n};");
        check(
            "component arm {\r\n  port out s p;\r\n};\r\n",
            Kind::Port,
            PORT,
            "component arm {\r\n  port out s p;\r\n  port in s q;\r\n};\r\n",
        );
    }
}
