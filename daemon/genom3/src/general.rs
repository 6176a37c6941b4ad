//! The general options, up to the name of a template.

use std::ffi::OsString;
use std::path::PathBuf;

use clap::{ArgAction, CommandFactory as _, Parser};
use genom_description::diagnostic::render::short;
use genom_description::preprocess::{GENOM, tokenize};
use genom_description::source::{Disk, SourceMap};
use genom_description::{preprocess, printed};

use crate::input::Input;
use crate::stop::{Stop, print};
use crate::{cmake, mappings, server, skeleton};

/// What GenoM3's tool is to the builds of components, for components that run in genomd.
#[derive(Debug, Parser)]
#[command(
    name = "genom3",
    disable_version_flag = true,
    override_usage = "genom3 [OPTIONS] TEMPLATE [TEMPLATE OPTIONS] FILE.gen\n       \
        genom3 [OPTIONS] -E|-n|-N FILE.gen...\n       genom3 -l"
)]
struct General {
    /// Directory for #include; may be repeated.
    #[arg(short = 'I', value_name = "DIRECTORY")]
    include: Vec<PathBuf>,
    /// Definition for the preprocessor; may be repeated.
    #[arg(short = 'D', value_name = "MACRO[=VALUE]")]
    define: Vec<String>,
    /// Print what the preprocessor makes of the files, and stop.
    #[arg(short = 'E', group = "stage")]
    preprocess: bool,
    /// Check the files, and stop; the exit status is the number of errors.
    #[arg(short = 'n', long, group = "stage")]
    parse_only: bool,
    /// Print the whole specification, with all included files, in the language of .gen files.
    #[arg(short = 'N', long, group = "stage")]
    dump: bool,
    /// List the templates.
    #[arg(short = 'l', long)]
    list: bool,
    /// Print the version.
    #[arg(long)]
    version: bool,
    /// Ignored: templates are part of the program.
    #[arg(short = 't', long, value_name = "PATH", hide_short_help = true)]
    tmpldir: Option<PathBuf>,
    /// Ignored: there is no generator.
    #[arg(short = 's', long, value_name = "DIRECTORY", hide_short_help = true)]
    sysdir: Option<PathBuf>,
    /// Ignored: there are no temporary files.
    #[arg(short = 'T', long, value_name = "DIRECTORY", hide_short_help = true)]
    tmpdir: Option<PathBuf>,
    /// Ignored.
    #[arg(short = 'r', long, hide_short_help = true)]
    rename: bool,
    /// Ignored.
    #[arg(short = 'v', long, action = ArgAction::Count, hide_short_help = true)]
    verbose: u8,
    /// Ignored.
    #[arg(short = 'd', long, hide_short_help = true)]
    debug: bool,
}

/// The templates, with what each is for.
const TEMPLATES: &[(&str, &str)] = &[
    ("genomd/cmake", "what the CMake package of genomd asks of a description"),
    ("genomd/server", "a directory of a build, which installs the program NAME-genomd"),
    ("mappings", "the header that codels are compiled against"),
    ("skeleton", "codels and build files of a new component, or what an existing one lacks"),
];

pub(crate) fn run(arguments: Vec<OsString>) -> Result<(), Stop> {
    let mut options = arguments;
    let mut words = options.split_off(general(&options));
    options.insert(0, "genom3".into());
    let given = General::try_parse_from(options).map_err(|error| Stop::told(&error))?;
    if given.version {
        let version = env!("CARGO_PKG_VERSION");
        return print(&format!("genom3 {GENOM}\nPart of genomd {version}.\n"));
    }
    if given.list {
        return print(&TEMPLATES.iter().map(|(name, _)| format!("{name}\n")).collect::<String>());
    }
    let options = preprocess::Options {
        include_dirs: given.include,
        defines: given.define,
        ..preprocess::Options::default()
    };
    if given.preprocess || given.parse_only || given.dump {
        let files = words.into_iter().map(PathBuf::from).collect();
        let input = Input { options, files };
        return match (given.preprocess, given.dump) {
            (true, _) => tokens(&input, true).and_then(|text| print(&text)),
            (_, true) => dump(&input),
            _ => input.read().map(drop),
        };
    }
    if words.is_empty() {
        return Err(Stop::told(&General::command().error(
            clap::error::ErrorKind::MissingRequiredArgument,
            "name a template and a .gen file, or an option that needs no template",
        )));
    }
    let template = words.remove(0);
    match &*template.to_string_lossy() {
        "mappings" => mappings::run(options, words),
        "skeleton" => skeleton::run(options, words),
        "genomd/cmake" => cmake::run(options, words),
        "genomd/server" => server::run(options, words),
        other => Err(Stop::Usage(unknown(other))),
    }
}

/// How many words are general options: those before the first word that is neither an option nor the
/// value of one.
fn general(words: &[OsString]) -> usize {
    const VALUED: &[&str] = &["-I", "-D", "-t", "-s", "-T", "--tmpldir", "--sysdir", "--tmpdir"];
    let mut at = 0;
    while let Some(word) = words.get(at).map(|word| word.to_string_lossy()) {
        if !word.starts_with('-') {
            break;
        }
        at += if VALUED.contains(&&*word) { 2 } else { 1 };
    }
    at.min(words.len())
}

fn unknown(name: &str) -> String {
    if name.ends_with(".gen") {
        return format!("name a template before {name}, or write `genom3 -n {name}` to check it");
    }
    let list: String = TEMPLATES.iter().map(|(name, what)| format!("\n  {name}: {what}")).collect();
    format!(
        "no template `{name}`. Servers and clients for a middleware are not generated: genomd binds \
         components to middlewares when it runs them. The templates are:{list}"
    )
}

/// The preprocessed text; errors of the preprocessor are printed.
fn tokens(input: &Input, markers: bool) -> Result<String, Stop> {
    input.check()?;
    let mut sources = SourceMap::new();
    let (tokens, diagnostics) = tokenize(&input.files, &input.options, &Disk, &mut sources);
    let text = printed(&tokens, &sources, markers);
    std::io::Write::write_all(&mut std::io::stderr(), short(&diagnostics, &sources).as_bytes())?;
    match diagnostics.errors() {
        0 => Ok(text),
        errors => {
            print(&text)?;
            Err(Stop::Errors(errors))
        }
    }
}

/// The specification: what the preprocessor makes of the files, formatted.
fn dump(input: &Input) -> Result<(), Stop> {
    input.read()?;
    let text = tokens(input, false)?;
    print(&genom_description_tools::format_text(&text).unwrap_or(text))
}
