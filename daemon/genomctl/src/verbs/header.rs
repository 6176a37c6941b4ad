//! `genomctl header`: prints the header that codels are compiled against. No daemon.

use std::path::PathBuf;

use genom_description_tools::{self as tools, Language};

use crate::failure::Failure;
use crate::reading::Reading;
use crate::session::Session;

/// Print the types of a component and the prototypes of its codels, as a header to compile codels
/// with.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The .gen files, read in order as one specification.
    #[arg(required = true)]
    files: Vec<PathBuf>,
    /// Language of the codels.
    #[arg(long, value_enum, default_value_t = Lang::C)]
    lang: Lang,
    /// One component [default: all].
    #[arg(long, value_name = "NAME")]
    component: Option<String>,
    #[command(flatten)]
    reading: Reading,
}

#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum Lang {
    C,
    #[value(name = "c++", alias = "cpp", alias = "cxx")]
    Cxx,
    Rust,
    /// A stub of the types for editors, to be kept as `NAME_types.pyi` beside the codels.
    Python,
}

pub(super) fn run(args: &Args, session: &Session) -> Result<(), Failure> {
    let analysis = args.reading.read_sound(&args.files)?;
    let language = match args.lang {
        Lang::C => Language::C,
        Lang::Cxx => Language::Cxx,
        Lang::Rust => Language::Rust,
        Lang::Python => Language::Python,
    };
    let header = tools::header(&analysis.specification, args.component.as_deref(), language)
        .map_err(|error| Failure::refused("header", error.to_string()))?;
    session.print_text("header", &header)
}
