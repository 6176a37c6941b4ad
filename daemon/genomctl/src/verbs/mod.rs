//! The verbs, one file each: arguments, request, and a pure function that formats the reply.

mod abort;
mod activities;
mod add;
mod apply;
mod backend;
mod backends;
mod bag;
mod bench;
mod blackbox;
mod build;
mod bw;
mod call;
mod cells;
mod check;
mod completion;
mod conformance;
mod connect;
mod connections;
mod context;
mod crashes;
mod daemons;
mod describe;
mod digest;
mod disconnect;
mod doctor;
mod dump;
mod echo;
mod events;
mod explain;
mod fire;
mod fmt;
mod freeze;
mod graph;
mod header;
mod hz;
mod info;
mod kill;
mod list;
mod load;
mod logs;
mod lsp;
mod man;
mod model;
mod monitor;
mod new;
mod outcome;
mod plot;
mod ports;
mod publish;
mod record;
mod recover;
mod reference;
mod reload;
mod replay;
mod ros2_package;
mod schedule;
mod sdk;
mod start;
mod stats;
mod step;
mod stop;
mod test;
mod thaw;
mod token;
mod top;
mod unload;
mod verify;
mod wait;
mod wait_ready;
mod web;
mod why;

use clap::Subcommand;

use crate::connection::Connection;
use crate::failure::Failure;
use crate::session::Session;
pub(crate) use completion::VARIABLE as COMPLETE;

/// The verbs.
#[derive(Debug, Subcommand)]
pub(crate) enum Verb {
    List(list::Args),
    WaitReady(wait_ready::Args),
    Info(info::Args),
    Call(call::Args),
    Start(start::Args),
    Wait(wait::Args),
    Abort(abort::Args),
    Stop(stop::Args),
    Activities(activities::Args),
    Ports(ports::Args),
    Echo(echo::Args),
    Hz(hz::Args),
    Bw(bw::Args),
    Plot(plot::Args),
    #[command(name = "pub")]
    Publish(publish::Args),
    Record(record::Args),
    Replay(replay::Args),
    Recover(recover::Args),
    Bag(bag::Args),
    Connect(connect::Args),
    Disconnect(disconnect::Args),
    Connections(connections::Args),
    Load(load::Args),
    Reload(reload::Args),
    Unload(unload::Args),
    Cells(cells::Args),
    Crashes(crashes::Args),
    Blackbox(blackbox::Args),
    Fire(fire::Args),
    Events(events::Args),
    Stats(stats::Args),
    Monitor(monitor::Args),
    Top(top::Args),
    Logs(logs::Args),
    Web(web::Args),
    Step(step::Args),
    Apply(apply::Args),
    Dump(dump::Args),
    Freeze(freeze::Args),
    Thaw(thaw::Args),
    Backend(backend::Args),
    Backends(backends::Args),
    Bench(bench::Args),
    Conformance(conformance::Args),
    Why(why::Args),
    Doctor(doctor::Args),
    Kill(kill::Args),
    Daemons(daemons::Args),
    Context(context::Args),
    Token(token::Args),
    Check(check::Args),
    Explain(explain::Args),
    Verify(verify::Args),
    Schedule(schedule::Args),
    Model(model::Args),
    Fmt(fmt::Args),
    Describe(describe::Args),
    Header(header::Args),
    Graph(graph::Args),
    Digest(digest::Args),
    Ros2Package(ros2_package::Args),
    New(new::Args),
    Add(add::Args),
    Build(build::Args),
    Test(test::Args),
    Sdk(sdk::Args),
    Lsp(lsp::Args),
    Completion(completion::Args),
    Man(man::Args),
    #[command(hide = true)]
    Reference(reference::Args),
}

impl Verb {
    /// The options that select the daemon. `--timeout` of verbs that wait for something other than
    /// a reply is not that of the connection.
    pub(crate) fn connection(&self, given: Connection) -> Connection {
        match self {
            Verb::Wait(_) | Verb::Apply(_) => Connection { timeout: None, ..given },
            _ => given,
        }
    }
}

