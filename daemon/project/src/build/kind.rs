//! What a directory is, by the files in it.

use std::path::{Path, PathBuf};

use super::error::BuildError;

/// How a component is built.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Rust, by cargo.
    Cargo,
    /// By CMake.
    CMake,
    /// By Meson.
    Meson,
    /// By autotools: GenoM3's usual project.
    Autotools,
    /// A description and its codels, with no build files.
    Bare(PathBuf),
}

/// What `place` is: a description, or a directory.
///
/// # Errors
/// There is nothing to build, or no telling what.
pub fn kind(place: &Path) -> Result<Kind, BuildError> {
    if place.extension().is_some_and(|ending| ending == "gen") {
        return Ok(Kind::Bare(place.to_owned()));
    }
    for (file, kind) in [
        ("Cargo.toml", Kind::Cargo),
        ("CMakeLists.txt", Kind::CMake),
        ("meson.build", Kind::Meson),
        ("configure.ac", Kind::Autotools),
    ] {
        if place.join(file).is_file() {
            return Ok(kind);
        }
    }
    description(place).map(Kind::Bare)
}

/// The description of the component in a directory.
///
/// # Errors
/// There is none, or no telling which.
pub fn description(place: &Path) -> Result<PathBuf, BuildError> {
    let entries = std::fs::read_dir(place).map_err(BuildError::file(place))?;
    let mut found: Vec<PathBuf> = entries
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| path.extension().is_some_and(|ending| ending == "gen"))
        .filter(|path| declares_component(path))
        .collect();
    found.sort();
    match found.as_slice() {
        [] => Err(BuildError::Nothing(place.to_owned())),
        [one] => Ok(one.clone()),
        several => Err(BuildError::Several {
            directory: place.to_owned(),
            names: several
                .iter()
                .filter_map(|path| path.file_name())
                .map(|name| name.to_string_lossy().into_owned())
                .collect(),
        }),
    }
}

/// Whether the file, without those that it includes, has the word `component` at the start of a
/// line; files of types and interfaces are included by others.
fn declares_component(path: &Path) -> bool {
    std::fs::read_to_string(path)
        .is_ok_and(|text| text.lines().any(|line| line.trim_start().starts_with("component ")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn build_files_come_before_descriptions() {
        let scratch = tempfile::tempdir().unwrap();
        let at = |name: &str| scratch.path().join(name);
        assert!(matches!(kind(scratch.path()), Err(BuildError::Nothing(_))));
        fs::write(at("types.gen"), "typedef long t;\n").unwrap();
        fs::write(at("arm.gen"), "#include \"types.gen\"\n  component arm {};\n").unwrap();
        assert_eq!(kind(scratch.path()).unwrap(), Kind::Bare(at("arm.gen")));
        fs::write(at("leg.gen"), "component leg {};\n").unwrap();
        let told = kind(scratch.path()).unwrap_err().to_string();
        assert!(told.ends_with("arm.gen, leg.gen"), "{told}");
        fs::write(at("configure.ac"), "").unwrap();
        assert_eq!(kind(scratch.path()).unwrap(), Kind::Autotools);
        fs::write(at("CMakeLists.txt"), "").unwrap();
        assert_eq!(kind(scratch.path()).unwrap(), Kind::CMake);
        assert_eq!(kind(&at("leg.gen")).unwrap(), Kind::Bare(at("leg.gen")));
    }
}
