//! `genomctl header`: types and prototypes for codels. No daemon.

use std::path::PathBuf;

use genom_description::tools::{Language, header};

use crate::failure::Failure;
use crate::session::Session;
use crate::verbs::check::Reading;

/// Print the header that codels of a description may include: types, events, prototypes.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The .gen files, read in order as one specification.
    #[arg(required = true)]
    files: Vec<PathBuf>,
    #[command(flatten)]
    reading: Reading,
    /// Language of the codels.
    #[arg(long, value_enum, default_value = "c")]
    lang: Lang,
    /// One component only.
    #[arg(long)]
    component: Option<String>,
}

#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum Lang {
    C,
    #[value(name = "c++", alias = "cxx")]
    Cxx,
    Rust,
}

pub(super) fn run(args: &Args, session: &Session) -> Result<(), Failure> {
    let specification = args.reading.understand(&args.files)?;
    let language = match args.lang {
        Lang::C => Language::C,
        Lang::Cxx => Language::Cxx,
        Lang::Rust => Language::Rust,
    };
    let text = header(&specification, args.component.as_deref(), language)
        .map_err(|error| Failure::refused("header", error.to_string()))?;
    session.print(&text)
}
