//! The files of a new component, which builds, runs and has a test.

mod tool;

pub use tool::Tool;

use std::path::Path;

use crate::file::File;
use crate::skeleton::{Language, Sheet};

const GEN: &str = include_str!("../../templates/new/component.gen");
const MOVES: &str = include_str!("../../templates/new/moves.toml");
const README: &str = include_str!("../../templates/new/README.md");
const DEPLOYMENT: &str = include_str!("../../templates/new/component.toml");
const CI: &str = include_str!("../../templates/new/ci.yml");
const IGNORED: &str = include_str!("../../templates/new/gitignore");

const C: &str = include_str!("../../templates/new/codels.c");
const CXX: &str = include_str!("../../templates/new/codels.cc");

// Rust, by cargo.
const CARGO: &str = include_str!("../../templates/new/rust/Cargo.toml.in");
const RUST_LIB: &str = include_str!("../../templates/new/rust/src/lib.rs");
const RUST_TYPES: &str = include_str!("../../templates/new/rust/src/types.rs");
const RUST_CODELS: &str = include_str!("../../templates/new/rust/src/codels.rs");
const RUST_README: &str = include_str!("../../templates/new/rust/README.more.md");

// Python, which is not built.
const PYTHON: &str = include_str!("../../templates/new/python/codels.py");
const PYTHON_README: &str = include_str!("../../templates/new/python/README.md");
const PYTHON_CI: &str = include_str!("../../templates/new/python/ci.yml");

// Lua, which is not built either.
const LUA: &str = include_str!("../../templates/new/lua/codels.lua");
const LUA_README: &str = include_str!("../../templates/new/lua/README.md");

/// What the codels of a new component are written in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Codels<'a> {
    /// C or C++.
    Compiled(Language, Tool),
    /// Rust, built by cargo.
    Rust {
        /// The directory of crate `genom`, absolute: see [`crate::sdk::RUST`].
        sdk: &'a Path,
    },
    /// Python.
    Python,
    /// Lua.
    Lua,
}

/// Why a word cannot be the name of a component.
///
/// Component names are identifiers of the language, and part of C names.
#[must_use]
pub fn refused(name: &str) -> Option<String> {
    let sound = |c: char| c.is_ascii_alphanumeric() || c == '_';
    if !name.starts_with(|c: char| c.is_ascii_alphabetic()) || !name.chars().all(sound) {
        let what = "a letter, then letters, digits and _";
        return Some(format!("`{name}` cannot be the name of a component: write {what}"));
    }
    genom_description::c_names::is_taken(name).then(|| format!("`{name}` is a word of C or C++"))
}

/// The library that the build of such a component makes, below its directory.
#[must_use]
pub fn library(name: &str, codels: Codels<'_>) -> String {
    match codels {
        Codels::Compiled(_, tool) => tool.library(name),
        // As installed components are named; a crate may not have every name of a component.
        Codels::Rust { .. } => format!("target/debug/lib{name}_codels.so"),
        Codels::Python => format!("{name}.py"),
        Codels::Lua => format!("{name}.lua"),
    }
}

