//! Template `genomd/server`: the directory that AG_OUTPUT_TEMPLATES of a component's build asks for.

use std::ffi::OsString;
use std::path::PathBuf;

use clap::Parser;
use genom_description::preprocess;

use crate::input::Input;
use crate::stop::{Stop, print};

/// Write a directory of a build, which installs the program NAME-genomd.
#[derive(Debug, Parser)]
#[command(name = "genom3 genomd/server", disable_version_flag = true)]
struct Given {
    /// Where to write it [default: the current directory].
    #[arg(short = 'C', long, value_name = "DIRECTORY", default_value = ".")]
    directory: PathBuf,
    /// The description.
    #[arg(required = true, value_name = "FILE.gen")]
    files: Vec<PathBuf>,
}

pub(crate) fn run(options: preprocess::Options, words: Vec<OsString>) -> Result<(), Stop> {
    let program = std::iter::once(OsString::from("genom3 genomd/server"));
    let given = Given::try_parse_from(program.chain(words)).map_err(|error| Stop::told(&error))?;
    let input = Input { options, files: given.files };
    let analysis = input.read()?;
    let component = input.component(&analysis)?;
    for file in genom_project::server::server(component) {
        let path = given.directory.join(&file.path);
        file.write(&given.directory, true)?;
        print(&format!("creating {}\n", path.display()))?;
    }
    Ok(())
}
