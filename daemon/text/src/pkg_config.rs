//! Questions to pkg-config: the flags and variables of installed packages.
//!
//! Names of packages come from descriptions, which must not be able to run anything: no shell sees
//! them, and one that pkg-config would take for an option is refused.

use std::io;
use std::path::PathBuf;
use std::process::{Command, Stdio};

/// Why pkg-config gave no answer.
#[derive(Debug, thiserror::Error)]
pub enum PkgConfigError {
    /// The name begins as an option does.
    #[error("`{0}` is no name of a package")]
    Option(String),
    /// pkg-config failed; the first line of its message.
    #[error("{0}")]
    Said(String),
    /// pkg-config failed without a message.
    #[error("{} says no more", program.display())]
    Silent {
        /// The program.
        program: PathBuf,
    },
    /// There is no pkg-config program.
    #[error("there is no program `{}` to find it", program.display())]
    Absent {
        /// The program.
        program: PathBuf,
    },
    /// The program cannot be run.
    #[error("cannot run `{}`: {source}", program.display())]
    Unusable {
        /// The program.
        program: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The answer ends within quotes.
    #[error("{} answers with a quote that is never closed: {answer}", program.display())]
    Unclosed {
        /// The program.
        program: PathBuf,
        /// The answer.
        answer: String,
    },
}

/// The program.
#[derive(Clone, Debug)]
pub struct PkgConfig {
    program: PathBuf,
    /// Whether directories that every compiler searches are told, too.
    system: bool,
}

impl Default for PkgConfig {
    /// `$PKG_CONFIG`, else `pkg-config`.
    fn default() -> Self {
        let given = std::env::var_os("PKG_CONFIG").filter(|value| !value.is_empty());
        Self::at(given.map_or_else(|| PathBuf::from("pkg-config"), PathBuf::from))
    }
}

impl PkgConfig {
    /// This program.
    #[must_use]
    pub fn at(program: PathBuf) -> Self {
        Self { program, system: false }
    }

    /// Has directories told, too, that every compiler searches.
    #[must_use]
    pub fn with_system_directories(self) -> Self {
        Self { system: true, ..self }
    }

    /// Flags of packages: `question` is `--cflags`, `--libs` or one of their kind. A package may be
    /// written with a version, as in `opencv4 >= 4.2`. The answer is split into words as a shell
    /// does.
    ///
    /// # Errors
    /// A package is not known, or the program cannot be run.
    pub fn flags<T: AsRef<str>>(
        &self,
        question: &str,
        packages: &[T],
    ) -> Result<Vec<String>, PkgConfigError> {
        self.words(&self.ask(question, packages)?)
    }

    /// A variable of a package, such as `idldir`; empty if the package does not have it.
    ///
    /// # Errors
    /// As for [`flags`](Self::flags).
    pub fn variable(&self, package: &str, name: &str) -> Result<String, PkgConfigError> {
        let answer = self.ask(&format!("--variable={name}"), &[package])?;
        // A prefix that is found from where the file is has its blanks quoted; one that the file
        // names has not.
        match answer.contains(['\\', '"', '\'']) {
            true => Ok(self.words(&answer)?.join(" ")),
            false => Ok(answer),
        }
    }

    fn words(&self, answer: &str) -> Result<Vec<String>, PkgConfigError> {
        shlex::split(answer).ok_or_else(|| PkgConfigError::Unclosed {
            program: self.program.clone(),
            answer: answer.to_owned(),
        })
    }

    fn ask<T: AsRef<str>>(&self, question: &str, packages: &[T]) -> Result<String, PkgConfigError> {
        let names = packages.iter().map(|package| package.as_ref().trim_start());
        if let Some(option) = names.clone().find(|name| name.starts_with('-')) {
            return Err(PkgConfigError::Option(option.to_owned()));
        }
        let program = self.program.clone();
        let mut command = Command::new(&program);
        command.arg(question).args(names).stdin(Stdio::null());
        if self.system {
            command.env("PKG_CONFIG_ALLOW_SYSTEM_LIBS", "1");
            command.env("PKG_CONFIG_ALLOW_SYSTEM_CFLAGS", "1");
        }
        match command.output() {
            Ok(output) if output.status.success() => {
                Ok(String::from_utf8_lossy(&output.stdout).trim().to_owned())
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
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A stand-in that answers with its arguments.
    fn echo() -> PkgConfig {
        PkgConfig::at("echo".into())
    }

    #[test]
    fn flags_are_split_as_a_shell_does() {
        let packages = ["b >= 1.0", "/c\\ d", "-DX=\"1 2\"", "'-I/e f'"];
        let (plain, quoted) = packages.split_at(1);
        assert_eq!(echo().flags("--cflags", plain).unwrap(), ["--cflags", "b", ">=", "1.0"]);
        let answer = quoted.join("  ");
        assert_eq!(echo().words(&answer).unwrap(), ["/c d", "-DX=1 2", "-I/e f"]);
        let told = echo().flags("--cflags", &["'/a"]).unwrap_err().to_string();
        assert!(told.contains("never closed: --cflags '/a"), "{told}");
    }

    #[test]
    fn a_variable_keeps_its_blanks_whether_they_are_quoted_or_not() {
        for answer in ["/a b/idl", "/a\\ b/idl", "'/a b/idl'", "\"/a b/idl\""] {
            assert_eq!(echo().variable(answer, "idldir").unwrap(), "--variable=idldir /a b/idl");
        }
        assert_eq!(PkgConfig::at("true".into()).variable("a", "idldir").unwrap(), "");
    }

    #[test]
    fn what_pkg_config_would_take_for_an_option_is_refused() {
        for name in ["--define-variable=prefix=/tmp", "-I/tmp", " --version"] {
            let refused = echo().flags("--libs", &["sound", name]).unwrap_err();
            assert!(matches!(refused, PkgConfigError::Option(_)), "{refused}");
            let refused = echo().variable(name, "libdir").unwrap_err();
            assert!(matches!(refused, PkgConfigError::Option(_)), "{refused}");
        }
    }

    #[test]
    fn a_missing_program_and_a_missing_package_are_told_apart() {
        let ask = |program: &str| {
            PkgConfig::at(program.into()).flags("--cflags", &["/nowhere/package"]).unwrap_err()
        };
        assert!(matches!(ask("/nowhere/pkg-config"), PkgConfigError::Absent { .. }));
        assert!(matches!(ask("false"), PkgConfigError::Silent { .. }));
        let told = ask("ls");
        assert!(matches!(&told, PkgConfigError::Said(_)), "{told}");
        assert!(told.to_string().contains("--cflags"), "{told}");
    }
}
