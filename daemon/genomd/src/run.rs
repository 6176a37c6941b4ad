//! A run of the daemon: open, load, serve, stop.

use std::io::Write as _;
use std::net::SocketAddr;
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Duration;

use genom_configuration::{RpcSettings, Spot};
use genom_host::{KeptProcess, StandardError};
use genom_supervisor::deploy::ApplyError;
use genom_supervisor::deploy::Step;
use genom_supervisor::limits;
use genom_supervisor::loading::LoadError;

use crate::daemon::Daemon;
use crate::memory;
use crate::rpc;
use crate::rpc::access::{Door, Log};
use crate::rpc::listen::{self, Socket};
use crate::rpc::serve::{Entrance, Listener, Most, serve};
use crate::rpc::tls;
use crate::rpc::tokens::Tokens;
use crate::settings::Settings;
use crate::signals::Signals;
use crate::telemetry;

/// Why the daemon did not run, with its exit status.
#[derive(Debug)]
pub(crate) struct Refusal {
    message: String,
    status: u8,
}

impl Refusal {
    /// 1: a component was refused.
    pub(crate) fn component(error: impl std::fmt::Display) -> Self {
        Self { message: error.to_string(), status: 1 }
    }

    /// 2: wrong usage or configuration.
    pub(crate) fn usage(error: impl std::fmt::Display) -> Self {
        Self { message: error.to_string(), status: 2 }
    }

    /// 3: the daemon's own socket or middleware.
    fn own(error: impl std::fmt::Display) -> Self {
        Self { message: error.to_string(), status: 3 }
    }

    /// 4: it stopped, and something did not end.
    fn left_behind(message: String) -> Self {
        Self { message, status: 4 }
    }

    /// Tells it on standard error.
    pub(crate) fn report(&self) -> ExitCode {
        // A drawing of a description's mistakes says `error` itself.
        let prefix = if self.message.starts_with("error") { "" } else { "error: " };
        let text = format!("{prefix}{}\n", self.message.trim_end());
        let _ = StandardError::get().write_all(text.as_bytes());
        ExitCode::from(self.status)
    }
}

/// Runs until asked to stop.
pub(crate) fn run(settings: Settings) -> Result<(), Refusal> {
    genom_host::check_memory(settings.check_memory);
    limits::raise();
    if settings.lock_memory {
        // Before there are threads: their stacks come into RAM as they are made.
        memory::lock();
    }
    let runtime = tokio::runtime::Builder::new_multi_thread()
        .worker_threads(2)
        .thread_name("genomd-rpc")
        .enable_all()
        .build()
        .map_err(Refusal::own)?;
    let outcome = runtime.block_on(live(settings));
    // A codel that hangs holds one of its threads: the process ends all the same.
    runtime.shutdown_background();
    match genom_host::raised_to_stop() {
        // A supervisor is to see that nobody outside asked for it.
        Some(told) if outcome.is_ok() => Err(Refusal::component(format!("stopped by {told}"))),
        _ => outcome,
    }
}

async fn open_tcp(
    rpc: &RpcSettings,
    address: SocketAddr,
) -> Result<(Listener, SocketAddr), Refusal> {
    let tls = rpc.tls.as_ref().map(tls::acceptor).transpose().map_err(Refusal::usage)?;
    let (listener, address) = listen::tcp(address).await.map_err(Refusal::own)?;
    tracing::info!("also on http{}://{address}", if tls.is_some() { "s" } else { "" });
    Ok((Listener::Tcp(listener, tls), address))
}

