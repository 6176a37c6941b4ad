//! `genomctl load`: loads a component into the daemon.

use clap_complete::engine::{ArgValueCompleter, PathCompleter};
use std::path::{Path, PathBuf};

use genom_protocol::{
    BackendNames, Component, LoadRequest, NoReaction, Reaction, Remap, RestartPolicy, routes,
};

use crate::complete::Names;
use crate::failure::Failure;
use crate::inputs;
use crate::session::Session;

/// Load a component into the running daemon.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Library of codels (.so), description (.gen), or a name on the daemon's component path.
    #[arg(add = ArgValueCompleter::new(PathCompleter::any().filter(is_component)))]
    library: PathBuf,
    /// Description, if it is neither in the library nor beside it.
    #[arg(long, value_name = "FILE", add = ArgValueCompleter::new(PathCompleter::any()))]
    gen_file: Option<PathBuf>,
    /// Instance name [default: the component's name].
    #[arg(long)]
    name: Option<String>,
    /// Middleware of its ports [default: that of the daemon].
    #[arg(long, add = ArgValueCompleter::from(Names::Backends))]
    backend: Option<String>,
    /// Run it in this cell: a process that components of one cell share, so that a fault of theirs
    /// takes nothing else down.
    #[arg(long, value_name = "CELL", add = ArgValueCompleter::from(Names::Cells))]
    cell: Option<String>,
    /// Run it in a cell of its own, of its name.
    #[arg(long, conflicts_with = "cell")]
    isolated: bool,
    /// Whether it is brought up again when the process of its cell has ended [default: on-failure].
    #[arg(long, value_name = "POLICY")]
    restart: Option<RestartPolicy>,
    /// Another name on ROS 2 for an out port, a service or its node, by ROS's rules:
    /// position:=/odom, __ns:=/lab, __node:=arm; may be given several times.
    #[arg(short = 'r', long, value_name = "RULE")]
    remap: Vec<Remap>,
    /// What is done of another component when the process of its cell ends by a fault: call
    /// COMPONENT/SERVICE, start COMPONENT/ACTIVITY or fire COMPONENT/EVENT, with inputs as of `call`;
    /// may be given several times.
    #[arg(long, value_name = "REACTION", value_parser = reaction)]
    on_failure: Vec<Reaction>,
}

/// `call base/stop hard=true`.
fn reaction(text: &str) -> Result<Reaction, ReactionError> {
    let mut words = text.trim().splitn(3, char::is_whitespace);
    let (act, address) = (words.next().unwrap_or_default(), words.next().map(str::to_owned));
    let inputs = match words.next().map(str::trim) {
        None => Vec::new(),
        Some(json) if json.starts_with('{') => vec![json.to_owned()],
        Some(pairs) => pairs.split_whitespace().map(str::to_owned).collect(),
    };
    let inputs =
        inputs::parse(&inputs).map_err(|error| ReactionError::Inputs(error.to_string()))?;
    let mut reaction = Reaction { inputs, ..Reaction::default() };
    match act {
        "call" => reaction.call = address,
        "start" => reaction.start = address,
        "fire" => reaction.fire = address,
        _ => return Err(ReactionError::Act(act.to_owned())),
    }
    reaction.deed()?;
    Ok(reaction)
}

/// Why a text is no reaction.
#[derive(Debug, thiserror::Error)]
enum ReactionError {
    #[error("`{0}` is none of `call`, `start` and `fire`")]
    Act(String),
    #[error("{0}")]
    Inputs(String),
    #[error(transparent)]
    Form(#[from] NoReaction),
}

/// Whether a path can be completed: libraries, descriptions, and directories.
pub(super) fn is_component(path: &Path) -> bool {
    let extension = path.extension().and_then(|extension| extension.to_str());
    path.is_dir() || matches!(extension, Some("so" | "gen"))
}

pub(super) async fn run(args: Args, session: &Session) -> Result<(), Failure> {
    let mut request = LoadRequest {
        library: absolute(&args.library)?,
        gen_file: args.gen_file.as_deref().map(absolute).transpose()?,
        name: args.name,
        backend: args.backend.as_deref().map(BackendNames::from),
        cell: args.cell,
        restart: args.restart.unwrap_or_default(),
        on_failure: args.on_failure,
        remap: args.remap,
        ..LoadRequest::default()
    };
    if args.isolated {
        request.cell = Some(request.instance());
    }
    let reply = session.send(routes::load(), &request).await?;
    session.show(&reply, render)
}

/// An existing file is sent with its absolute path, because the daemon has another working
/// directory.
pub(super) fn absolute(path: &Path) -> Result<PathBuf, Failure> {
    let full = if path.exists() { std::path::absolute(path)? } else { path.to_owned() };
    match full.to_str() {
        Some(_) => Ok(full),
        None => Err(Failure::usage(
            format!("{} is not UTF-8", path.display()),
            "rename the file, or its directory",
        )),
    }
}

fn render(reply: &Component) -> String {
    let Component { name, component, backend, cell, .. } = reply;
    let cell = cell.as_ref().map_or(String::new(), |cell| format!(", cell {cell}"));
    format!("{name} runs (component {component}, backend {backend}{cell})\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reaction_is_typed_as_a_verb_with_its_inputs() {
        let typed = |text| reaction(text).map_err(|error| error.to_string());
        let stop = typed("call base/stop hard=true n.x=1").unwrap();
        assert_eq!(
            (stop.to_string().as_str(), &stop.inputs["n"]["x"]),
            ("call base/stop", &1.into())
        );
        assert_eq!(typed("start base/hold {\"a\": [1, 2]}").unwrap().inputs["a"][1], 2);
        assert_eq!(typed("fire base/emergency").unwrap().to_string(), "fire base/emergency");
        for (wrong, why) in [
            ("", "`` is none of"),
            ("stop base/arm", "`stop` is none of"),
            ("call", "takes one of"),
            ("call base", "`base` is no COMPONENT/NAME"),
            ("fire base/emergency a=1", "without `inputs`"),
            ("call base/stop hard", "neither JSON nor key=value"),
        ] {
            let refused = typed(wrong).unwrap_err();
            assert!(refused.contains(why), "{wrong}: {refused}");
        }
    }
}
