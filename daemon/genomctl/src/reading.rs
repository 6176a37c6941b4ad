//! Reads descriptions for the verbs that need no daemon, and prints their diagnostics.

use std::io::{self, Write as _};
use std::path::PathBuf;

use genom_description::diagnostic::first;
use genom_description::diagnostic::render::human;
use genom_description::source::check_file;
use genom_description::{Analysis, Options, preprocess, read};

use crate::failure::Failure;
use crate::terminal::coloured_errors;

/// Maximum number of errors and warnings printed by default.
pub(crate) const SHOWN: usize = 100;

/// Options for reading descriptions.
#[derive(Clone, Debug, Default, clap::Args)]
pub(crate) struct Reading {
    /// Directory for #include; may be repeated.
    #[arg(long, short = 'I', value_name = "DIRECTORY")]
    pub(crate) include: Vec<PathBuf>,
    /// Definition for the preprocessor; may be repeated.
    #[arg(long = "define", short = 'D', value_name = "NAME[=VALUE]")]
    pub(crate) defines: Vec<String>,
    /// Leave out interface genom, which every component provides: what remains is what GenoM3's
    /// own tool sees, digests included.
    #[arg(long)]
    pub(crate) no_standard_interface: bool,
}

impl Reading {
    /// The options in the form of the library.
    pub(crate) fn options(&self) -> Options {
        let preprocess = preprocess::Options {
            include_dirs: self.include.clone(),
            defines: self.defines.clone(),
            ..preprocess::Options::default()
        };
        Options { preprocess, standard_interface: !self.no_standard_interface }
    }

    /// Reads the files as one specification, even if it has errors.
    pub(crate) fn read(&self, files: &[PathBuf]) -> Result<Analysis, Failure> {
        for path in files {
            if let Err(error) = check_file(path) {
                let why = match error.kind() {
                    io::ErrorKind::NotFound => "no such file".to_owned(),
                    _ => error.to_string(),
                };
                let message = format!("{}: {why}", path.display());
                return Err(Failure::usage(message, "name a .gen file"));
            }
        }
        Ok(read(files, &self.options()))
    }

    /// Reads a specification for further use: prints its warnings, and fails if there are errors.
    pub(crate) fn read_sound(&self, files: &[PathBuf]) -> Result<Analysis, Failure> {
        let analysis = self.read(files)?;
        let (said, rest) = first(&analysis.diagnostics, &analysis.sources, SHOWN);
        let mut told = human(&said, &analysis.sources, coloured_errors());
        if !rest.is_empty() {
            told.push_str(&format!("{rest}\n"));
        }
        io::stderr().lock().write_all(told.as_bytes())?;
        if analysis.has_errors() {
            let (errors, warnings) = counts(&analysis);
            return Err(Failure::Description { errors, warnings });
        }
        Ok(analysis)
    }
}

/// Number of errors and of warnings.
pub(crate) fn counts(analysis: &Analysis) -> (usize, usize) {
    (analysis.diagnostics.errors(), analysis.diagnostics.warnings())
}
