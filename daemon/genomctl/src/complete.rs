//! Shell completion with live names: components, services, ports and inputs, asked of the daemon
//! that the line typed so far selects.
//!
//! The shell calls `genomctl` with the words typed. On any failure there are no completions.

use std::ffi::{OsStr, OsString};
use std::sync::OnceLock;
use std::time::Duration;

use clap::{ArgMatches, Command, FromArgMatches as _};
use clap_complete::CompleteEnv;
use clap_complete::engine::{ArgValueCompleter, CompletionCandidate};
use genom_description::diagnostic::explanations;
use genom_protocol::{
    Activity, Address, Component, Parameter, Port, PortDirection, PortParameters, Service,
    ServiceKind, routes,
};

use crate::connection::Connection;
use crate::escape;
use crate::session::Session;

/// How long to wait for the daemon: one that hangs must not block the shell.
const PATIENCE: Duration = Duration::from_millis(500);

/// The command line. It is passed in, because the definition of its arguments refers to this
/// module.
static COMMAND: OnceLock<fn() -> Command> = OnceLock::new();

/// If the variable says that a shell asks for completions, prints them and exits. Otherwise does
/// nothing.
pub(crate) fn answer(command: fn() -> Command, variable: &'static str) {
    COMMAND.get_or_init(|| command);
    CompleteEnv::with_factory(command).var(variable).complete();
}

/// What an argument is the name of.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Names {
    /// Instances.
    Components,
    /// Services of the component typed before.
    Services,
    /// Activities of the component typed before.
    Startable,
    /// Inputs of the service typed before, as `name=`.
    Inputs,
    /// Activities that run or ended recently, by number and by service.
    Activities,
    /// Events of the component typed before.
    Events,
    /// Ports.
    Ports,
    /// In ports.
    Inports,
    /// In ports and remotes: what can be connected.
    Readers,
    /// Out ports whose type is that of the in port typed before; or services, if a remote was
    /// typed.
    Outports,
    /// Policies of connections.
    Policies,
    /// Codes of diagnostics.
    Codes,
    /// In ports and remotes that are connected.
    Connected,
    /// Components and ports.
    Movable,
    /// Middlewares.
    Backends,
    /// Cells.
    Cells,
    /// Reports of crashes.
    Crashes,
}

impl From<Names> for ArgValueCompleter {
    fn from(names: Names) -> Self {
        ArgValueCompleter::new(move |typed: &OsStr| {
            let typed = typed.to_string_lossy();
            let all = fixed(names)
                .unwrap_or_else(|| Line::read().map_or_else(Vec::new, |line| line.ask(names)));
            all.into_iter()
                // A name with control characters must not reach the shell.
                .filter(|(name, _)| name.starts_with(&*typed) && escape::line(name) == *name)
                .map(|(name, help)| {
                    let help = help.map(|help| escape::line(&help).into());
                    CompletionCandidate::new(name).help(help)
                })
                .collect()
        })
    }
}

/// Names that are known without asking a daemon.
fn fixed(names: Names) -> Option<Vec<Candidate>> {
    let told = |(name, help): (&str, &str)| (name.to_owned(), Some(help.to_owned()));
    match names {
        Names::Policies => Some(
            [
                ("latest", "the last sample"),
                ("queue:8", "the oldest first, new ones are dropped while 8 wait"),
                ("ring:8", "the oldest first, a ninth takes the place of the oldest"),
            ]
            .map(told)
            .to_vec(),
        ),
        Names::Codes => Some(explanations().map(|one| told((one.code, one.title))).collect()),
        _ => None,
    }
}

type Candidate = (String, Option<String>);

/// The line typed so far.
struct Line {
    matches: ArgMatches,
    connection: Connection,
}

impl Line {
    /// The words before the one to complete, as passed by the shell's script.
    fn read() -> Option<Self> {
        let words: Vec<OsString> =
            std::env::args_os().skip_while(|word| word != "--").skip(1).collect();
        let index = std::env::var("_CLAP_COMPLETE_INDEX").ok();
        let index = index.and_then(|index| index.parse().ok());
        let index = index.unwrap_or(words.len().saturating_sub(1)).min(words.len());
        let command = COMMAND.get()?().ignore_errors(true);
        let matches = command.try_get_matches_from(words.get(..index)?).ok()?;
        let connection = Connection::from_arg_matches(&matches).ok()?;
        Some(Self { matches, connection })
    }

    /// The in port or remote typed for `connect`.
    fn reader(&self) -> Option<&Address> {
        let (_, verb) = self.matches.subcommand()?;
        verb.try_get_one::<Address>("inport").ok()?
    }

    /// What was typed for an argument of the verb.
    fn typed(&self, argument: &str) -> Option<&str> {
        let (_, verb) = self.matches.subcommand()?;
        verb.try_get_one::<String>(argument).ok()?.map(String::as_str)
    }

    /// Digest that services must have to be called by the remote typed before; `None` if no remote
    /// was typed.
    async fn remote(&self, session: &Session) -> Option<String> {
        let reader = self.reader()?;
        let described = session.ask(routes::component(&reader.component)).await.ok()?.content;
        let remote = described.uses.into_iter().find(|remote| remote.name == reader.name())?;
        Some(remote.digest)
    }

    fn ask(&self, names: Names) -> Vec<Candidate> {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build();
        let Ok(runtime) = runtime else { return Vec::new() };
        let session = Session::new(self.connection.clone(), true);
        let asking = async {
            tokio::time::timeout(PATIENCE, self.candidates(&session, names)).await.ok().flatten()
        };
        runtime.block_on(asking).unwrap_or_default()
    }

