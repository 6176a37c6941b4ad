//! `#pragma requires` in the preprocessor: asks pkg-config for include directories.

use std::path::PathBuf;

use super::Preprocessor;
use crate::diagnostic::Diagnostic;
use crate::pkg_config::{PkgConfig, PkgConfigError};
use crate::source::Span;

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
        let option = |name: &str| name.trim_start().starts_with('-');
        if let Some((name, span)) = packages.iter().find(|(name, _)| option(name)) {
            let why = PkgConfigError::Option(name.trim_start().to_owned());
            self.diagnostics.push(Diagnostic::error("E0132", *span, why.to_string()));
            return;
        }
        let program = self.options.pkg_config.clone();
        let program = program.map_or_else(PkgConfig::default, PkgConfig::at);
        let names: Vec<&str> = packages.iter().map(|(name, _)| &**name).collect();
        match program.flags("--cflags", &names) {
            Ok(flags) => self.use_flags(&flags),
            Err(why) => self.missing(packages, &why),
        }
    }

    fn use_flags(&mut self, flags: &[String]) {
        let mut defines = String::new();
        let mut words = flags.iter();
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
