//! Template `genomd/cmake`: what the CMake package asks of a description, as commands of CMake on
//! standard output.

use std::ffi::OsString;
use std::path::PathBuf;

use clap::Parser;
use genom_description::preprocess;
use genom_project::skeleton::header_name;

use crate::input::Input;
use crate::stop::{Stop, print};

/// Print name, header and requirements of a component as commands of CMake.
#[derive(Debug, Parser)]
#[command(name = "genom3 genomd/cmake", disable_version_flag = true)]
struct Given {
    /// The description.
    #[arg(required = true, value_name = "FILE.gen")]
    files: Vec<PathBuf>,
}

pub(crate) fn run(options: preprocess::Options, words: Vec<OsString>) -> Result<(), Stop> {
    let program = std::iter::once(OsString::from("genom3 genomd/cmake"));
    let given = Given::try_parse_from(program.chain(words)).map_err(|error| Stop::told(&error))?;
    let input = Input { options, files: given.files };
    let analysis = input.read()?;
    let component = input.component(&analysis)?;
    let packages: Vec<String> = component
        .requires
        .iter()
        .chain(&component.codels_requires)
        // What GenoM3 itself gives is in target genomd::headers.
        .filter(|package| package.split_whitespace().next() != Some("genom3"))
        // pkg_check_modules wants `a>=1`.
        .map(|package| package.replace(' ', ""))
        .collect();
    // The files below the description's directory are copied beside the library.
    let directory = input.first().parent().map(PathBuf::from).unwrap_or_default();
    let files: Vec<String> = analysis
        .sources
        .files()
        .filter(|(_, file)| !file.is_synthetic() && file.path().parent() == Some(&directory))
        .map(|(_, file)| file.path().display().to_string())
        .collect();
    let interface = if component.lang == "c++" { "c++" } else { "c" };
    let mut text = String::new();
    for (name, values) in [
        ("COMPONENT", vec![component.name.clone()]),
        ("INTERFACE", vec![interface.to_owned()]),
        ("HEADER", vec![header_name(component)]),
        ("REQUIRES", packages),
        ("DESCRIPTIONS", files),
    ] {
        let values: String = values.iter().map(|value| format!(" [==[{value}]==]")).collect();
        text.push_str(&format!("set(GENOMD_{name}{values})\n"));
    }
    print(&text)
}