/// Runs the verb; `command` is the whole command line, for verbs that describe it.
pub(crate) async fn run(
    verb: Verb,
    session: &Session,
    command: fn() -> clap::Command,
) -> Result<(), Failure> {
    match verb {
        Verb::List(args) => list::run(args, session).await,
        Verb::WaitReady(args) => wait_ready::run(args, session).await,
        Verb::Info(args) => info::run(args, session).await,
        Verb::Call(args) => call::run(args, session).await,
        Verb::Start(args) => start::run(args, session).await,
        Verb::Wait(args) => wait::run(args, session).await,
        Verb::Abort(args) => abort::run(args, session).await,
        Verb::Stop(args) => stop::run(args, session).await,
        Verb::Activities(args) => activities::run(args, session).await,
        Verb::Ports(args) => ports::run(args, session).await,
        Verb::Echo(args) => echo::run(args, session).await,
        Verb::Hz(args) => hz::run(args, session).await,
        Verb::Bw(args) => bw::run(args, session).await,
        Verb::Plot(args) => plot::run(args, session).await,
        Verb::Publish(args) => publish::run(args, session).await,
        Verb::Record(args) => record::run(args, session).await,
        Verb::Replay(args) => replay::run(args, session).await,
        Verb::Recover(args) => recover::run(&args, session),
        Verb::Bag(args) => bag::run(&args, session),
        Verb::Connect(args) => connect::run(args, session).await,
        Verb::Disconnect(args) => disconnect::run(args, session).await,
        Verb::Connections(args) => connections::run(args, session).await,
        Verb::Load(args) => load::run(args, session).await,
        Verb::Cells(args) => cells::run(args, session).await,
        Verb::Crashes(args) => crashes::run(args, session).await,
        Verb::Blackbox(args) => blackbox::run(args, session).await,
        Verb::Reload(args) => reload::run(args, session).await,
        Verb::Unload(args) => unload::run(args, session).await,
        Verb::Fire(args) => fire::run(args, session).await,
        Verb::Events(args) => events::run(args, session).await,
        Verb::Stats(args) => stats::run(args, session).await,
        Verb::Monitor(args) => monitor::run(args, session).await,
        Verb::Top(args) => top::run(args, session).await,
        Verb::Logs(args) => logs::run(args, session).await,
        Verb::Web(args) => web::run(args, session).await,
        Verb::Step(args) => step::run(args, session).await,
        Verb::Apply(args) => apply::run(args, session).await,
        Verb::Dump(args) => dump::run(args, session).await,
        Verb::Freeze(args) => freeze::run(args, session).await,
        Verb::Thaw(args) => thaw::run(args, session).await,
        Verb::Backend(args) => backend::run(args, session).await,
        Verb::Backends(args) => backends::run(args, session).await,
        Verb::Bench(args) => bench::run(args, session).await,
        Verb::Conformance(args) => conformance::run(&args, session),
        Verb::Why(args) => why::run(args, session).await,
        Verb::Doctor(args) => doctor::run(args, session).await,
        Verb::Kill(args) => kill::run(args, session).await,
        Verb::Daemons(args) => daemons::run(args, session).await,
        Verb::Context(args) => context::run(&args, session),
        Verb::Token(args) => token::run(&args, session).await,
        Verb::Check(args) => check::run(&args, session),
        Verb::Explain(args) => explain::run(&args, session),
        Verb::Verify(args) => verify::run(&args, session).await,
        Verb::Schedule(args) => schedule::run(&args, session).await,
        Verb::Model(args) => model::run(&args, session).await,
        Verb::Fmt(args) => fmt::run(&args, session),
        Verb::Describe(args) => describe::run(&args, session),
        Verb::Header(args) => header::run(&args, session),
        Verb::Graph(args) => graph::run(&args, session).await,
        Verb::Digest(args) => digest::run(&args, session),
        Verb::Ros2Package(args) => ros2_package::run(&args, session),
        Verb::New(args) => new::run(&args, session),
        Verb::Add(args) => add::run(args, session),
        Verb::Build(args) => build::run(&args, session),
        Verb::Test(args) => test::run(args, session).await,
        Verb::Sdk(args) => sdk::run(&args, session),
        Verb::Lsp(args) => lsp::run(&args),
        Verb::Completion(args) => completion::run(&args, session),
        Verb::Man(args) => man::run(&args, session, command()),
        Verb::Reference(args) => reference::run(&args, session, command()),
    }
}
