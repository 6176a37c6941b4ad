//! Named ways to daemons, kept in `~/.config/genomd/contexts.toml`.

use std::collections::BTreeMap;
use std::io::Write as _;
use std::os::unix::fs::OpenOptionsExt as _;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::connection::Connection;
use crate::failure::Failure;

/// What the file holds.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Contexts {
    /// The one that counts when the command line names no daemon.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) current: Option<String>,
    #[serde(default)]
    pub(crate) context: BTreeMap<String, Context>,
}

/// One way to a daemon: the options of the command line, kept.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Context {
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) socket: Option<PathBuf>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) host: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) ca: Option<PathBuf>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) cert: Option<PathBuf>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) token_file: Option<PathBuf>,
}

/// Where the file is; `None` when nothing says where this user's configuration is.
fn path() -> Option<PathBuf> {
    let set = |name| std::env::var_os(name).filter(|value| !value.is_empty()).map(PathBuf::from);
    let base = set("XDG_CONFIG_HOME").or_else(|| set("HOME").map(|home| home.join(".config")))?;
    Some(base.join("genomd/contexts.toml"))
}

impl Contexts {
    /// Reads the file; one that is not there holds nothing.
    pub(crate) fn read() -> Result<Self, Failure> {
        let Some(path) = path() else { return Ok(Self::default()) };
        match std::fs::read_to_string(&path) {
            Ok(text) => toml::from_str(&text).map_err(|error| {
                let message = format!("{}: {}", path.display(), error.message().trim());
                Failure::usage(message, "mend the file, or remove it")
            }),
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(Self::default()),
            Err(error) => Err(Failure::usage(format!("{}: {error}", path.display()), "")),
        }
    }

    /// Writes the file, for this user alone.
    pub(crate) fn write(&self) -> Result<(), Failure> {
        let Some(path) = path() else {
            let message = "nothing says where your configuration is";
            return Err(Failure::usage(message, "set HOME or XDG_CONFIG_HOME"));
        };
        let text = toml::to_string(self).map_err(std::io::Error::other)?;
        if let Some(directory) = path.parent() {
            std::fs::create_dir_all(directory)?;
        }
        // Aside and renamed: a reader sees the old one or the new one, whole.
        let aside = path.with_extension(format!("toml.{}", std::process::id()));
        let mut options = std::fs::OpenOptions::new();
        let mut file = options.create(true).truncate(true).write(true).mode(0o600).open(&aside)?;
        file.write_all(text.as_bytes())?;
        std::fs::rename(&aside, &path)?;
        Ok(())
    }

    /// The context of that name.
    pub(crate) fn named(&self, name: &str) -> Result<&Context, Failure> {
        self.context.get(name).ok_or_else(|| {
            let known: Vec<_> = self.context.keys().map(String::as_str).collect();
            let known = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
            Failure::usage(format!("no context `{name}`"), format!("there is: {known}"))
        })
    }
}

impl Context {
    /// What the command line said, as far as it can be kept.
    pub(crate) fn of(connection: &Connection) -> Self {
        let whole = |path: &Path| std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
        let kept = |path: &Option<PathBuf>| path.as_deref().map(whole);
        Self {
            socket: kept(&connection.socket),
            host: connection.host.as_ref().map(ToString::to_string),
            ca: kept(&connection.ca),
            cert: kept(&connection.cert),
            token_file: kept(&connection.token_file),
        }
    }

    /// Where it leads, for people.
    pub(crate) fn target(&self) -> String {
        let socket = self.socket.as_ref().map(|path| path.display().to_string());
        self.host.clone().or(socket).unwrap_or_else(|| "the usual socket".to_owned())
    }
}

/// A context that says which daemon is meant.
#[derive(Clone, Debug)]
pub(crate) struct Chosen {
    name: String,
    /// The names of the others.
    others: Vec<String>,
}

impl std::fmt::Display for Chosen {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "context `{}`", self.name)
    }
}

impl Chosen {
    /// How to mean another daemon.
    pub(crate) fn help(&self) -> String {
        let others = match self.others.as_slice() {
            [] => String::new(),
            others => format!(
                "`genomctl context use NAME` or --context NAME takes another one ({}), ",
                others.join(", ")
            ),
        };
        format!("{self} says where: {others}`genomctl context use` goes back to the usual socket")
    }
}

/// The options with those of a context under them: the one named, else the current one unless
/// the command line says itself which daemon is meant. With it, the context if it says that.
pub(crate) fn complete(
    mut connection: Connection,
) -> Result<(Connection, Option<Chosen>), Failure> {
    let says = connection.socket.is_some() || connection.host.is_some();
    if says && connection.context.is_none() {
        return Ok((connection, None));
    }
    let contexts = Contexts::read()?;
    let Some(name) = connection.context.as_ref().or(contexts.current.as_ref()) else {
        return Ok((connection, None));
    };
    let context = contexts.named(name)?.clone();
    let chose = !says && (context.socket.is_some() || context.host.is_some());
    let others = || contexts.context.keys().filter(|other| *other != name).cloned().collect();
    let chosen = chose.then(|| Chosen { name: name.clone(), others: others() });
    if !says {
        connection.socket = context.socket;
        connection.host = match context.host {
            Some(host) => Some(host.parse().map_err(|why| {
                Failure::usage(format!("context {name}: {why}"), "`genomctl context add` it anew")
            })?),
            None => None,
        };
    }
    connection.ca = connection.ca.or(context.ca);
    connection.cert = connection.cert.or(context.cert);
    connection.token_file = connection.token_file.or(context.token_file);
    Ok((connection, chosen))
}
