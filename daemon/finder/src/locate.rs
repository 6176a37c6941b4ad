//! Finds the library and the description of a component.

use std::path::{Path, PathBuf};

use genom_host::{Contents, EmbeddedDescription, is_script, languages};

use crate::installed;
use crate::known::Description;
use genom_protocol::LoadRequest;

/// Library and description of a component.
#[derive(Debug)]
pub struct Located {
    /// Path of the library.
    pub library: PathBuf,
    /// The description.
    pub description: Description,
    /// Contents of the library, if they were read to find the description.
    pub contents: Option<Contents>,
}

/// The library or the description was not found.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum LocateError {
    /// There is no library.
    #[error(
        "no library for {}: there is no {}, and none is installed; build the component, or name \
         its directory or installation prefix with --path or GENOM_PATH",
        .wanted.display(),
        list(.tried)
    )]
    NoLibrary { wanted: PathBuf, tried: Vec<PathBuf> },
    /// There is no description.
    #[error(
        "no description for {}: it has none inside, and there is no {}; put one beside it, or \
         name it with --gen",
        .library.display(),
        .beside.display()
    )]
    NoDescription { library: PathBuf, beside: PathBuf },
    /// The file given by `--gen` does not exist.
    #[error("{}: no such description", .0.display())]
    NoSuchDescription(PathBuf),
    /// The library cannot be read.
    #[error(transparent)]
    Library(#[from] genom_host::OpenError),
}

/// The language of the codels that a request names, if they are a script, which only a process with
/// its interpreter loads; `None` for what is not found. Runs no program.
pub fn names_script(request: &LoadRequest, path: &[PathBuf]) -> Option<&'static str> {
    languages::of(&library_of(&request.library, path)?)
}

fn list(paths: &[PathBuf]) -> String {
    let shown: Vec<_> = paths.iter().map(|path| path.display().to_string()).collect();
    shown.join(" nor ")
}

/// Finds library and description for a request; `path` is the component path.
pub fn locate(request: &LoadRequest, path: &[PathBuf]) -> Result<Located, LocateError> {
    let wanted = &request.library;
    let named_gen = is_description(wanted);
    let Some(library) = library_of(wanted, path).or_else(|| packaged(wanted)) else {
        if named_gen && find_description(wanted, path).is_none() {
            return Err(LocateError::NoSuchDescription(wanted.clone()));
        }
        return Err(LocateError::NoLibrary {
            wanted: wanted.clone(),
            tried: if is_library(wanted) { vec![wanted.clone()] } else { candidates(wanted) },
        });
    };
    let (description, contents) = match &request.gen_file {
        Some(file) if file.is_file() => (Description::File(file.clone()), None),
        Some(file) => return Err(LocateError::NoSuchDescription(file.clone())),
        None if named_gen => {
            let found = find_description(wanted, path);
            let found = found.ok_or_else(|| LocateError::NoSuchDescription(wanted.clone()))?;
            (Description::File(found), None)
        }
        None => description_of(&library)?,
    };
    Ok(Located { library, description, contents })
}

/// Finds the library that a path or name stands for, without asking pkg-config.
fn library_of(wanted: &Path, path: &[PathBuf]) -> Option<PathBuf> {
    if is_description(wanted) {
        find_description(wanted, path)
            .and_then(|found| beside(&found).or_else(|| on_path(wanted, path)))
    } else if is_library(wanted) {
        existing(wanted.to_owned()).or_else(|| named_on_path(wanted, path))
    } else {
        beside(wanted).or_else(|| on_path(wanted, path)).or_else(|| with_genomd(wanted))
    }
}

fn is_description(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension == "gen")
}

/// Where libtool puts the library of codels, below a project or the directory that it is built in.
const LIBTOOL: &str = "codels/.libs";

fn is_library(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    name.ends_with(".so") || name.contains(".so.") || is_script(path)
}

fn existing(path: PathBuf) -> Option<PathBuf> {
    path.is_file().then_some(path)
}

/// Whether the path has no directory: it is then searched on the component path as well.
fn is_bare(path: &Path) -> bool {
    path.components().count() == 1
}

fn named_on_path(wanted: &Path, path: &[PathBuf]) -> Option<PathBuf> {
    if !is_bare(wanted) {
        return None;
    }
    path.iter().find_map(|directory| existing(directory.join(wanted)))
}

