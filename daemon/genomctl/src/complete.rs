//! Completion with live names: components, services, ports and inputs of the daemon that the
//! line typed so far is about.
//!
//! The shell calls `genomctl` with the words typed; whatever fails, it completes nothing.

use std::ffi::{OsStr, OsString};
use std::sync::OnceLock;
use std::time::Duration;

use clap::{ArgMatches, Command, FromArgMatches as _};
use clap_complete::CompleteEnv;
use clap_complete::engine::{ArgValueCompleter, CompletionCandidate};
use genom_description::diagnostic::explanations;
use serde_json::Value;

use crate::connection::Connection;
use crate::escape;
use crate::names::{Path2, url};
use crate::session::Session;

/// A daemon that does not answer must not hold up a shell.
const PATIENCE: Duration = Duration::from_millis(500);

/// The command line: its arguments are completed by this module, which cannot name it.
static COMMAND: OnceLock<fn() -> Command> = OnceLock::new();

/// Answers a shell that asks for completions, as the variable tells, and ends; otherwise nothing.
pub(crate) fn answer(command: fn() -> Command, variable: &'static str) {
    COMMAND.get_or_init(|| command);
    CompleteEnv::with_factory(command).var(variable).complete();
}

/// What an argument names.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Names {
    /// Instances.
    Components,
    /// Services of the component typed before.
    Services,
    /// Activities (the services) of the component typed before.
    Startable,
    /// Inputs of the service typed before, as `name=`.
    Inputs,
    /// Activities that run or ran lately, by number and by service.
    Activities,
    /// Events of the component typed before.
    Events,
    /// Ports.
    Ports,
    /// In ports.
    Inports,
    /// In ports and remotes: what can be connected.
    Readers,
    /// Out ports of the type of the in port typed before; or services, when a remote was.
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
}

impl From<Names> for ArgValueCompleter {
    fn from(names: Names) -> Self {
        ArgValueCompleter::new(move |typed: &OsStr| {
            let typed = typed.to_string_lossy();
            let all = fixed(names)
                .unwrap_or_else(|| Line::read().map_or_else(Vec::new, |line| line.ask(names)));
            all.into_iter()
                // A name with control characters is none that a shell should get.
                .filter(|(name, _)| name.starts_with(&*typed) && escape::line(name) == *name)
                .map(|(name, help)| {
                    let help = help.map(|help| escape::line(&help).into());
                    CompletionCandidate::new(name).help(help)
                })
                .collect()
        })
    }
}

