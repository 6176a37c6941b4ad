//! The descriptions that a template is given.

use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

use genom_description::diagnostic::render::short;
use genom_description::model::Component;
use genom_description::source::check_file;
use genom_description::{Analysis, Options, preprocess, read};

use crate::stop::Stop;

/// What all templates are given: the descriptions and how to read them.
#[derive(Debug)]
pub(crate) struct Input {
    /// Include directories and definitions.
    pub(crate) options: preprocess::Options,
    /// The `.gen` files.
    pub(crate) files: Vec<PathBuf>,
}

impl Input {
    /// Reads the descriptions; errors and warnings are printed as `FILE:LINE:COLUMN: message`.
    pub(crate) fn read(&self) -> Result<Analysis, Stop> {
        self.check()?;
        let options = Options { preprocess: self.options.clone(), standard_interface: true };
        let analysis = read(&self.files, &options);
        let told = short(&analysis.diagnostics, &analysis.sources);
        io::stderr().lock().write_all(told.as_bytes())?;
        match analysis.diagnostics.errors() {
            0 => Ok(analysis),
            errors => Err(Stop::Errors(errors)),
        }
    }

    /// The component that the descriptions declare, the first of several.
    pub(crate) fn component<'a>(&self, analysis: &'a Analysis) -> Result<&'a Component, Stop> {
        analysis.specification.components.first().ok_or_else(|| {
            Stop::Failed(format!("{}: declares no component", self.first().display()))
        })
    }

    /// Refuses files that are not there.
    pub(crate) fn check(&self) -> Result<(), Stop> {
        if self.files.is_empty() {
            return Err(Stop::Usage("name a .gen file".to_owned()));
        }
        for path in &self.files {
            check_file(path)
                .map_err(|error| Stop::Failed(format!("{}: {error}", path.display())))?;
        }
        Ok(())
    }

    /// The first file, which the description's directory and name are taken from.
    pub(crate) fn first(&self) -> &Path {
        self.files.first().map_or(Path::new(""), PathBuf::as_path)
    }
}
