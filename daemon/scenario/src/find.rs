//! The files of scenarios: those that were named, and those in directories that were. Scripts in
//! Python are found, and not read.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use crate::model::Suite;
use crate::source::Mistakes;

/// Files cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum NoSuite {
    /// A file or directory cannot be read.
    #[error("{}: {source}", path.display())]
    Read {
        /// Which.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// There are no scenarios in a directory.
    #[error("{}: no file *.toml with a [[scenario]] there, and no *.py that imports genom.scenario", .0.display())]
    None(PathBuf),
    /// Files have mistakes.
    #[error("{}", .0.iter().map(Mistakes::to_string).collect::<Vec<_>>().join("\n"))]
    Mistakes(Vec<Mistakes>),
}

/// Reads files, and all files `*.toml` with scenarios and `*.py` that import `genom.scenario` in
/// directories and below them, in the order of their names.
///
/// # Errors
/// One cannot be read, a directory has none, or files have mistakes: those of all files.
pub fn find(paths: &[PathBuf]) -> Result<Vec<Suite>, NoSuite> {
    let (mut suites, mut mistakes) = (Vec::new(), Vec::new());
    for path in paths {
        let directory = path.is_dir();
        let mut found = Vec::new();
        if directory {
            walk(path, &mut found)?;
        } else {
            found.push((path.clone(), read(path)?));
        }
        if found.is_empty() {
            return Err(NoSuite::None(path.clone()));
        }
        for (file, text) in found {
            if is_script(&file) {
                suites.push(Suite::script(file));
                continue;
            }
            match Suite::read(&file, &text) {
                Ok(suite) => suites.push(suite),
                Err(error) => mistakes.push(error),
            }
        }
    }
    match mistakes.is_empty() {
        true => Ok(suites),
        false => Err(NoSuite::Mistakes(mistakes)),
    }
}

fn read(path: &Path) -> Result<String, NoSuite> {
    fs::read_to_string(path).map_err(|source| NoSuite::Read { path: path.to_owned(), source })
}

fn is_script(file: &Path) -> bool {
    file.extension().is_some_and(|extension| extension == "py")
}

/// Whether a script imports what makes functions scenarios.
fn has_scenarios(text: &str) -> bool {
    text.lines().any(|line| {
        let mut words = line.split_whitespace();
        let (first, second) = (words.next(), words.next());
        matches!(first, Some("from" | "import")) && second == Some("genom.scenario")
    })
}

/// Adds the files of scenarios in a directory. Links to directories are not followed: they may lead
/// back.
fn walk(directory: &Path, found: &mut Vec<(PathBuf, String)>) -> Result<(), NoSuite> {
    let wrong = |source| NoSuite::Read { path: directory.to_owned(), source };
    let entries = fs::read_dir(directory).map_err(wrong)?;
    let mut paths = entries
        .map(|entry| entry.map(|entry| entry.path()))
        .collect::<Result<Vec<_>, _>>()
        .map_err(wrong)?;
    paths.sort();
    for path in paths {
        if path.is_dir() && !path.is_symlink() {
            walk(&path, found)?;
            continue;
        }
        let one: fn(&str) -> bool = match path.extension().and_then(|extension| extension.to_str())
        {
            Some("toml") => Suite::is_one,
            Some("py") => has_scenarios,
            _ => continue,
        };
        if path.is_file() {
            let text = read(&path)?;
            if one(&text) {
                found.push((path, text));
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_found_in_the_order_of_their_names_and_others_are_left_out() {
        let place = tempfile::tempdir().unwrap();
        let suite = "[[scenario]]\nname = \"a\"\nsteps = [{ step = \"0s\" }]\n";
        fs::create_dir(place.path().join("more")).unwrap();
        for (name, text) in [
            ("b.toml", suite),
            ("a.toml", suite),
            ("robot.toml", "backend = \"shm\"\n"),
            ("notes.txt", "no scenario"),
            ("c.py", "import os\n\nfrom genom.scenario import scenario\n"),
            ("codels.py", "import genom\n"),
            ("more/c.toml", suite),
        ] {
            fs::write(place.path().join(name), text).unwrap();
        }
        let names = |path: &Path| {
            let all = find(&[path.to_owned()]).unwrap().into_iter();
            all.map(|suite| suite.file.strip_prefix(path).unwrap().to_owned()).collect::<Vec<_>>()
        };
        assert_eq!(
            names(place.path()),
            ["a.toml", "b.toml", "c.py", "more/c.toml"].map(PathBuf::from)
        );
        fs::write(place.path().join("b.toml"), "[[scenario").unwrap();
        let told = find(&[place.path().to_owned()]).unwrap_err().to_string();
        assert!(told.contains("b.toml:1:"), "{told}");
        let empty = tempfile::tempdir().unwrap();
        let told = find(&[empty.path().to_owned()]).unwrap_err().to_string();
        assert!(
            told.ends_with(
                "no file *.toml with a [[scenario]] there, and no *.py that imports genom.scenario"
            ),
            "{told}"
        );
    }
}