/// Names that no daemon has to be asked for.
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
    /// The words before the one to complete, as the shell's script hands them over.
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

    /// The address typed for an argument of the verb.
    fn typed_path(&self, argument: &str) -> Option<String> {
        let (_, verb) = self.matches.subcommand()?;
        verb.try_get_one::<Path2>(argument).ok()?.map(ToString::to_string)
    }

    /// What was typed for an argument of the verb.
    fn typed(&self, argument: &str) -> Option<String> {
        let (_, verb) = self.matches.subcommand()?;
        verb.try_get_one::<String>(argument).ok()?.cloned()
    }

    /// Whether the word before names a remote.
    async fn remote_typed(&self, session: &Session) -> bool {
        let Some(typed) = self.typed_path("inport") else { return false };
        let remotes = remotes(session).await.unwrap_or_default();
        remotes.iter().any(|(address, _)| *address == typed)
    }

    /// What a service must be like that the remote typed before calls.
    async fn wanted_of_service(&self, session: &Session) -> Option<Value> {
        let typed = self.typed_path("inport")?;
        let (component, remote) = typed.split_once('/')?;
        let described = session.get(&url(["components", component])).await.ok()?;
        let mut remotes = described["uses"].as_array()?.iter();
        Some(remotes.find(|one| one["name"] == *remote)?["digest"].clone())
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
        let get = async |path: String| session.get(&path).await.ok();
        let component = || self.typed("component");
        let of_component = |what: &[&str]| {
            let component = component()?;
            let segments = ["components", component.as_str()].into_iter();
            Some(url(segments.chain(what.iter().copied())))
        };
        Some(match names {
            Names::Components => {
                list(&get("/components".into()).await?["components"], "name", "component")
            }
            Names::Services | Names::Startable => {
                let mut reply = get(of_component(&[])?).await?;
                let activity = |service: &Value| service["kind"] == "activity";
                if let Some(services) = reply["services"].as_array_mut() {
                    services.retain(|one| matches!(names, Names::Services) || activity(one));
                    // What every component has comes last.
                    services.sort_by_key(|one| one["standard"] == true);
                }
                list(&reply["services"], "name", "doc")
            }
            Names::Inputs => {
                let service = self.typed("service")?;
                let reply = get(of_component(&["services", &service])?).await?;
                let inputs = reply["parameters"].as_array()?.iter();
                let inputs = inputs.filter(|one| one["direction"] != "out");
                inputs
                    .filter_map(|one| Some((format!("{}=", one["name"].as_str()?), about(one))))
                    .collect()
            }
            Names::Activities => {
                let reply = get(of_component(&["activities"])?).await?;
                let all = reply["activities"].as_array()?.iter();
                let mut found: Vec<Candidate> = all
                    .map(|one| {
                        let told = format!("{} {}", text(&one["service"]), text(&one["status"]));
                        (one["activity"].to_string(), Some(told))
                    })
                    .collect();
                found.reverse();
                found
            }
            Names::Events => {
                let reply = get(of_component(&[])?).await?;
                let events = reply["events"].as_array()?.iter();
                events.map(|event| (text(event), None)).collect()
            }
            Names::Connected => {
                list(&get("/connections".into()).await?["connections"], "in", "out")
            }
            Names::Outports if self.remote_typed(session).await => {
                services(session, self.wanted_of_service(session).await).await?
            }
            Names::Ports | Names::Inports | Names::Readers | Names::Outports => {
                let mut reply = get("/ports?values=false".into()).await?;
                if let Some(ports) = reply["ports"].as_array_mut() {
                    // What another type has cannot be connected; of a port that is not there,
                    // such as an element to come, nothing is known.
                    let reader = self.typed_path("inport");
                    let reader =
                        ports.iter().find(|port| port["address"].as_str() == reader.as_deref());
                    let wanted = reader.map(|port| port["digest"].clone());
                    ports.retain(|port| match names {
                        Names::Inports | Names::Readers => port["direction"] == "in",
                        Names::Outports => {
                            let fits =
                                wanted.as_ref().is_none_or(|wanted| port["digest"] == *wanted);
                            port["direction"] == "out" && fits
                        }
                        _ => true,
                    });
                }
                let mut all = list(&reply["ports"], "address", "type");
                if let Names::Readers = names {
                    all.extend(remotes(session).await?);
                }
                all
            }
            Names::Movable => {
                let components = get("/components".into()).await?;
                let ports = get("/ports?values=false".into()).await?;
                let mut all = list(&components["components"], "name", "component");
                all.extend(list(&ports["ports"], "address", "type"));
                all
            }
            Names::Policies | Names::Codes => Vec::new(),
            Names::Backends => {
                list(&get("/middlewares".into()).await?["middlewares"], "name", "version")
            }
        })
    }
}

/// Remotes of all components.
async fn remotes(session: &Session) -> Option<Vec<Candidate>> {
    let reply = session.get("/components").await.ok()?;
    let mut all = Vec::new();
    for component in reply["components"].as_array()? {
        for remote in component["remotes"].as_array().into_iter().flatten() {
            let address = format!("{}/{}", text(&component["name"]), text(remote));
            all.push((address, Some("remote".to_owned())));
        }
    }
    Some(all)
}

/// Services of all components that are as wanted, but for those that every component has.
async fn services(session: &Session, wanted: Option<Value>) -> Option<Vec<Candidate>> {
    let reply = session.get("/components").await.ok()?;
    let mut all = Vec::new();
    for component in reply["components"].as_array()? {
        let name = text(&component["name"]);
        let described = session.get(&url(["components", name.as_str()])).await.ok()?;
        let fits = |one: &&Value| {
            one["standard"] != true
                && wanted.as_ref().is_none_or(|wanted| one["call_digest"] == *wanted)
        };
        let own = described["services"].as_array()?.iter().filter(fits);
        let own: Value = own.cloned().collect();
        let own = list(&own, "name", "doc").into_iter();
        all.extend(own.map(|(service, doc)| (format!("{name}/{service}"), doc)));
    }
    Some(all)
}

/// Names and a word about each, from a list of objects.
fn list(all: &Value, name: &str, help: &str) -> Vec<Candidate> {
    let first_line = |one: &Value| one[help].as_str()?.lines().next().map(str::to_owned);
    let all = all.as_array().map(Vec::as_slice).unwrap_or_default().iter();
    all.map(|one| (text(&one[name]), first_line(one))).collect()
}

/// Type, default and documentation of an input.
fn about(input: &Value) -> Option<String> {
    let mut told = text(&input["type"]);
    let shown = input.get("current").or(input.get("default")).filter(|value| !value.is_null());
    if let Some(default) = shown {
        told.push_str(&format!(" = {default}"));
    }
    if let Some(doc) = input["doc"].as_str() {
        told.push_str(&format!(": {doc}"));
    }
    Some(told)
}

fn text(value: &Value) -> String {
    value.as_str().unwrap_or_default().to_owned()
}
