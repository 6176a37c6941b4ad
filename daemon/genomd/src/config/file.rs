//! The configuration file.

use std::collections::BTreeMap;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::{ClockKind, LoadRequest};
use crate::nearest::nearest;

/// A configuration file; `configs/default.toml` shows every key with its default.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct Config {
    /// Middleware of ports and services.
    pub(crate) backend: String,
    /// Directories to look for components in.
    pub(crate) path: Vec<PathBuf>,
    /// Directories for the descriptions' `#include`.
    pub(crate) include: Vec<PathBuf>,
    /// What to log.
    pub(crate) log: String,
    /// Time of the components.
    pub(crate) clock: ClockKind,
    /// Seconds the start codel of a task may take.
    pub(crate) start_timeout: u64,
    /// Seconds a component may take to stop.
    pub(crate) stop_timeout: u64,
    /// The control plane.
    pub(crate) rpc: Rpc,
    /// Options of middlewares, by name: each knows its own.
    pub(crate) backends: BTreeMap<String, toml::Table>,
    /// Components to load, in order, before those of the command line.
    pub(crate) component: Vec<LoadRequest>,
}

/// Section `[rpc]`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct Rpc {
    /// Unix socket.
    pub(crate) socket: Option<PathBuf>,
    /// Loopback TCP address.
    pub(crate) listen: Option<SocketAddr>,
    /// Greatest size of a request's body, in bytes.
    pub(crate) max_body: usize,
    /// Connections served at a time.
    pub(crate) max_connections: usize,
    /// Open streams at a time.
    pub(crate) max_streams: usize,
    /// Seconds the result of an ended activity stays readable.
    pub(crate) keep_results: u64,
}

impl Default for Config {
    fn default() -> Self {
        Self {
            backend: "local".to_owned(),
            path: Vec::new(),
            include: Vec::new(),
            log: "info".to_owned(),
            clock: ClockKind::Monotonic,
            start_timeout: 60,
            stop_timeout: 10,
            rpc: Rpc::default(),
            backends: BTreeMap::new(),
            component: Vec::new(),
        }
    }
}

impl Default for Rpc {
    fn default() -> Self {
        Self {
            socket: None,
            listen: None,
            max_body: 1 << 20,
            max_connections: 256,
            max_streams: 64,
            keep_results: 300,
        }
    }
}

/// A configuration file cannot be used.
#[derive(Debug, thiserror::Error)]
pub(crate) enum ConfigError {
    /// Missing or unreadable.
    #[error("{}: cannot be read: {source}", path.display())]
    Read { path: PathBuf, source: std::io::Error },
    /// A mistake in it.
    #[error("{}:{line}: {message}{}", path.display(), suggestion(.nearest))]
    Mistake { path: PathBuf, line: usize, message: String, nearest: Option<String> },
}

fn suggestion(nearest: &Option<String>) -> String {
    nearest.as_ref().map(|name| format!("; did you mean `{name}`?")).unwrap_or_default()
}

impl Config {
    /// Reads a file; relative paths in it start from its directory.
    pub(crate) fn read(path: &Path) -> Result<Self, ConfigError> {
        let text = std::fs::read_to_string(path)
            .map_err(|source| ConfigError::Read { path: path.to_owned(), source })?;
        let mut config = Self::parse(path, &text)?;
        let base = path.parent().unwrap_or(Path::new(""));
        config.path.iter_mut().chain(&mut config.include).for_each(|dir| anchor(base, dir));
        for component in &mut config.component {
            // A bare name is looked for on the component path, not beside the configuration.
            if component.library.components().count() > 1 || component.library.extension().is_some()
            {
                anchor(base, &mut component.library);
            }
            component.gen_file.iter_mut().for_each(|file| anchor(base, file));
        }
        Ok(config)
    }

    fn parse(path: &Path, text: &str) -> Result<Self, ConfigError> {
        toml::from_str(text).map_err(|error| {
            let start = error.span().map_or(0, |span| span.start).min(text.len());
            let line = text.as_bytes()[..start].iter().filter(|byte| **byte == b'\n').count() + 1;
            let message = error.message().trim().replace('\n', ", ");
            let nearest = nearest_key(&message);
            ConfigError::Mistake { path: path.to_owned(), line, message, nearest }
        })
    }
}

fn anchor(base: &Path, path: &mut PathBuf) {
    if path.is_relative() {
        *path = base.join(&*path);
    }
}

/// Serde says ``unknown field `x`, expected one of `a`, `b` ``: the nearest of what it expects.
fn nearest_key(message: &str) -> Option<String> {
    let mut quoted = message.split('`').skip(1).step_by(2);
    let unknown = message.starts_with("unknown field").then(|| quoted.next()).flatten()?;
    nearest(unknown, quoted).map(str::to_owned)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mistake(text: &str) -> String {
        Config::parse(Path::new("robot.toml"), text).unwrap_err().to_string()
    }

    #[test]
    fn an_unknown_key_names_file_line_and_the_nearest() {
        let told = mistake("log = \"info\"\n[rpc]\nmax_bdy = 3\n");
        assert!(told.starts_with("robot.toml:3: unknown field `max_bdy`"), "{told}");
        assert!(told.ends_with("did you mean `max_body`?"), "{told}");
        let told = mistake("[[component]]\nlibrary = \"demo\"\nbackedn = \"shm\"\n");
        assert!(told.contains(":3:") && told.ends_with("did you mean `backend`?"), "{told}");
    }

    #[test]
    fn a_wrong_type_names_file_and_line() {
        let told = mistake("\nbackend = 3\n");
        assert!(told.starts_with("robot.toml:2: invalid type: integer `3`"), "{told}");
    }

    #[test]
    fn the_default_file_says_the_defaults() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../configs/default.toml");
        assert_eq!(Config::read(&path).unwrap(), Config::default());
    }
}
