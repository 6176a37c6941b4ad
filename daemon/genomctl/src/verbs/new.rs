//! `genomctl new`: a new component. No daemon.

use std::path::{Path, PathBuf};

use genom_description::pkg_config::PkgConfig;
use genom_project::new::{Codels, Tool, files, library, refused};
use genom_project::skeleton::Language;
use genom_project::{Written, sdk};
use serde_json::json;

use crate::failure::Failure;
use crate::session::Session;

/// Make a new component: a directory with a description, codels, build files, a deployment and a
/// test. It builds and runs as it is.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Its name: a letter, then letters, digits and _.
    name: String,
    /// Language of the codels.
    #[arg(long, value_enum, default_value_t = Lang::C)]
    lang: Lang,
    /// What builds codels in C and C++; cargo builds those in Rust [default: cmake].
    #[arg(long, value_enum, value_name = "TOOL")]
    with: Option<With>,
    /// The directory [default: the name].
    #[arg(long, short = 'C', value_name = "DIRECTORY")]
    directory: Option<PathBuf>,
    /// For Rust: where the crate `genom` is [default: where genomd is installed].
    #[arg(long, value_name = "DIRECTORY")]
    sdk: Option<PathBuf>,
}

#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum Lang {
    C,
    #[value(name = "c++", alias = "cpp", alias = "cxx")]
    Cxx,
    Rust,
    Python,
    Lua,
}

#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum With {
    /// The package that genomd installs.
    Cmake,
    /// pkg-config.
    Meson,
    /// As GenoM3's components: autoconf, automake and libtool.
    Autotools,
}

impl Args {
    fn compiled(&self, language: Language) -> Codels<'static> {
        let tool = match self.with {
            None | Some(With::Cmake) => Tool::CMake,
            Some(With::Meson) => Tool::Meson,
            Some(With::Autotools) => Tool::Autotools,
        };
        Codels::Compiled(language, tool)
    }
}

pub(super) fn run(args: &Args, session: &Session) -> Result<(), Failure> {
    if let Some(why) = refused(&args.name) {
        return Err(Failure::usage(why, "for example `genomctl new my_arm`"));
    }
    let directory = args.directory.clone().unwrap_or_else(|| PathBuf::from(&args.name));
    let crates;
    let codels = match args.lang {
        Lang::C => args.compiled(Language::C),
        Lang::Cxx => args.compiled(Language::Cxx),
        Lang::Python | Lang::Lua if args.with.is_some() => {
            let message = format!("nothing builds codels in {:?}", args.lang);
            return Err(Failure::usage(message, "leave out --with"));
        }
        Lang::Python => Codels::Python,
        Lang::Lua => Codels::Lua,
        Lang::Rust if args.with.is_some() => {
            let message = "cargo builds components in Rust".to_owned();
            return Err(Failure::usage(message, "leave out --with"));
        }
        Lang::Rust => {
            crates = rust_sdk(args.sdk.as_deref())?;
            Codels::Rust { sdk: &crates }
        }
    };
    let files = files(&args.name, codels);
    // All or nothing: nothing is mixed with files that are there already.
    if let Some(there) = files.iter().map(|file| directory.join(&file.path)).find(|p| p.exists()) {
        let message = format!("{} exists already", there.display());
        return Err(Failure::usage(message, "name another directory with -C"));
    }
    let mut text = String::new();
    for file in &files {
        if file.write(&directory, false)? == Written::Created {
            text.push_str(&format!("created {}\n", directory.join(&file.path).display()));
        }
    }
    let place = directory.display();
    let library = library(&args.name, codels);
    let built = match codels {
        Codels::Compiled(..) | Codels::Rust { .. } => format!("genomctl build {place} && "),
        Codels::Python | Codels::Lua => String::new(),
    };
    text.push_str(&format!("next: {built}genomd {place}/{library}\n"));
    if session.json {
        let list: Vec<_> = files.iter().map(|file| directory.join(&file.path)).collect();
        return session.print(&format!("{}\n", json!({ "files": list })));
    }
    session.print(&text)
}

/// The directory of the crate `genom`: the one given, that of the prefix that this program is
/// installed in, or that of the package `genomd` that pkg-config knows.
fn rust_sdk(given: Option<&Path>) -> Result<PathBuf, Failure> {
    let there = |directory: &PathBuf| directory.join("Cargo.toml").is_file();
    if let Some(given) = given {
        let directory = std::path::absolute(given)?;
        if there(&directory) {
            return Ok(directory);
        }
        let message = format!("{}: no Cargo.toml there", directory.display());
        return Err(Failure::usage(message, "name the directory PREFIX/share/genomd/rust"));
    }
    let program = std::env::current_exe()?;
    let bin = program.parent().filter(|directory| directory.ends_with("bin"));
    let own = bin.and_then(Path::parent).map(|prefix| prefix.join(sdk::RUST));
    let known = || PkgConfig::default().variable("genomd", "rustdir").ok().map(PathBuf::from);
    own.filter(there).or_else(|| known().filter(there)).ok_or_else(|| {
        Failure::refused_with(
            "new",
            "the crate `genom`, which components in Rust link, is not installed".to_owned(),
            "`genomctl sdk PREFIX` installs it; then --sdk PREFIX/share/genomd/rust".to_owned(),
        )
    })
}
