//! `#pragma requires` in the preprocessor: asks pkg-config for include directories.

use std::io;
use std::path::PathBuf;
use std::process::{Command, Stdio};

use super::Preprocessor;
use crate::diagnostic::Diagnostic;
use crate::source::Span;

/// Why a package was not found.
#[derive(Debug, thiserror::Error)]
enum PkgConfigError {
    /// pkg-config failed; the first line of its message.
    #[error("{0}")]
    Said(String),
    /// pkg-config failed without a message.
    #[error("{} says no more", program.display())]
    Silent { program: PathBuf },
    /// There is no pkg-config program.
    #[error("there is no program `{}` to find it", program.display())]
    Absent { program: PathBuf },
    /// The program cannot be run.
    #[error("cannot run `{}`: {source}", program.display())]
    Unusable { program: PathBuf, source: io::Error },
}

/// Most packages in one pragma (genom3.md 1.3).
const MAX_PACKAGES: usize = 8;

impl Preprocessor<'_> {
    /// Adds the include directories and definitions of packages for the text that follows.
    pub(super) fn require(&mut self, packages: &[(Box<str>, Span)], pragma: Span) {
        if packages.is_empty() || packages.len() > MAX_PACKAGES {
            let message = format!(
                "`#pragma requires` takes 1 to {MAX_PACKAGES} packages, {} given",
                packages.len()
            );
            self.diagnostics.push(
                Diagnostic::error("E0132", pragma, message)
                    .help("write `#pragma requires \"package >= 1.0\"`"),
            );
            return;
        }
        if let Some((option, span)) = packages.iter().find(|(name, _)| name.starts_with('-')) {
            let message = format!("`{option}` is no name of a package");
            self.diagnostics.push(Diagnostic::error("E0132", *span, message));
            return;
        }
        match self.ask(packages) {
            Ok(flags) => self.use_flags(&flags),
            Err(why) => self.missing(packages, &why),
        }
    }

    /// Runs pkg-config. Never through a shell: a description must not be able to run anything else.
    fn ask(&self, packages: &[(Box<str>, Span)]) -> Result<String, PkgConfigError> {
        let program = self.options.pkg_config.clone().unwrap_or_else(|| {
            let given = std::env::var_os("PKG_CONFIG").filter(|value| !value.is_empty());
            given.map_or_else(|| PathBuf::from("pkg-config"), PathBuf::from)
        });
        let mut command = Command::new(&program);
        command.arg("--cflags");
        command.args(packages.iter().map(|(package, _)| &**package));
        match command.stdin(Stdio::null()).output() {
            Ok(output) if output.status.success() => {
                Ok(String::from_utf8_lossy(&output.stdout).into_owned())
            }
            Ok(output) => {
                let said = String::from_utf8_lossy(&output.stderr);
                let first = said.lines().find(|line| !line.trim().is_empty());
                Err(match first {
                    Some(first) => PkgConfigError::Said(first.to_owned()),
                    None => PkgConfigError::Silent { program },
                })
            }
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                Err(PkgConfigError::Absent { program })
            }
            Err(source) => Err(PkgConfigError::Unusable { program, source }),
        }
    }

    fn use_flags(&mut self, flags: &str) {
        let mut defines = String::new();
        let words = split(flags);
        let mut words = words.iter();
        while let Some(word) = words.next() {
            let (flag, rest) = word.split_at_checked(2).unwrap_or((word, ""));
            let mut value = || {
                if rest.is_empty() { words.next().cloned() } else { Some(rest.to_owned()) }
            };
            match flag {
                "-I" => {
                    let dir = value().map(PathBuf::from);
                    let new = dir.filter(|dir| !self.include_dirs.contains(dir));
                    self.include_dirs.extend(new);
                }
                "-D" => {
                    let define = value().unwrap_or_default();
                    let (name, text) = define.split_once('=').unwrap_or((&define, "1"));
                    defines.push_str(&format!("#define {name} {text}\n"));
                }
                _ => {}
            }
        }
        self.read_synthetic("<pkg-config>", &defines);
    }

    /// Reports missing packages, as an error like GenoM3, unless `-I` says where their files are.
    fn missing(&mut self, packages: &[(Box<str>, Span)], why: &PkgConfigError) {
        let names: Vec<_> = packages.iter().map(|(name, _)| format!("`{name}`")).collect();
        let span = packages.first().map_or(Span::default(), |(_, span)| *span);
        let message = format!("package {} not found: {why}", names.join(", "));
        let instead = "name the directory of its .gen files with `-I DIR`";
        self.diagnostics.push(if self.options.include_dirs.is_empty() {
            let help = format!("install it, add its directory to PKG_CONFIG_PATH, or {instead}");
            Diagnostic::error("E0131", span, message).help(help)
        } else {
            let help = "its .gen files are looked for in the directories given with `-I`";
            Diagnostic::warning("W0106", span, message).help(help)
        });
    }
}

/// Splits pkg-config's output into words, as a shell would: at blanks, with quotes and backslashes.
fn split(flags: &str) -> Vec<String> {
    let mut words = Vec::new();
    let mut word: Option<String> = None;
    let mut quote = None;
    let mut chars = flags.chars();
    while let Some(c) = chars.next() {
        match (c, quote) {
            ('\\', None | Some('"')) => word.get_or_insert_default().extend(chars.next()),
            (_, Some(open)) if c == open => quote = None,
            ('"' | '\'', None) => {
                quote = Some(c);
                word.get_or_insert_default();
            }
            (_, None) if c.is_whitespace() => words.extend(word.take()),
            _ => word.get_or_insert_default().push(c),
        }
    }
    words.extend(word);
    words
}

#[cfg(test)]
mod tests {
    use super::split;

    #[test]
    fn flags_are_split_as_a_shell_would() {
        let words = split("-I/a/b  -I /c\\ d -DX=\"1 2\" '-I/e f'\n");
        assert_eq!(words, ["-I/a/b", "-I", "/c d", "-DX=1 2", "-I/e f"]);
    }
}
