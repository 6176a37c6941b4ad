//! Reads and writes the file of contexts: named sets of options that select a daemon.

use std::io::Write as _;
use std::os::unix::fs::OpenOptionsExt as _;
use std::path::{Path, PathBuf};

use genom_protocol::contexts::{Context, Contexts, path};

use crate::chosen::Chosen;
use crate::connection::Connection;
use crate::failure::Failure;

/// Reads the file; a missing file has no contexts.
pub(crate) fn read() -> Result<Contexts, Failure> {
    let Some(path) = path() else { return Ok(Contexts::default()) };
    match std::fs::read_to_string(&path) {
        Ok(text) => toml::from_str(&text).map_err(|error| {
            let message = format!("{}: {}", path.display(), error.message().trim());
            Failure::usage(message, "mend the file, or remove it")
        }),
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(Contexts::default()),
        Err(error) => Err(Failure::usage(format!("{}: {error}", path.display()), "")),
    }
}

/// Writes the file, with access for this user only.
pub(crate) fn write(contexts: &Contexts) -> Result<(), Failure> {
    let Some(path) = path() else {
        let message = "nothing says where your configuration is";
        return Err(Failure::usage(message, "set HOME or XDG_CONFIG_HOME"));
    };
    let text = toml::to_string(contexts).map_err(std::io::Error::other)?;
    if let Some(directory) = path.parent() {
        std::fs::create_dir_all(directory)?;
    }
    // Written to another file and renamed, so that readers see either the old or the new content.
    let aside = path.with_extension(format!("toml.{}", std::process::id()));
    let mut options = std::fs::OpenOptions::new();
    let mut file = options.create(true).truncate(true).write(true).mode(0o600).open(&aside)?;
    file.write_all(text.as_bytes())?;
    std::fs::rename(&aside, &path)?;
    Ok(())
}

/// The context of that name.
pub(crate) fn named<'a>(contexts: &'a Contexts, name: &str) -> Result<&'a Context, Failure> {
    contexts.context.get(name).ok_or_else(|| {
        let known: Vec<_> = contexts.context.keys().map(String::as_str).collect();
        let known = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
        Failure::usage(format!("no context `{name}`"), format!("there is: {known}"))
    })
}

/// The options of the command line that a context keeps.
pub(crate) fn of(connection: &Connection) -> Context {
    let whole = |path: &Path| std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let kept = |path: &Option<PathBuf>| path.as_deref().map(whole);
    Context {
        socket: kept(&connection.socket),
        host: connection.host.as_ref().map(ToString::to_string),
        ca: kept(&connection.ca),
        cert: kept(&connection.cert),
        token_file: kept(&connection.token_file),
    }
}

/// The daemon that a context selects, for messages.
pub(crate) fn target(context: &Context) -> String {
    let socket = context.socket.as_ref().map(|path| path.display().to_string());
    context.host.clone().or(socket).unwrap_or_else(|| "the usual socket".to_owned())
}

/// Completes the options of the command line with those of a context: the one named, or the current
/// one if the command line does not select a daemon itself. Also returns the context if it is what
/// selects the daemon.
pub(crate) fn complete(
    mut connection: Connection,
) -> Result<(Connection, Option<Chosen>), Failure> {
    let says = connection.socket.is_some() || connection.host.is_some();
    if says && connection.context.is_none() {
        return Ok((connection, None));
    }
    let contexts = read()?;
    let Some(name) = connection.context.as_ref().or(contexts.current.as_ref()) else {
        return Ok((connection, None));
    };
    let context = named(&contexts, name)?.clone();
    let chose = !says && (context.socket.is_some() || context.host.is_some());
    let others = || contexts.context.keys().filter(|other| *other != name).cloned().collect();
    let chosen = chose.then(|| Chosen::new(name.clone(), others()));
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
