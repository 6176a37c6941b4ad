//! Components that their own build has installed (genom3.md 5.9): `libNAME_codels` in a directory of
//! libraries, `NAME.gen` in `share/idl/NAME`, and a pkg-config package that tells where both are.

use std::path::{Path, PathBuf};

use genom_description::pkg_config::PkgConfig;

/// The library of a component in a directory: `libdemo_codels.so`, else the one of the greatest
/// version, as in `libdemo_codels-1.2.so`. Only packages for development have the former.
pub(crate) fn library_in(directory: &Path, name: &str) -> Option<PathBuf> {
    let plain = directory.join(format!("lib{name}_codels.so"));
    if plain.is_file() {
        return Some(plain);
    }
    let start = format!("lib{name}_codels-");
    let versions = std::fs::read_dir(directory).ok()?.filter_map(|entry| {
        let file = entry.ok()?.file_name().into_string().ok()?;
        let version = file.strip_prefix(&start)?.strip_suffix(".so")?.to_owned();
        Some((numbers(&version), file))
    });
    versions.max().map(|(_, file)| directory.join(file))
}

/// The numbers of a version, so that 1.10 is greater than 1.9.
fn numbers(version: &str) -> Vec<u64> {
    version.split(|c: char| !c.is_ascii_digit()).filter_map(|part| part.parse().ok()).collect()
}

/// The library of a component below an installation prefix.
pub(crate) fn in_prefix(prefix: &Path, name: &str) -> Option<PathBuf> {
    let machine = format!("lib/{}-linux-gnu", std::env::consts::ARCH);
    ["lib", "lib64", &machine].into_iter().find_map(|place| library_in(&prefix.join(place), name))
}

/// The prefix that genomd itself is installed in.
pub(crate) fn own_prefix() -> Option<PathBuf> {
    let program = std::env::current_exe().ok()?;
    let directory = program.parent().filter(|directory| directory.ends_with("bin"))?;
    directory.parent().map(Path::to_owned)
}

/// The library of a component that pkg-config knows.
pub(crate) fn library_by_package(name: &str) -> Option<PathBuf> {
    packages(name)?.iter().find_map(|package| {
        let directories = directories(package, "libdir", "--libs-only-L", "-L")?;
        directories.iter().find_map(|directory| library_in(directory, name))
    })
}

/// The description of a component that pkg-config knows.
pub(crate) fn description_by_package(name: &str) -> Option<PathBuf> {
    let file = format!("{name}.gen");
    packages(name)?.iter().find_map(|package| {
        let directories = directories(package, "idldir", "--cflags-only-I", "-I")?;
        directories.iter().map(|directory| directory.join(&file)).find(|path| path.is_file())
    })
}

/// The directory that a variable of the package names, then those of its flags; `None` if pkg-config
/// does not know the package, or is not there.
fn directories(package: &str, variable: &str, question: &str, flag: &str) -> Option<Vec<PathBuf>> {
    // A package installed with the system names directories that every compiler searches.
    let pkg_config = PkgConfig::default().with_system_directories();
    let own = pkg_config.variable(package, variable).ok()?;
    let flags = pkg_config.flags(question, &[package]).unwrap_or_default();
    let flags = flags.iter().filter_map(|word| word.strip_prefix(flag)).map(str::to_owned);
    let all = std::iter::once(own).chain(flags).filter(|directory| !directory.is_empty());
    Some(all.map(PathBuf::from).collect())
}

/// The packages that a component may have; none for what is no name.
fn packages(name: &str) -> Option<[String; 2]> {
    let sound = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    let first = name.chars().next()?;
    (first.is_ascii_alphabetic() && name.chars().all(sound))
        .then(|| [format!("{name}-genom3"), format!("lib{name}_codels")])
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn an_installed_library_is_found_by_its_greatest_version_when_that_is_all_there_is() {
        let scratch = tempfile::tempdir().unwrap();
        let lib = scratch.path().join("lib64");
        fs::create_dir(&lib).unwrap();
        for file in ["libarm_codels-1.9.so", "libarm_codels-1.10.so", "libarm_codels.la"] {
            fs::write(lib.join(file), "").unwrap();
        }
        let found = in_prefix(scratch.path(), "arm").unwrap();
        assert_eq!(found, lib.join("libarm_codels-1.10.so"));
        fs::write(lib.join("libarm_codels.so"), "").unwrap();
        assert_eq!(in_prefix(scratch.path(), "arm").unwrap(), lib.join("libarm_codels.so"));
        assert_eq!(in_prefix(scratch.path(), "leg"), None);
    }

    #[test]
    fn only_names_are_asked_of_pkg_config() {
        assert!(packages("demo-cpp").is_some());
        for name in ["", "--version", "../x", "a b", "1"] {
            assert!(packages(name).is_none(), "{name}");
        }
    }
}
