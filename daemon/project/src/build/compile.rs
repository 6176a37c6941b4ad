//! Runs the compilers.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::SystemTime;

use super::error::BuildError;

/// With debug information genomd compares the codels with the description at load.
const FLAGS: &[&str] = &["-g", "-O2", "-fPIC", "-Wall", "-pthread", "-fno-omit-frame-pointer"];

/// A compiler: which, and what selects another.
pub(super) struct Compiler {
    program: String,
    variable: &'static str,
    flags: Vec<String>,
}

impl Compiler {
    /// The compiler for C++ or C: `$CXX` with `$CXXFLAGS`, or `$CC` with `$CFLAGS`.
    pub(super) fn new(cxx: bool) -> Self {
        let (variable, usual, flags) =
            if cxx { ("CXX", "c++", "CXXFLAGS") } else { ("CC", "cc", "CFLAGS") };
        let set = |name: &str| std::env::var(name).ok().filter(|value| !value.trim().is_empty());
        let mut program = set(variable).unwrap_or_else(|| usual.to_owned());
        // `CC="ccache gcc"` and `CC="gcc -m32"` are usual.
        let mut more: Vec<String> = program.split_whitespace().skip(1).map(str::to_owned).collect();
        program = program.split_whitespace().next().unwrap_or(usual).to_owned();
        more.extend(
            set(flags).iter().flat_map(|value| value.split_whitespace()).map(str::to_owned),
        );
        Self { program, variable, flags: more }
    }

    fn command(&self) -> Command {
        let mut command = Command::new(&self.program);
        // Messages are looked through for the names of codels.
        command.env("LC_ALL", "C").args(&self.flags);
        command
    }

    fn output(&self, command: &mut Command) -> Result<(bool, String), BuildError> {
        let output = command.output().map_err(|source| BuildError::Program {
            program: self.program.clone(),
            variable: self.variable,
            source,
        })?;
        Ok((output.status.success(), String::from_utf8_lossy(&output.stderr).into_owned()))
    }

    /// Compiles `source` into `object` unless that is newer than all it was made of. Returns whether
    /// it succeeded, and what the compiler said.
    pub(super) fn object(
        &self,
        source: &Path,
        object: &Path,
        flags: &[String],
    ) -> Result<(bool, String), BuildError> {
        let rule = object.with_extension("d");
        let mut command = self.command();
        command.args(FLAGS).args(flags).arg("-MMD").arg("-MF").arg(&rule);
        command.arg("-c").arg(source).arg("-o").arg(object);
        let line = format!("{command:?}");
        let record = object.with_extension("command");
        let same = fs::read_to_string(&record).is_ok_and(|before| before == line);
        if same && is_newer(object, &rule) {
            return Ok((true, String::new()));
        }
        let (sound, told) = self.output(&mut command)?;
        // What gave warnings is compiled again next time, so that they are seen again.
        if sound && told.is_empty() {
            fs::write(&record, line).map_err(BuildError::file(&record))?;
        } else {
            let _ = fs::remove_file(&record);
        }
        Ok((sound, told))
    }

    /// Links objects into a shared library. An existing one is replaced at once, so that a daemon
    /// that watches it never sees half of it.
    pub(super) fn library(
        &self,
        objects: &[PathBuf],
        library: &Path,
        flags: &[String],
    ) -> Result<(bool, String), BuildError> {
        let fresh = library.with_extension("so.fresh");
        let mut command = self.command();
        command.args(["-shared", "-pthread"]).args(objects).args(flags).arg("-lm");
        let result = self.output(command.arg("-o").arg(&fresh))?;
        if result.0 {
            fs::rename(&fresh, library).map_err(BuildError::file(library))?;
        }
        Ok(result)
    }
}

/// Whether the object is newer than all files that the rule beside it names.
fn is_newer(object: &Path, rule: &Path) -> bool {
    let date = |path: &Path| fs::metadata(path).and_then(|data| data.modified()).ok();
    let (Some(made), Ok(text)) = (date(object), fs::read_to_string(rule)) else { return false };
    let joined = text.replace("\\\n", " ").replace("\\ ", "\u{0}");
    let Some((_, files)) = joined.split_once(": ") else { return false };
    let older = |file: &str| {
        let path = file.replace('\u{0}', " ");
        date(Path::new(&path)).is_some_and(|date: SystemTime| date < made)
    };
    files.split_whitespace().all(older)
}
