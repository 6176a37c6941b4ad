//! Template `skeleton`: codels and build files of a component (GenoM3 manual, "Skeleton template").

use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};

use clap::Parser;
use genom_description::model::Component;
use genom_description::{Analysis, preprocess};
use genom_project::skeleton::{Language, Merge, Source, autotools, merge, sheets};
use genom_project::{File, Written};

use crate::input::Input;
use crate::merge_tool::{Tool, settle};
use crate::stop::{Stop, print};

/// Write codels with empty bodies, and files to build them; or bring existing ones up to date.
#[derive(Debug, Parser)]
#[command(name = "genom3 skeleton", disable_version_flag = true)]
struct Given {
    /// Language of the sources: c or c++ [default: that of the description].
    #[arg(short, long, value_name = "LANG")]
    language: Option<String>,
    /// Where to write [default: the directory of the .gen file].
    #[arg(short = 'C', long, value_name = "DIRECTORY")]
    directory: Option<PathBuf>,
    /// Add missing functions to existing sources; functions whose parameters differ are settled by
    /// this tool, which gets the existing file and a proposal. `auto` marks them in the file,
    /// `interactive` asks.
    #[arg(short, long, value_name = "TOOL")]
    merge: Option<String>,
    /// The same as `-m interactive`.
    #[arg(short, conflicts_with_all = ["merge", "unattended", "force"])]
    interactive: bool,
    /// The same as `-m auto`.
    #[arg(short = 'u', conflicts_with_all = ["merge", "force"])]
    unattended: bool,
    /// Overwrite existing files.
    #[arg(short, long, conflicts_with = "merge")]
    force: bool,
    /// Write no comments on functions.
    #[arg(short, long)]
    terse: bool,
    /// The description.
    #[arg(required = true, value_name = "FILE.gen")]
    files: Vec<PathBuf>,
}

impl Given {
    /// How existing sources are merged; `None` if they are not.
    fn tool(&self) -> Option<Tool> {
        match self.merge.as_deref() {
            Some("auto") => Some(Tool::Marks),
            Some("interactive") => Some(Tool::Ask),
            Some(program) => Some(Tool::Program(program.to_owned())),
            None if self.interactive => Some(Tool::Ask),
            None if self.unattended => Some(Tool::Marks),
            None => None,
        }
    }

    fn language(&self, component: &Component) -> Result<Language, Stop> {
        let interface = Language::of(component);
        match (self.language.as_deref(), interface) {
            (None, _) => Ok(interface),
            (Some("c++" | "cxx" | "cpp"), _) => Ok(Language::Cxx),
            (Some("c"), Language::C) => Ok(Language::C),
            (Some(other), _) => Err(Stop::Usage(format!(
                "codels of an interface in {} cannot be written in {other}",
                component.lang
            ))),
        }
    }
}

pub(crate) fn run(options: preprocess::Options, words: Vec<OsString>) -> Result<(), Stop> {
    let program = std::iter::once(OsString::from("genom3 skeleton"));
    let given = Given::try_parse_from(program.chain(words)).map_err(|error| Stop::told(&error))?;
    let tool = given.tool();
    let input = Input { options, files: given.files.clone() };
    let analysis = input.read()?;
    if analysis.specification.components.is_empty() {
        let file = input.first().display();
        return Err(Stop::Failed(format!("{file}: declares no component")));
    }
    let beside = input.first().parent().unwrap_or(Path::new("")).to_owned();
    let directory = given.directory.clone().unwrap_or(beside);
    for component in &analysis.specification.components {
        let language = given.language(component)?;
        let sheets = sheets(&analysis.specification, component, language, given.terse);
        let build = autotools(component, &installed(&analysis, &input), language, &sheets);
        match &tool {
            Some(tool) => {
                let sources = sources(&directory.join("codels"))?;
                let merge = merge(&sheets, &sources);
                apply(&directory, &sources, &merge, tool, input.first())?;
            }
            None => {
                let codels = sheets.iter().map(|sheet| File::new(&sheet.path, sheet.text()));
                write(&directory, codels, given.force)?;
            }
        }
        write(&directory, build.into_iter(), given.force)?;
    }
    Ok(())
}

/// The files that are installed with the component: its description, and those beside it that it
/// includes.
fn installed(analysis: &Analysis, input: &Input) -> Vec<String> {
    let directory = |path: &Path| fs::canonicalize(path).ok()?.parent().map(Path::to_owned);
    let own = directory(input.first());
    let name = |path: &Path| Some(path.file_name()?.to_string_lossy().into_owned());
    let mut list: Vec<String> = name(input.first()).into_iter().collect();
    for (_, file) in analysis.sources.files().filter(|(_, file)| !file.is_synthetic()) {
        if directory(file.path()) == own
            && let Some(name) = name(file.path()).filter(|name| !list.contains(name))
        {
            list.push(name);
        }
    }
    list
}

fn write(directory: &Path, files: impl Iterator<Item = File>, force: bool) -> Result<(), Stop> {
    for file in files {
        let path = directory.join(&file.path);
        let word = match file.write(directory, force)? {
            Written::Created => "creating",
            Written::Replaced => "overwriting",
            Written::Same | Written::Kept => "keeping",
        };
        print(&format!("{word} {}\n", path.display()))?;
    }
    Ok(())
}

/// The C and C++ files of a directory.
fn sources(directory: &Path) -> Result<Vec<Source>, Stop> {
    let mut list = Vec::new();
    let entries = match fs::read_dir(directory) {
        Ok(entries) => entries,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(list),
        Err(error) => return Err(Stop::Failed(format!("{}: {error}", directory.display()))),
    };
    for entry in entries {
        let path = entry?.path();
        let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or_default();
        if ["c", "cc", "cpp", "cxx", "C"].contains(&ending) {
            let text = fs::read_to_string(&path)
                .map_err(|error| Stop::Failed(format!("{}: {error}", path.display())))?;
            let name = path.file_name().unwrap_or_default();
            list.push(Source { path: Path::new("codels").join(name), text });
        }
    }
    list.sort_by(|one, other| one.path.cmp(&other.path));
    Ok(list)
}

/// Writes what the merge added, and settles what differs.
fn apply(
    directory: &Path,
    sources: &[Source],
    merge: &Merge,
    tool: &Tool,
    description: &Path,
) -> Result<(), Stop> {
    for (function, path) in &merge.added {
        print(&format!("adding {function} to {}\n", directory.join(path).display()))?;
    }
    let new = |path: &Path| !sources.iter().any(|source| source.path == path);
    for created in merge.changed.iter().filter(|changed| new(&changed.path)) {
        File::new(&created.path, &created.text).write(directory, false)?;
    }
    for source in sources {
        settle(directory, source, merge, tool, description)?;
    }
    Ok(())
}
