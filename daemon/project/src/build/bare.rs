//! A description and its codels, without any build files: all sources beside it become one library.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

use genom_description::Analysis;
use genom_description::model::Component;
use genom_description_tools::{Language, header};
use genom_headers::HEADERS;

use super::Tell;
use super::compile::Compiler;
use super::error::BuildError;
use super::explain::explain;
use super::headers::{Missing, meaning, missing};
use super::packages::{Flags, flags};
use crate::file::File;
use crate::skeleton::{header_name, is_standard};

/// A component that is built without build files.
#[derive(Debug)]
pub struct Bare<'a> {
    /// Its description.
    pub description: &'a Path,
    /// What was read of it.
    pub analysis: &'a Analysis,
    /// The directory for library, objects and headers.
    pub output: &'a Path,
}

/// What was built.
#[derive(Clone, Debug)]
pub struct Built {
    /// The library.
    pub library: PathBuf,
    /// The copy of the description beside it.
    pub description: PathBuf,
}

impl Bare<'_> {
    /// Builds the library; sources that did not change are not compiled again.
    ///
    /// # Errors
    /// There are no codels, a package or compiler is missing, or the codels have mistakes, which
    /// are told.
    pub fn build(&self, tell: Tell<'_>) -> Result<Built, BuildError> {
        let component = self.analysis.specification.components.first();
        let component =
            component.ok_or_else(|| BuildError::NoComponent(self.description.to_owned()))?;
        let directory = self.description.parent().unwrap_or(Path::new("."));
        let codels = directory.join("codels");
        let codels = if codels.is_dir() { codels } else { directory.to_owned() };
        let sources = files(&codels, &["c", "cc", "cpp", "cxx"])?;
        if sources.is_empty() {
            let description = self.description.to_owned();
            return Err(BuildError::NoCodels { description, tried: codels });
        }
        let include = self.output.join("include");
        let packages = [&component.requires[..], &component.codels_requires].concat();
        let Flags { compile, link } = flags(&packages)?;
        self.write_headers(component, &sources, &[directory, &codels], &include)?;

        let mut given: Vec<String> = Vec::new();
        for directory in [&include, directory, &codels] {
            given.push(format!("-I{}", directory.display()));
        }
        given.extend(compile);
        let mut say = |sound: bool, told: &str| {
            if !told.is_empty() {
                tell(told.trim_end());
            }
            if !sound {
                explain(told, self.analysis, component, &sources)
                    .iter()
                    .for_each(|line| tell(line));
            }
        };
        let objects = self.objects(&sources, &given, &mut say)?;
        let library = self.output.join(format!("{}.so", component.name));
        let cxx = sources.iter().any(|source| is_cxx(source));
        let required = required(component);
        let (linked, told) =
            Compiler::new(cxx).library(&objects, &library, &[link, required].concat())?;
        say(linked, &told);
        if !linked {
            return Err(BuildError::Unlinked);
        }
        let description = self.copy_descriptions(component, directory)?;
        Ok(Built { library, description })
    }

    /// Writes the headers that an installed genomd has, and those that the component's own build
    /// would generate.
    fn write_headers(
        &self,
        component: &Component,
        sources: &[PathBuf],
        directories: &[&Path],
        include: &Path,
    ) -> Result<(), BuildError> {
        let write = |name: &str, text: &str| {
            let written = File::new(name, text).write(include, true);
            written.map(drop).map_err(BuildError::file(include.join(name)))
        };
        for (name, text) in HEADERS {
            write(name, text)?;
        }
        let mut texts = Vec::new();
        let own = files(directories.last().unwrap_or(&include), &["h", "hh", "hpp"])?;
        for path in sources.iter().chain(&own) {
            texts.push(
                String::from_utf8_lossy(&fs::read(path).map_err(BuildError::file(path))?)
                    .into_owned(),
            );
        }
        let mut names: BTreeSet<String> = missing(&texts, directories);
        names.insert(header_name(component));
        let spec = &self.analysis.specification;
        let natural = if component.lang == "c++" { Language::Cxx } else { Language::C };
        for name in names {
            let language = match meaning(&name, &component.name) {
                Missing::Types => natural,
                Missing::CxxTypes => Language::Cxx,
                Missing::Configuration => {
                    write(&name, "/* What autoconf would find out: nothing was asked. */\n")?;
                    continue;
                }
                Missing::Other => continue,
            };
            write(&name, &header(spec, Some(&component.name), language)?)?;
        }
        Ok(())
    }

    /// Compiles the sources, as many at once as there are processors.
    fn objects(
        &self,
        sources: &[PathBuf],
        flags: &[String],
        say: &mut dyn FnMut(bool, &str),
    ) -> Result<Vec<PathBuf>, BuildError> {
        let place = self.output.join("objects");
        fs::create_dir_all(&place).map_err(BuildError::file(&place))?;
        let object = |source: &Path| {
            // `a.c` and `a.cc` are different objects.
            let name = source.file_name().unwrap_or_default().to_string_lossy().replace('.', "_");
            place.join(name).with_extension("o")
        };
        let next = AtomicUsize::new(0);
        let workers = std::thread::available_parallelism().map_or(1, usize::from);
        let work = || {
            let mut done = Vec::new();
            while let Some(source) = sources.get(next.fetch_add(1, Ordering::Relaxed)) {
                let compiler = Compiler::new(is_cxx(source));
                done.push((source, compiler.object(source, &object(source), flags)));
            }
            done
        };
        let mut results = std::thread::scope(|scope| {
            let threads: Vec<_> =
                (0..workers.min(sources.len())).map(|_| scope.spawn(work)).collect();
            threads
                .into_iter()
                .flat_map(|thread| thread.join().unwrap_or_default())
                .collect::<Vec<_>>()
        });
        results.sort_by_key(|(source, _)| *source);
        let mut failed = 0;
        for (_, result) in results {
            let (sound, told) = result?;
            say(sound, &told);
            failed += usize::from(!sound);
        }
        if failed > 0 {
            return Err(BuildError::Refused { failed, all: sources.len() });
        }
        Ok(sources.iter().map(|source| object(source)).collect())
    }

    /// Copies the description, and the files below its directory that it includes, beside the
    /// library.
    fn copy_descriptions(
        &self,
        component: &Component,
        directory: &Path,
    ) -> Result<PathBuf, BuildError> {
        let copy = self.output.join(format!("{}.gen", component.name));
        for (_, file) in self.analysis.sources.files().filter(|(_, file)| !file.is_synthetic()) {
            let to = match file.path().strip_prefix(directory) {
                _ if file.path() == self.description => copy.clone(),
                Ok(below) => self.output.join(below),
                Err(_) => continue,
            };
            let text = fs::read(file.path()).map_err(BuildError::file(file.path()))?;
            if fs::read(&to).is_ok_and(|before| before == text) {
                continue;
            }
            if let Some(parent) = to.parent() {
                fs::create_dir_all(parent).map_err(BuildError::file(parent))?;
            }
            fs::write(&to, text).map_err(BuildError::file(&to))?;
        }
        Ok(copy)
    }
}

/// Flags by which the linker refuses a library that lacks a codel. The names of C++ functions
/// depend on their parameters; genomd tells at load which of them is missing.
fn required(component: &Component) -> Vec<String> {
    if component.lang == "c++" {
        return Vec::new();
    }
    let own = component.codels.iter().filter(|codel| !is_standard(component, codel));
    own.map(|codel| format!("-Wl,--require-defined={}", codel.name)).collect()
}

fn is_cxx(source: &Path) -> bool {
    source.extension().is_some_and(|ending| ending != "c")
}

/// Files of a directory with one of these endings, sorted.
fn files(directory: &Path, endings: &[&str]) -> Result<Vec<PathBuf>, BuildError> {
    let mut list = Vec::new();
    for entry in fs::read_dir(directory).map_err(BuildError::file(directory))? {
        let path = entry.map_err(BuildError::file(directory))?.path();
        let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or_default();
        if endings.contains(&ending) && path.is_file() {
            list.push(path);
        }
    }
    list.sort();
    Ok(list)
}