async fn live(mut settings: Settings) -> Result<(), Refusal> {
    let signals = Signals::take(settings.keep).map_err(Refusal::own)?;
    let socket = Socket::open(&settings.rpc.socket).map_err(Refusal::own)?;
    let tokens = Tokens::read(settings.rpc.token_file.as_deref()).map_err(Refusal::usage)?;
    let log = Arc::new(Log::default());
    let tcp = match settings.rpc.listen {
        Some(address) => {
            let (listener, address) = open_tcp(&settings.rpc, address).await?;
            // As it is: the port may have been left to the system.
            settings.rpc.listen = Some(address);
            Some(listener)
        }
        None => None,
    };
    let daemon = Daemon::new(&settings);
    tokio::spawn(signals.obey(Arc::clone(&daemon), Arc::clone(&tokens)));
    let (weak, runtime) = (Arc::downgrade(&daemon), tokio::runtime::Handle::current());
    let (known, told) = (Arc::clone(&tokens), Arc::clone(&log));
    daemon.backends.on_open(move |middleware| {
        if let Some(daemon) = weak.upgrade().filter(|_| middleware.relay().is_some()) {
            // Whoever comes this way may be anybody on the network: proofs say who.
            let door = Door::Proved { log: Arc::clone(&told) };
            let router = rpc::router(Arc::clone(&daemon), &known, door);
            rpc::relay::announce(&daemon, &router, &known, &runtime, middleware);
        }
    });
    open_backend(&daemon).await?;
    daemon.watch().map_err(Refusal::own)?;
    let exporter = settings.collector.clone().map(|collector| {
        let name = daemon.name.clone();
        tokio::spawn(telemetry::export(collector, name, daemon.closed.clone()))
    });
    tokio::spawn(keep_process(KeptProcess::remember()));

    // Requests are served while components load: a slow start codel holds up nobody.
    let RpcSettings { max_connections, max_connections_per_token, .. } = daemon.rpc;
    let most = Most { connections: max_connections, per_token: max_connections_per_token };
    let (listener, socket) = socket.split();
    let router = rpc::router(Arc::clone(&daemon), &tokens, Door::Own);
    let mut entrances = vec![Entrance { listener: Listener::Unix(listener), router }];
    if let Some(listener) = tcp {
        let tls = daemon.rpc.tls.iter().filter(|tls| tls.client_ca.is_some());
        let certified = tls.flat_map(|tls| tls.client_rights.clone()).collect();
        let door = Door::Guarded { tokens: Arc::clone(&tokens), log, certified };
        let router = rpc::router(Arc::clone(&daemon), &tokens, door);
        entrances.push(Entrance { listener, router });
    }
    let server = tokio::spawn(serve(entrances, most, daemon.closed.clone()));
    let outcome = tokio::select! {
        outcome = work(&daemon, &settings) => outcome,
        () = daemon.forced.raised() => {
            let left = daemon.components.stopping().join(", ");
            Err(Refusal::left_behind(format!("stopped before all codels had ended: {left}")))
        }
    };
    // Gone before the last stream ends: who waits for that finds nothing left.
    drop(socket);
    daemon.closed.raise();
    if let Err(error) = server.await {
        tracing::error!("the control plane ended badly: {error}");
    }
    if let Some(exporter) = exporter {
        // The last spans; it does not take longer than a moment.
        let _ = exporter.await;
    }
    outcome
}

/// Opens the default middleware. It may take a while: some look for others first.
async fn open_backend(daemon: &Arc<Daemon>) -> Result<(), Refusal> {
    let backend = daemon.settings.backend.clone();
    let (worker, name) = (Arc::clone(daemon), backend.clone());
    let opening = tokio::task::spawn_blocking(move || worker.backends.get(&name).map(drop));
    let too_long = async {
        // One that is open closes again as it should.
        daemon.asked_to_stop().await;
        let patience = tokio::time::sleep(daemon.settings.stop_timeout);
        tokio::select! { () = patience => {}, () = daemon.forced.raised() => {} }
    };
    tokio::select! {
        opened = opening => opened.map_err(Refusal::own)?.map_err(Refusal::own),
        () = too_long => {
            Err(Refusal::left_behind(format!("stopped while {backend} was being opened")))
        }
    }
}

/// Loads, runs until asked to stop, unloads.
async fn work(daemon: &Arc<Daemon>, settings: &Settings) -> Result<(), Refusal> {
    let mut outcome = Ok(());
    match load_all(daemon, settings).await {
        Ok(rest) => {
            daemon.startup.ready.raise();
            tracing::info!("ready on {}", daemon.rpc.socket.display());
            tokio::select! {
                refusal = deploy(daemon, settings, rest) => outcome = Err(refusal),
                () = daemon.asked_to_stop() => {}
            }
        }
        Err(refusal) => outcome = Err(refusal),
    }
    outcome.and(stop(daemon).await)
}