fn find_description(wanted: &Path, path: &[PathBuf]) -> Option<PathBuf> {
    existing(wanted.to_owned()).or_else(|| named_on_path(wanted, path))
}

/// The library for a description or name, in the same directory.
fn beside(wanted: &Path) -> Option<PathBuf> {
    candidates(wanted)
        .into_iter()
        .find_map(existing)
        .or_else(|| project_library(wanted))
        .or_else(|| project_library(&whole(wanted)))
}

/// The library for a description or name on the component path: in one of its directories, in a
/// subdirectory of that name, or where a build installs libraries below it.
fn on_path(wanted: &Path, path: &[PathBuf]) -> Option<PathBuf> {
    let stem = wanted.file_stem()?;
    path.iter().find_map(|directory| {
        beside(&directory.join(stem))
            .or_else(|| beside(&directory.join(stem).join(stem)))
            .or_else(|| installed::in_prefix(directory, &stem.to_string_lossy()))
    })
}

/// The library of a component that is installed with genomd or beside it.
fn with_genomd(wanted: &Path) -> Option<PathBuf> {
    let prefix = installed::own_prefix().filter(|_| is_bare(wanted))?;
    on_path(wanted, &[prefix.join("lib/genomd"), prefix])
}

/// The library of a component that pkg-config knows: never a script.
fn packaged(wanted: &Path) -> Option<PathBuf> {
    let name = wanted.to_str().filter(|_| is_bare(wanted))?;
    installed::library_by_package(name)
}

/// Possible names of the library: `demo.so`, `libdemo_codels.so` (as GenoM3 names it),
/// `libdemo.so`, or for codels in a script `demo.py` or as their language has it.
fn candidates(wanted: &Path) -> Vec<PathBuf> {
    let stem = wanted.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let built = ["{}.so", "lib{}_codels.so", "lib{}.so"].map(|name| name.replace("{}", &stem));
    let scripts = languages::all().map(|(_, extension)| format!("{stem}.{extension}"));
    built.into_iter().chain(scripts).map(|name| wanted.with_file_name(name)).collect()
}

/// The absolute path, whose parent directories are known.
fn whole(path: &Path) -> PathBuf {
    std::path::absolute(path).unwrap_or_else(|_| path.to_owned())
}

/// The library of a project, given its description: in the source tree or its directory `build`,
/// where libtool (genom3.md 5.9) and other build files put it, or installed.
fn project_library(description: &Path) -> Option<PathBuf> {
    let name = description.file_stem()?.to_string_lossy();
    let here = description.parent()?;
    let build = here.join("build");
    // Installed: PREFIX/share/idl/NAME/NAME.gen.
    let prefix = description.ancestors().nth(4);
    installed::library_in(&here.join(LIBTOOL), &name)
        .or_else(|| installed::library_in(&build.join(LIBTOOL), &name))
        .or_else(|| existing(build.join(format!("{name}.so"))))
        .or_else(|| installed::library_in(here, &name))
        .or_else(|| installed::in_prefix(prefix?, &name))
}

/// The description of a GenoM3 project, given its library: in the source tree, or installed.
fn project_description(library: &Path) -> Option<PathBuf> {
    let file = format!("{}.gen", component_name(library));
    if !library.file_name()?.to_string_lossy().contains("_codels") {
        return None;
    }
    let share = Path::new("share/idl").join(component_name(library)).join(&file);
    let up = |levels: usize| library.ancestors().nth(levels);
    // Built in the source tree, or in a directory of it.
    let built = up(1).is_some_and(|directory| directory.ends_with(LIBTOOL));
    let trees = [up(3), up(4)].map(|tree| tree.filter(|_| built).map(|tree| tree.join(&file)));
    // Two levels up if libraries are in a directory per architecture.
    let installed = [up(2), up(3)].into_iter().flatten().map(|prefix| prefix.join(&share));
    trees.into_iter().flatten().chain(installed).find_map(existing)
}

fn description_of(library: &Path) -> Result<(Description, Option<Contents>), LocateError> {
    let beside = library.with_file_name(format!("{}.gen", component_name(library)));
    let contents = Contents::read(library)?;
    if !contents.is_script()
        && let Some(EmbeddedDescription { text, name }) = contents.description()?
    {
        // Its `#include` lines are relative to the library's directory.
        let name = name.map_or_else(|| beside.clone(), |name| library.with_file_name(name));
        return Ok((Description::Embedded { name, text }, Some(contents)));
    }
    let found = existing(beside.clone())
        .or_else(|| project_description(library))
        .or_else(|| project_description(&whole(library)))
        .or_else(|| installed::description_by_package(&component_name(library)));
    match found {
        Some(file) => Ok((Description::File(file), Some(contents))),
        None => Err(LocateError::NoDescription { library: library.to_owned(), beside }),
    }
}

