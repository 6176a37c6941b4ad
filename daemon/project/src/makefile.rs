//! Rules for `make` about the files that a description is made of (the `.d` files that `gcc -MD`
//! writes, too).

use std::path::Path;

use genom_description::source::SourceMap;

/// The rule by which `target` depends on all files that were read, and a rule without commands for
/// each of them, so that `make` goes on when an included file was removed.
#[must_use]
pub fn dependencies(target: &str, sources: &SourceMap) -> String {
    let mut names: Vec<String> = Vec::new();
    for (_, file) in sources.files().filter(|(_, file)| !file.is_synthetic()) {
        let name = escaped(file.path());
        if !names.contains(&name) {
            names.push(name);
        }
    }
    let mut text = format!("{target}:");
    for name in &names {
        text.push_str(" \\\n  ");
        text.push_str(name);
    }
    text.push('\n');
    for name in &names {
        text.push_str(&format!("\n{name}:\n"));
    }
    text
}

/// A path as `make` reads it.
fn escaped(path: &Path) -> String {
    let mut name = String::new();
    for character in path.to_string_lossy().chars() {
        match character {
            ' ' | '\t' | '#' | '\\' | ':' | '%' => name.extend(['\\', character]),
            '$' => name.push_str("$$"),
            other => name.push(other),
        }
    }
    name
}

#[cfg(test)]
mod tests {
    use super::*;
    use genom_description::{Options, read};
    use std::fs;

    #[test]
    fn all_included_files_are_dependencies_once_in_the_form_that_make_reads() {
        let scratch = tempfile::tempdir().unwrap();
        let at = |name: &str| scratch.path().join(name);
        fs::write(at("a b.idl"), "typedef long t;\n").unwrap();
        fs::write(at("c$.idl"), "#include \"a b.idl\"\n").unwrap();
        fs::write(at("x.gen"), "#include \"c$.idl\"\n").unwrap();
        let analysis = read(&[at("x.gen")], &Options::default());
        let text = dependencies("x.h", &analysis.sources);
        let rule: String = text.lines().take(4).collect();
        assert!(rule.starts_with("x.h: \\"), "{text}");
        assert!(text.contains("/a\\ b.idl:\n") && text.contains("/c$$.idl:\n"), "{text}");
        assert_eq!(text.matches("/x.gen").count(), 2, "{text}");
        assert!(!text.contains('<'), "{text}");
    }
}
