//! What components are built against, besides the programs: headers, pkg-config files, the CMake
//! package, and the crates of components in Rust. Each package of genomd, and `genomctl sdk`,
//! installs these files.

use std::path::Path;

use genom::sources::{MACROS, SDK};
use genom_description::preprocess::GENOM;
use genom_headers::HEADERS;

use crate::file::File;

const GENOM3: &str = include_str!("../templates/sdk/genom3.pc");
const GENOMD: &str = include_str!("../templates/sdk/genomd.pc");
const CMAKE: &str = include_str!("../templates/cmake/genomdConfig.cmake");
const CMAKE_VERSION: &str = include_str!("../templates/cmake/genomdConfigVersion.cmake");
const CRATE: &str = include_str!("../templates/sdk/rust/genom.toml");
const MACRO_CRATE: &str = include_str!("../templates/sdk/rust/genom-derive.toml");
/// Where the crate of components in Rust is, below a prefix.
pub const RUST: &str = "share/genomd/rust";
/// The prefix as its pkg-config files see it: the files may be moved together.
const RELATIVE: &str = "${pcfiledir}/../..";

/// The files, below an installation prefix. `installed_as` is the prefix that pkg-config files
/// name; without it they find it from where they are.
#[must_use]
pub fn files(installed_as: Option<&Path>) -> Vec<File> {
    let prefix =
        installed_as.map_or_else(|| RELATIVE.to_owned(), |path| path.display().to_string());
    let fill = |text: &str| {
        text.replace("%PREFIX%", &prefix)
            .replace("%GENOM%", GENOM)
            .replace("%VERSION%", env!("CARGO_PKG_VERSION"))
    };
    let mut list: Vec<File> = HEADERS
        .iter()
        .map(|(path, text)| File::new(Path::new("include").join(path), *text))
        .collect();
    list.push(File::new("share/pkgconfig/genom3.pc", fill(GENOM3)));
    list.push(File::new("share/pkgconfig/genomd.pc", fill(GENOMD)));
    list.push(File::new("share/cmake/genomd/genomdConfig.cmake", CMAKE));
    list.push(File::new("share/cmake/genomd/genomdConfigVersion.cmake", fill(CMAKE_VERSION)));
    list.push(File::new(Path::new(RUST).join("Cargo.toml"), fill(CRATE)));
    list.push(File::new(Path::new(RUST).join("derive/Cargo.toml"), fill(MACRO_CRATE)));
    for (directory, sources) in [("src", SDK), ("derive/src", MACROS)] {
        let directory = Path::new(RUST).join(directory);
        list.extend(sources.iter().map(|(path, text)| File::new(directory.join(path), *text)));
    }
    list
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;
    use std::path::PathBuf;

    fn below(directory: &Path, root: &Path, found: &mut BTreeSet<PathBuf>) {
        for entry in std::fs::read_dir(directory).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                below(&path, root, found);
            } else {
                found.insert(path.strip_prefix(root).unwrap().to_owned());
            }
        }
    }

    #[test]
    fn the_installed_crates_are_those_of_the_repository() {
        let files = files(None);
        let plugins = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../plugin-api");
        for (own, installed) in [("rust/src", "src"), ("derive/src", "derive/src")] {
            let installed = Path::new(RUST).join(installed);
            let mut wanted = BTreeSet::new();
            below(&plugins.join(own), &plugins.join(own), &mut wanted);
            let held = files.iter().filter_map(|file| file.path.strip_prefix(&installed).ok());
            let held: BTreeSet<PathBuf> = held.map(Path::to_owned).collect();
            assert_eq!(held, wanted);
            for path in wanted {
                let file = files.iter().find(|file| file.path == installed.join(&path)).unwrap();
                let text = std::fs::read_to_string(plugins.join(own).join(&path)).unwrap();
                assert!(file.text == text, "{}", path.display());
            }
        }
    }
}