/// Name of the component in a library, script or description, or that is searched by it: `demo` for
/// `demo.so`, `libdemo_codels.so`, `libdemo.so.1`, `libdemo_codels-1.2.so`, `demo.py`, `demo.gen` or
/// `demo`.
#[must_use]
pub fn component_name(asked: &Path) -> String {
    let file = asked.file_name().unwrap_or_default().to_string_lossy();
    let version = |after: &str| after.is_empty() || after.starts_with('.');
    let library = file.split_once(".so").filter(|(_, after)| version(after) && !is_script(asked));
    let Some((stem, _)) = library else {
        return asked.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    };
    let stem = stem.strip_prefix("lib").unwrap_or(stem);
    match stem.split_once("_codels") {
        Some((name, _)) => name.to_owned(),
        None => stem.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    fn request(library: PathBuf) -> LoadRequest {
        LoadRequest { library, ..LoadRequest::default() }
    }

    fn scratch(files: &[&str]) -> tempfile::TempDir {
        let scratch = tempfile::tempdir().unwrap();
        for file in files {
            let path = scratch.path().join(file);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, "").unwrap();
        }
        scratch
    }

    #[test]
    fn a_description_finds_its_library() {
        let scratch = scratch(&[
            "demo.gen",
            "libdemo_codels.so",
            "x/arm.gen",
            "lib/arm/arm.so",
            "leg.gen",
            "leg.py",
        ]);
        let at = |name: &str| scratch.path().join(name);
        let found = locate(&request(at("demo.gen")), &[]).unwrap();
        assert_eq!(found.library, at("libdemo_codels.so"));
        assert_eq!(found.description, Description::File(at("demo.gen")));
        let found = locate(&request(at("x/arm.gen")), &[at("lib")]).unwrap();
        assert_eq!(found.library, at("lib/arm/arm.so"));
        let found = locate(&request(at("leg.gen")), &[]).unwrap();
        assert_eq!(found.library, at("leg.py"));
        let found = locate(&request(at("leg.py")), &[]).unwrap();
        assert_eq!(found.description, Description::File(at("leg.gen")));
    }

    #[test]
    fn what_a_project_built_in_its_directory_build_is_found_both_ways() {
        let libtool = "leg/build/codels/.libs/libleg_codels-0.1.so";
        let scratch = scratch(&["arm/arm.gen", "arm/build/arm.so", "leg/leg.gen", libtool]);
        let at = |name: &str| scratch.path().join(name);
        for (gen_file, library) in [("arm/arm.gen", "arm/build/arm.so"), ("leg/leg.gen", libtool)] {
            assert_eq!(locate(&request(at(gen_file)), &[]).unwrap().library, at(library));
        }
        assert_eq!(project_description(&at(libtool)), Some(at("leg/leg.gen")));
        // A library elsewhere is not described by whatever lies four directories above it.
        fs::write(at("leg.gen"), "").unwrap();
        assert_eq!(project_description(&at("leg/usr/lib/libleg_codels.so")), None);
    }

    #[test]
    fn what_is_missing_is_told_with_the_places_tried() {
        let scratch = scratch(&["demo.gen"]);
        let told = locate(&request(scratch.path().join("demo.gen")), &[]).unwrap_err().to_string();
        assert!(told.contains("demo.so nor ") && told.contains("libdemo_codels.so"), "{told}");
        let told = locate(&request("nothing.gen".into()), &[]).unwrap_err().to_string();
        assert_eq!(told, "nothing.gen: no such description");
    }

    #[test]
    fn names_of_files_give_the_component() {
        for name in [
            "x/demo.so",
            "libdemo.so",
            "/lib/libdemo_codels.so",
            "libdemo_codels-1.2.so",
            "libdemo.so.1",
            "demo.py",
            "demo.gen",
            "demo",
        ] {
            assert_eq!(component_name(Path::new(name)), "demo", "{name}");
        }
        assert_eq!(component_name(Path::new("library.gen")), "library");
    }
}