    async fn candidates(&self, session: &Session, names: Names) -> Option<Vec<Candidate>> {
        Some(match names {
            Names::Components => components(session).await?,
            Names::Services | Names::Startable => {
                let route = routes::component(self.typed("component")?);
                let mut services = session.ask(route).await.ok()?.content.services;
                if matches!(names, Names::Startable) {
                    services.retain(|one| one.kind == ServiceKind::Activity);
                }
                // Services that every component has come last.
                services.sort_by_key(|one| one.standard);
                services.into_iter().map(|one| (one.name, first_line(one.doc))).collect()
            }
            Names::Inputs => {
                let route = routes::service(self.typed("component")?, self.typed("service")?);
                let parameters = session.ask(route).await.ok()?.content.parameters;
                let inputs = parameters.iter().filter(|one| one.direction.is_input());
                inputs.map(|one| (format!("{}=", one.name), Some(about(one)))).collect()
            }
            Names::Activities => {
                let route = routes::activities(self.typed("component")?);
                let all = session.ask(route).await.ok()?.content.activities;
                let told = |one: &Activity| format!("{} {}", one.service, one.status);
                all.iter().rev().map(|one| (one.activity.to_string(), Some(told(one)))).collect()
            }
            Names::Events => {
                let route = routes::component(self.typed("component")?);
                let events = session.ask(route).await.ok()?.content.events;
                events.into_iter().map(|event| (event, None)).collect()
            }
            Names::Connected => {
                let all = session.ask(routes::connections()).await.ok()?.content.connections;
                all.into_iter().map(|one| (one.inport, Some(one.outport))).collect()
            }
            Names::Ports => ports(session, |_| true).await?,
            Names::Inports => ports(session, |port| port.direction == PortDirection::In).await?,
            Names::Readers => {
                let mut all = ports(session, |port| port.direction == PortDirection::In).await?;
                all.extend(remotes(session).await?);
                all
            }
            Names::Outports => match self.remote(session).await {
                Some(digest) => services(session, &digest).await?,
                None => self.outports(session).await?,
            },
            Names::Movable => {
                let mut all = components(session).await?;
                all.extend(ports(session, |_| true).await?);
                all
            }
            Names::Cells => {
                let all = session.ask(routes::cells()).await.ok()?.content.cells;
                all.into_iter().map(|one| (one.name, Some(one.components.join(", ")))).collect()
            }
            Names::Crashes => {
                let all = session.ask(routes::crashes()).await.ok()?.content.crashes;
                all.into_iter().map(|one| (one.name, Some(one.end))).collect()
            }
            Names::Policies | Names::Codes => Vec::new(),
            Names::Backends => {
                let all = session.ask(routes::middlewares()).await.ok()?.content.middlewares;
                all.into_iter().map(|one| (one.name, Some(one.version))).collect()
            }
        })
    }

    /// Out ports whose type is that of the in port typed before; all out ports if the in port does
    /// not exist yet, as an element of a multiple port may.
    async fn outports(&self, session: &Session) -> Option<Vec<Candidate>> {
        let reader = self.reader().map(Address::to_string);
        let all = all_ports(session).await?;
        let reader = all.iter().find(|port| Some(&port.address) == reader.as_ref());
        let wanted = reader.map(|port| port.digest.clone());
        let fits = |port: &Port| wanted.as_ref().is_none_or(|wanted| port.digest == *wanted);
        let outports = all.iter().filter(|port| port.direction == PortDirection::Out && fits(port));
        Some(outports.map(port).collect())
    }
}

/// Instances, each with the name of its component.
async fn components(session: &Session) -> Option<Vec<Candidate>> {
    let all = session.ask(routes::components()).await.ok()?.content.components;
    Some(all.into_iter().map(|one| (one.name, Some(one.component))).collect())
}

async fn all_ports(session: &Session) -> Option<Vec<Port>> {
    let query = PortParameters { values: Some(false) };
    Some(session.ask(routes::ports().with(&query)).await.ok()?.content.ports)
}

/// The ports for which `wanted` is true, each with its type.
async fn ports(session: &Session, wanted: impl Fn(&Port) -> bool) -> Option<Vec<Candidate>> {
    Some(all_ports(session).await?.iter().filter(|port| wanted(port)).map(port).collect())
}

fn port(of: &Port) -> Candidate {
    (of.address.clone(), Some(of.ty.clone()))
}

/// Remotes of all components.
async fn remotes(session: &Session) -> Option<Vec<Candidate>> {
    let all = session.ask(routes::components()).await.ok()?.content.components;
    let remotes = all.iter().flat_map(|component| {
        component.remotes.iter().map(|remote| format!("{}/{remote}", component.name))
    });
    Some(remotes.map(|address| (address, Some("remote".to_owned()))).collect())
}

/// Services of all components whose digest is that of the remote.
async fn services(session: &Session, digest: &str) -> Option<Vec<Candidate>> {
    let mut all = Vec::new();
    for Component { name, .. } in session.ask(routes::components()).await.ok()?.content.components {
        let described = session.ask(routes::component(&name)).await.ok()?.content;
        let fits = |one: &Service| !one.standard && one.call_digest == digest;
        let services = described.services.into_iter().filter(fits);
        all.extend(services.map(|one| (format!("{name}/{}", one.name), first_line(one.doc))));
    }
    Some(all)
}

fn first_line(doc: Option<String>) -> Option<String> {
    doc?.lines().next().map(str::to_owned)
}

/// Description of an input: type, default and documentation.
fn about(input: &Parameter) -> String {
    let mut about = input.ty.clone();
    if let Some(value) = input.current.as_ref().or(input.default.as_ref()) {
        about.push_str(&format!(" = {value}"));
    }
    if let Some(doc) = &input.doc {
        about.push_str(&format!(": {doc}"));
    }
    about
}