/// The files of a component called `name`, below its directory.
#[must_use]
pub fn files(name: &str, codels: Codels<'_>) -> Vec<File> {
    let library = library(name, codels);
    let interface = match codels {
        Codels::Compiled(Language::Cxx, _) => "c++",
        Codels::Compiled(Language::C, _) | Codels::Rust { .. } => "c",
        Codels::Python => "python",
        Codels::Lua => "lua",
    };
    let (test, sources, built) = match codels {
        Codels::Compiled(_, tool) => (tool.test(), "codels", tool.built()),
        Codels::Rust { .. } => ("genomctl test", "src/codels.rs", "target/"),
        Codels::Python => ("genomctl test", library.as_str(), "__pycache__/"),
        Codels::Lua => ("genomctl test", library.as_str(), ""),
    };
    let (readme, ci) = match codels {
        Codels::Compiled(..) | Codels::Rust { .. } => (README, CI),
        Codels::Python => (PYTHON_README, PYTHON_CI),
        Codels::Lua => (LUA_README, PYTHON_CI),
    };
    let fill = |text: &str| {
        text.replace("%NAME%", name)
            .replace("%INTERFACE%", interface)
            .replace("%LIBRARY%", &library)
            .replace("%TEST%", test)
            .replace("%PLACE%", library.rsplit_once('/').map_or("", |(place, _)| place))
            .replace("%CODELS%", sources)
            .replace("%BUILT%", built)
    };
    let mut list = vec![
        File::new(format!("{name}.gen"), fill(GEN)),
        File::new("tests/moves.toml", fill(MOVES)),
        File::new("README.md", fill(readme)),
        File::new(format!("{name}.toml"), fill(DEPLOYMENT)),
        File::new(".github/workflows/ci.yml", fill(ci)),
        File::new(".gitignore", fill(IGNORED)),
    ];
    match codels {
        Codels::Compiled(language, tool) => {
            let text = if language == Language::C { C } else { CXX };
            let path = format!("codels/{name}_codels.{}", language.extension());
            let sheet = Sheet { path: path.clone().into(), opening: fill(text), functions: vec![] };
            list.push(File::new(path, sheet.text()));
            list.extend(tool.files(name, &fill(GEN), language, sheet));
        }
        Codels::Python => list.push(File::new(library.clone(), fill(PYTHON))),
        Codels::Lua => list.push(File::new(library.clone(), fill(LUA))),
        Codels::Rust { sdk } => {
            let sdk = sdk.to_string_lossy();
            // Within a string of TOML.
            let quoted = sdk.replace('\\', "\\\\").replace('"', "\\\"");
            list.push(File::new("Cargo.toml", fill(CARGO).replace("%SDK%", &quoted)));
            for (path, text) in [
                ("src/lib.rs", RUST_LIB),
                ("src/types.rs", RUST_TYPES),
                ("src/codels.rs", RUST_CODELS),
            ] {
                list.push(File::new(path, fill(text)));
            }
            let more = RUST_README.replace("%SDK%", &sdk);
            list.iter_mut().filter(|file| file.path == Path::new("README.md")).for_each(|file| {
                file.text.push_str(&more);
            });
        }
    }
    list
}

#[cfg(test)]
mod tests {
    use super::*;
    use genom_description::{Options, read_text};

    #[test]
    fn a_new_description_has_no_mistakes_and_no_warnings() {
        let sdk = Path::new("/opt/genomd/share/genomd/rust");
        let tools = [Tool::CMake, Tool::Meson, Tool::Autotools];
        let compiled = [Language::C, Language::Cxx]
            .into_iter()
            .flat_map(|language| tools.map(|tool| Codels::Compiled(language, tool)));
        for codels in compiled.chain([Codels::Rust { sdk }, Codels::Python, Codels::Lua]) {
            let files = files("arm", codels);
            let gen_file = files.iter().find(|file| file.path.ends_with("arm.gen")).unwrap();
            let analysis = read_text("arm.gen", &gen_file.text, &Options::default());
            let (errors, warnings) =
                (analysis.diagnostics.errors(), analysis.diagnostics.warnings());
            assert_eq!((errors, warnings), (0, 0));
            for file in &files {
                // `make` has rules with `%`, which no word in capitals follows.
                let left = file
                    .text
                    .split('%')
                    .skip(1)
                    .any(|rest| rest.starts_with(|c: char| c.is_ascii_uppercase()));
                assert!(!left, "{} is not filled in", file.path.display());
            }
        }
    }

    #[test]
    fn names_that_no_component_can_have_are_refused() {
        assert_eq!(refused("arm_2"), None);
        for name in ["", "2arm", "my-arm", "ärm", "../x", "int"] {
            assert!(refused(name).is_some(), "{name}");
        }
    }
}
