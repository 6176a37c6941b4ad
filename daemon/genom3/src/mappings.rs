//! Template `mappings`: the header of a component, on standard output (GenoM3 manual, "Mappings
//! template").

use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};

use clap::Parser;
use genom_description::preprocess;
use genom_description_tools::{self as tools, Language, Signatures};

use crate::input::Input;
use crate::stop::{Stop, print};
use crate::words::two_dashes;

/// Print the types of a component in C or C++.
#[derive(Debug, Parser)]
#[command(
    name = "genom3 mappings",
    disable_version_flag = true,
    override_usage = "genom3 mappings [--signature] [-l LANG] [-MD [-MF FILE] [-MT TARGET]] FILE.gen"
)]
struct Given {
    /// Language: c or c++ [default: that of the description].
    #[arg(short, long, value_name = "LANG")]
    language: Option<String>,
    /// Write the prototypes of codels, too.
    #[arg(long)]
    signature: bool,
    /// -MD: write the files that were read as a rule for `make`, to out.d.
    #[arg(long = "MD")]
    dependencies: bool,
    /// -MF FILE: write them there.
    #[arg(long = "MF", value_name = "FILE")]
    into: Option<PathBuf>,
    /// -MT TARGET: the target of the rule [default: out].
    #[arg(long = "MT", value_name = "TARGET")]
    target: Option<String>,
    /// The description.
    #[arg(required = true, value_name = "FILE.gen")]
    files: Vec<PathBuf>,
}

pub(crate) fn run(options: preprocess::Options, words: Vec<OsString>) -> Result<(), Stop> {
    let program = std::iter::once(OsString::from("genom3 mappings"));
    let given = Given::try_parse_from(program.chain(two_dashes(words)));
    let given = given.map_err(|error| Stop::told(&error))?;
    let input = Input { options, files: given.files };
    let analysis = input.read()?;
    let specification = &analysis.specification;
    let component = specification.components.first();
    let language = match given.language.as_deref() {
        None if component.is_some_and(|component| component.lang == "c++") => Language::Cxx,
        None | Some("c") => Language::C,
        Some("c++" | "cxx" | "cpp") => Language::Cxx,
        Some(other) => {
            return Err(Stop::Usage(format!("no mappings for language {other}: c or c++")));
        }
    };
    let signatures = if given.signature { Signatures::Written } else { Signatures::Omitted };
    let name = component.map(|component| component.name.as_str());
    let header = tools::mappings(specification, name, language, signatures)
        .map_err(|error| Stop::Failed(error.to_string()))?;
    if given.dependencies || given.into.is_some() {
        let into = given.into.unwrap_or_else(|| "out.d".into());
        let target = given.target.as_deref().unwrap_or("out");
        write(&into, &genom_project::dependencies(target, &analysis.sources))?;
    }
    print(&header)
}

/// Writes the rule. Its directory is usually automake's `.deps`, which may not exist yet.
fn write(path: &Path, text: &str) -> Result<(), Stop> {
    let parent = path.parent().filter(|parent| !parent.as_os_str().is_empty());
    let made = parent.map_or(Ok(()), fs::create_dir_all);
    let written = made.and_then(|()| fs::write(path, text));
    written.map_err(|error| Stop::Failed(format!("{}: {error}", path.display())))
}