/// Loads the components asked for, in order; stops at the first that is refused. What else the
/// deployment asks for is given back.
async fn load_all(daemon: &Arc<Daemon>, settings: &Settings) -> Result<Vec<Step>, Refusal> {
    let steps = daemon
        .steps_to(&settings.deployment, false)
        .map(|steps| steps.to_take)
        .map_err(|error| Refusal::usage(told(settings, &error.place(), &error)))?;
    let (loads, rest): (Vec<_>, Vec<_>) =
        steps.into_iter().partition(|step| matches!(step, Step::Load(_)));
    let names = loads.iter().filter_map(|step| match step {
        Step::Load(request) => Some(request.instance()),
        _ => None,
    });
    daemon.startup.begins(names.collect());
    for step in loads {
        let Step::Load(request) = step else { continue };
        if daemon.stopping() {
            return Ok(Vec::new());
        }
        let (worker, asked) = (Arc::clone(daemon), request.clone());
        let mut loading = tokio::task::spawn_blocking(move || worker.load(&request));
        let loaded = tokio::select! {
            loaded = &mut loading => loaded,
            // Those that run are not to wait for one that starts.
            () = daemon.asked_to_stop() => tokio::join!(unload_all(daemon), loading).1,
        };
        match loaded {
            Ok(Ok(_) | Err(LoadError::Stopping)) => daemon.startup.one_is_loaded(),
            Ok(Err(error)) => {
                let place = Spot::component(&asked).key(error.key());
                let message = told(settings, &place, &error);
                let given_up = daemon.start_is_given_up();
                let refuse = if given_up { Refusal::left_behind } else { Refusal::component };
                return Err(refuse(message));
            }
            Err(error) => return Err(Refusal::own(error)),
        }
    }
    Ok(rest)
}

/// Connects, calls and starts what the configuration says; waits for other daemons as long as
/// it takes. Returns only when a step is refused.
async fn deploy(daemon: &Arc<Daemon>, settings: &Settings, steps: Vec<Step>) -> Refusal {
    let (worker, connections) = (Arc::clone(daemon), settings.deployment.connection.clone());
    let work = move || {
        let _turn = worker.deploying();
        worker.apply(&steps, None)?;
        worker.connections.declare(&connections);
        if !steps.is_empty() {
            tracing::info!("deployed: everything is wired and started");
        }
        Ok::<_, ApplyError>(())
    };
    match tokio::task::spawn_blocking(work).await {
        Ok(Ok(())) => {
            daemon.startup.deployed.raise();
            std::future::pending().await
        }
        Ok(Err(_)) if daemon.stopping() => std::future::pending().await,
        Ok(Err(error)) => Refusal::component(told(settings, &error.place, &error)),
        Err(error) => Refusal::own(error),
    }
}

/// The message, with file, line and key before it when they are known.
fn told(settings: &Settings, place: &Spot, error: &impl std::fmt::Display) -> String {
    let message = error.to_string();
    // A drawing of a description's mistakes names its own file.
    let file = settings.file.as_ref().filter(|_| !message.starts_with("error"));
    let place = file.and_then(|file| place.told(file, &std::fs::read_to_string(file).ok()?));
    place.map_or(message.clone(), |place| format!("{place}: {message}"))
}

/// Stops the components that run; what hangs is told and left behind.
async fn unload_all(daemon: &Arc<Daemon>) -> Result<(), tokio::task::JoinError> {
    let worker = Arc::clone(daemon);
    for (_, error) in tokio::task::spawn_blocking(move || worker.unload_all()).await? {
        tracing::error!("{error}");
    }
    Ok(())
}

/// Stops every component while requests under way are still answered.
async fn stop(daemon: &Arc<Daemon>) -> Result<(), Refusal> {
    daemon.ask_to_stop("a component was refused");
    unload_all(daemon).await.map_err(|error| {
        Refusal::left_behind(format!("stopping the components ended badly: {error}"))
    })?;
    daemon.announcements.withdraw();
    daemon.backends.close();
    // Of those that were unloaded before, too.
    let left = daemon.components.left_behind();
    if left.is_empty() {
        return Ok(());
    }
    let told = left.iter().map(|one| {
        let codels: Vec<String> = one.codels.iter().map(ToString::to_string).collect();
        format!("{} ({})", one.was, codels.join("; "))
    });
    let told = told.collect::<Vec<_>>().join(", ");
    Err(Refusal::left_behind(format!("stopped, and left behind: {told}")))
}

/// Codels may change signals, limits and descriptors of the process; the daemon goes on and is
/// stopped all the same.
async fn keep_process(kept: KeptProcess) {
    /// Between two looks.
    const LOOK: Duration = Duration::from_millis(100);
    loop {
        tokio::time::sleep(LOOK).await;
        for told in kept.look() {
            tracing::warn!("{told}");
        }
    }
}
