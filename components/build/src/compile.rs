//! Builds libraries of codels in C and C++ with the system's compilers.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::UNIX_EPOCH;

use crate::error::BuildError;
use crate::paths::Paths;
use crate::recipe::{Recipe, files};

/// With debug information the host can check the codels. Without contraction of `a * b + c` codels
/// in different languages compute the same bits.
const FLAGS: [&str; 9] = [
    "-g",
    "-O1",
    "-fPIC",
    "-Wall",
    "-Wextra",
    "-Werror",
    "-ffp-contract=off",
    "-fno-omit-frame-pointer",
    "-pthread",
];

/// The compiler for a language.
struct Compiler {
    program: String,
    variable: &'static str,
    standard: &'static str,
}

impl Compiler {
    fn of(source: &Path) -> Self {
        if source.extension().is_some_and(|extension| extension == "cc") {
            Self::from_environment("CXX", "c++", "-std=c++17")
        } else {
            Self::from_environment("CC", "cc", "-std=gnu11")
        }
    }

    fn from_environment(variable: &'static str, usual: &str, standard: &'static str) -> Self {
        let program = std::env::var(variable).unwrap_or_else(|_| usual.to_owned());
        Self { program, variable, standard }
    }
}

/// Builds `library` from the codels of `recipe`, unless it is up to date.
pub(crate) fn library(paths: &Paths, recipe: &Recipe, library: &Path) -> Result<(), BuildError> {
    let include = paths.root.join("plugin-api/include");
    let sources = recipe.sources()?;
    let directory = library.parent().unwrap_or(Path::new("."));
    let mut commands = Vec::new();
    let mut objects = Vec::new();
    for source in &sources {
        let compiler = Compiler::of(source);
        let object = directory.join(source.file_name().unwrap_or_default()).with_extension("o");
        let mut command = Command::new(&compiler.program);
        command.args(FLAGS).arg(compiler.standard).arg("-c");
        for directory in [&include, &recipe.directory, &recipe.directory.join("codels")] {
            command.arg("-I").arg(directory);
        }
        command.arg(source).arg("-o").arg(&object);
        commands.push((compiler, command));
        objects.push(object);
    }

    // A library with C++ sources is linked by the C++ compiler.
    let cpp = sources.iter().find(|source| source.extension().is_some_and(|found| found == "cc"));
    let compiler = Compiler::of(cpp.or(sources.first()).map_or(Path::new(""), PathBuf::as_path));
    let fresh = library.with_extension("so.fresh");
    let mut command = Command::new(&compiler.program);
    command.args(["-shared", "-pthread"]).args(&objects).arg("-lm").arg("-o").arg(&fresh);
    commands.push((compiler, command));

    let mut inputs = sources;
    inputs.extend(recipe.headers()?);
    inputs.extend(recipe.descriptions.iter().cloned());
    inputs.extend(files(&include.join("genom"), &["h"])?);
    inputs.extend(files(&include.join("genom3/c"), &["h"])?);
    inputs.extend(files(&include.join("genom3/c++"), &["h"])?);
    let made_of = fingerprint(&commands, &inputs)?;
    let record = library.with_extension("so.made-of");
    if library.exists() && std::fs::read_to_string(&record).is_ok_and(|old| old == made_of) {
        return Ok(());
    }

    for (compiler, command) in &mut commands {
        run(compiler, command)?;
    }
    // Renamed, so that a daemon that has the old library mapped keeps the old file.
    std::fs::rename(&fresh, library).map_err(BuildError::file(library))?;
    for object in objects {
        std::fs::remove_file(&object).map_err(BuildError::file(&object))?;
    }
    std::fs::write(&record, made_of).map_err(BuildError::file(&record))
}

/// The commands, and date and size of each input, as text to compare with that of the last build.
fn fingerprint(commands: &[(Compiler, Command)], inputs: &[PathBuf]) -> Result<String, BuildError> {
    let mut text = String::new();
    for (_, command) in commands {
        let _ = writeln!(text, "{command:?}");
    }
    for input in inputs {
        let metadata = std::fs::metadata(input).map_err(BuildError::file(input))?;
        let date = metadata.modified().map_err(BuildError::file(input))?;
        let date = date.duration_since(UNIX_EPOCH).unwrap_or_default().as_nanos();
        let _ = writeln!(text, "{} {date} {}", input.display(), metadata.len());
    }
    Ok(text)
}

fn run(compiler: &Compiler, command: &mut Command) -> Result<(), BuildError> {
    let output = command.output().map_err(|source| BuildError::Program {
        program: compiler.program.clone(),
        variable: compiler.variable,
        source,
    })?;
    if output.status.success() {
        return Ok(());
    }
    Err(BuildError::Refused {
        command: format!("{command:?}"),
        output: String::from_utf8_lossy(&output.stderr).into_owned(),
    })
}
