//! Finds out whether the component's own sources define a symbol that its library lacks.
//!
//! The search recognises C and C++ functions by the usual form of their head; what it does not find
//! is reported as an ordinary undefined symbol. It runs only after a library failed to open.

use std::fs;
use std::path::{Path, PathBuf};

/// Maximum number of files searched.
const FILES: usize = 500;
/// Maximum size of a file, in bytes; longer ones are not written by hand.
const LONGEST: u64 = 1 << 20;

/// The source file near the library or description that defines the function `symbol`.
#[must_use]
pub fn defined_in(symbol: &str, library: &Path, description: &Path) -> Option<PathBuf> {
    let name = plain(symbol)?;
    let absolute = |path: &Path| std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let (library, description) = (absolute(library), absolute(description));
    let near = [description.parent(), library.parent(), library.ancestors().nth(2)];
    let mut folders: Vec<PathBuf> = Vec::new();
    for folder in near.into_iter().flatten() {
        for folder in [folder.to_owned(), folder.join("codels"), folder.join("src")] {
            if !folders.contains(&folder) {
                folders.push(folder);
            }
        }
    }
    let sources = folders.iter().filter_map(|folder| fs::read_dir(folder).ok());
    let sources =
        sources.flatten().flatten().map(|entry| entry.path()).filter(|path| is_source(path));
    sources.take(FILES).find(|path| {
        let short = fs::metadata(path).is_ok_and(|about| about.is_file() && about.len() <= LONGEST);
        short && fs::read(path).is_ok_and(|text| defines(&String::from_utf8_lossy(&text), name))
    })
}

fn is_source(path: &Path) -> bool {
    let extension = path.extension().unwrap_or_default().to_string_lossy();
    ["c", "cc", "cpp", "cxx", "C"].contains(&&*extension)
}

/// The name in the source: for a mangled C++ name its last part, without parameters.
fn plain(symbol: &str) -> Option<&str> {
    let Some(mut rest) = symbol.strip_prefix("_Z") else { return Some(symbol) };
    let nested = rest.starts_with('N');
    rest = rest.trim_start_matches(['N', 'K']);
    let mut last = None;
    loop {
        let digits = rest.len() - rest.trim_start_matches(|c: char| c.is_ascii_digit()).len();
        let Ok(length) = rest[..digits].parse::<usize>() else { return last };
        last = Some(rest.get(digits..digits.checked_add(length)?)?);
        rest = &rest[digits + length..];
        if !nested {
            return last;
        }
    }
}

/// Whether the text contains a definition of the function: name, parameters, and a body.
fn defines(text: &str, name: &str) -> bool {
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    text.match_indices(name).any(|(at, _)| {
        let after = &text[at + name.len()..];
        !text[..at].ends_with(is_word) && body_follows(after).unwrap_or(false)
    })
}

fn body_follows(after: &str) -> Option<bool> {
    let parameters = after.trim_start().strip_prefix('(')?;
    let mut depth = 1;
    let end = parameters.find(|c| {
        depth += match c {
            '(' => 1,
            ')' => -1,
            _ => 0,
        };
        depth == 0
    })?;
    let rest = parameters[end + 1..].trim_start();
    let rest = ["const", "noexcept"]
        .iter()
        .fold(rest, |rest, word| rest.strip_prefix(word).unwrap_or(rest).trim_start());
    Some(rest.starts_with('{'))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_function_with_a_body_is_a_definition_and_a_call_is_none() {
        let source = "static int helper_two(int (*f)(void))\n{\n  return helper(1);\n}\n";
        assert!(defines(source, "helper_two") && !defines(source, "helper"));
        assert!(!defines("int helper(int);\nif (helper(1)) { }", "other"));
        assert!(defines("void\nspace::thing::helper() const noexcept {}", "helper"));
        assert!(!defines("helper", "helper") && !defines("helper((", "helper"));
    }

    #[test]
    fn names_of_cpp_are_read_from_what_linkers_call_them() {
        assert_eq!(plain("demo_helper"), Some("demo_helper"));
        assert_eq!(plain("_Z6helperi"), Some("helper"));
        assert_eq!(plain("_ZN4demo4axis6helperEv"), Some("helper"));
        assert_eq!(plain("_ZNK4demo6helperEv"), Some("helper"));
        assert_eq!(plain("_Z99x"), None);
        assert_eq!(plain("_ZTV4demo"), None);
    }

    #[test]
    fn the_source_is_found_beside_the_description_and_in_its_tree() {
        let scratch = tempfile::tempdir().unwrap();
        let at = |name: &str| scratch.path().join(name);
        fs::create_dir_all(at("codels/.libs")).unwrap();
        fs::write(at("codels/helpers.c"), "int helper(void) { return 1; }").unwrap();
        fs::write(at("codels/main.c"), "int helper(void);\nint f(void) { return helper(); }")
            .unwrap();
        let (library, description) = (at("codels/.libs/libdemo_codels.so"), at("demo.gen"));
        assert_eq!(defined_in("helper", &library, &description), Some(at("codels/helpers.c")));
        assert_eq!(defined_in("other", &library, &description), None);
    }
}
