//! A run of the daemon: open, load, serve, stop.

use std::io;
use std::net::SocketAddr;
use std::os::fd::OwnedFd;
use std::sync::Arc;
use std::time::Duration;

use genom_cells::{AskError, Asked, OpenError};
use genom_configuration::{ClockKind, ConnectionEntry, LoadRequest, RpcSettings, Spot};
use genom_doors::{
    Certificates, Desk, Door, Entrance, Listener, Log, Most, Socket, Tokens, acceptor, serve,
};
use genom_embedding::Program;
use genom_foxglove::Foxglove;
use genom_host::{KeptProcess, keep_from_children, keep_off};
use genom_middleware::Middleware;
use genom_protocol::{CellState, DeploymentRequest};
use genom_supervisor::Supervisor;
use genom_supervisor::deploy::ApplyError;
use genom_supervisor::deploy::Step;
use genom_supervisor::limits;
use genom_supervisor::loading::{LoadError, check_reactions};
use genom_systemd::heartbeat;
use genom_web::Console;
use tokio::runtime::Handle;
use tokio::task::block_in_place;

use crate::announcements;
use crate::daemon::Daemon;
use crate::life::Life;
pub(crate) use crate::refusal::Refusal;
use crate::ros;
use crate::rpc;
use crate::settings::Settings;
use crate::signals::{Signals, keep_process};
use genom_cells::own as own_cell;

/// Runs the daemon until it is asked to stop.
pub(crate) fn run(settings: Settings) -> Result<(), Refusal> {
    genom_host::check_memory(settings.check_memory);
    limits::raise();
    if settings.lock_memory {
        // Before threads are created, so that their stacks are locked as well.
        match genom_limits::lock_memory() {
            None => tracing::info!("memory is locked"),
            Some(told) => tracing::warn!("{told}"),
        }
    }
    let runtime = tokio::runtime::Builder::new_multi_thread()
        .worker_threads(2)
        .thread_name("genomd-rpc")
        .enable_all()
        .build()
        .map_err(Refusal::own)?;
    let outcome = runtime.block_on(live(settings));
    // A codel that does not return may occupy one of its threads: this does not wait for it.
    runtime.shutdown_background();
    match genom_host::raised_to_stop() {
        // The exit status shows a supervisor of processes that nobody outside asked for the end.
        Some(told) if outcome.is_ok() => Err(Refusal::component(format!("stopped by {told}"))),
        _ => outcome,
    }
}

/// Protects a descriptor of the daemon from codels: neither what they print reaches it, nor
/// children that they fork.
fn own(descriptor: OwnedFd) -> io::Result<OwnedFd> {
    let descriptor = keep_off(descriptor)?;
    keep_from_children(&descriptor);
    Ok(descriptor)
}

async fn open_tcp(
    rpc: &RpcSettings,
    address: SocketAddr,
) -> Result<(Listener, SocketAddr), Refusal> {
    let files = rpc.tls.as_ref().map(|tls| Certificates {
        cert: &tls.cert,
        key: &tls.key,
        client_ca: tls.client_ca.as_deref(),
    });
    let tls = files.map(acceptor).transpose().map_err(Refusal::usage)?;
    let scheme = if tls.is_some() { "https" } else { "http" };
    let (listener, address) = Listener::tcp(address, tls, own).await.map_err(Refusal::own)?;
    tracing::info!("also on {scheme}://{address}");
    Ok((listener, address))
}

/// Makes this daemon reachable for clients of other daemons through each middleware that relays
/// requests, once it is open.
fn announce(daemon: &Arc<Daemon>, tokens: &Arc<Tokens>, log: Arc<Log>) {
    let (weak, runtime) = (Arc::downgrade(daemon), Handle::current());
    let (tokens, names) = (Arc::clone(tokens), announcements::names(daemon.name.as_deref()));
    daemon.supervisor.backends.on_open(move |on: &Arc<dyn Middleware>| {
        let Some(daemon) = weak.upgrade().filter(|_| on.relay().is_some()) else { return };
        // Anybody on the network can send messages here: clients are identified by their proofs.
        let router = rpc::router(&daemon, &tokens, Door::proved(Arc::clone(&log)));
        let open = |name: &str| {
            let (most, weak) = (daemon.rpc.max_body, Arc::downgrade(on));
            // Another one when a gateway was started again.
            let at = move || Some(weak.upgrade()?.relay()?.own());
            let at = move || at().unwrap_or_default();
            Desk::new(&tokens, name, at, on.name(), router.clone(), most)
        };
        daemon.announcements.announce(&names, on.as_ref(), open, &runtime);
    });
}

async fn live(mut settings: Settings) -> Result<(), Refusal> {
    let signals = Signals::take(settings.keep).map_err(Refusal::own)?;
    let socket = Socket::open(&settings.rpc.socket, own).map_err(Refusal::own)?;
    if settings.own_cell.is_some() {
        // Its own socket is open; others would be those of daemons.
        genom_limits::close_doors(&settings.config.cells.limits).map_err(Refusal::own)?;
    }
    let tokens = Tokens::read(settings.rpc.token_file.as_deref()).map_err(Refusal::usage)?;
    let log = Arc::new(Log::default());
    let tcp = match settings.rpc.listen {
        Some(address) => {
            let (listener, address) = open_tcp(&settings.rpc, address).await?;
            // The actual address: the port may have been chosen by the system.
            settings.rpc.listen = Some(address);
            Some(listener)
        }
        None => None,
    };
    let daemon = Daemon::new(&mut settings);
    let names = &settings.config.lifecycle.components;
    let managed = genom_launch::take(names, &mut settings.deployment);
    let console = Console::open(&settings.config.web, &daemon.rpc, &tokens, own, &daemon.closed);
    let console = console.await.map_err(Refusal::own)?;
    console.iter().for_each(|(console, _)| drop(daemon.console.set(console.clone())));
    let foxglove = &settings.config.foxglove;
    let foxglove = Foxglove::open(foxglove, &daemon.rpc, &tokens, own, &daemon.closed);
    let foxglove = foxglove.await.map_err(Refusal::own)?;
    let supervisor = &daemon.supervisor;
    genom_telemetry::tell_middlewares(supervisor);
    tokio::spawn(signals.obey(Arc::clone(&daemon), Arc::clone(&tokens)));
    match settings.lease.take().zip(daemon.own_cell.clone()) {
        // Others reach it through its daemon.
        Some((lease, own)) => {
            let then = settings.config.cells.without_daemon;
            tokio::spawn(own_cell::outlive(lease, then, Arc::clone(supervisor)));
            let startup = Arc::clone(&daemon.startup);
            tokio::spawn(own.keep(Arc::clone(supervisor), move || startup.deployed.is_up()));
        }
        None => announce(&daemon, &tokens, Arc::clone(&log)),
    }
    if let Some(program) = &settings.program {
        program.watch(supervisor).map_err(Refusal::own)?;
    }
    if daemon.own_cell.is_none() {
        daemon.cells.start_gateways().map_err(Refusal::own)?;
        daemon.cells.diagnose(supervisor);
    }
    let opened = open_backend(supervisor).await;
    if let Some(own) = &daemon.own_cell {
        let _ = opened.as_ref().inspect_err(|refusal| own.cannot_open(refusal.message()));
        own.serve(supervisor).map_err(Refusal::own)?;
    }
    opened?;
    if settings.config.clock == ClockKind::Ros {
        ros::follow_clock(&daemon).await?;
    }
    supervisor.watch().map_err(Refusal::own)?;
    supervisor.watch_files().map_err(Refusal::own)?;
    let exporter = settings.collector.clone().map(|collector| {
        let name = daemon.name.clone();
        tokio::spawn(genom_telemetry::export(collector, name, supervisor.closed.clone()))
    });
    tokio::spawn(keep_process(KeptProcess::remember()));

    // Requests are served while components are being loaded: a slow start codel does not delay
    // them.
    let RpcSettings { max_connections, max_connections_per_token, .. } = daemon.rpc;
    let most = Most { connections: max_connections, per_token: max_connections_per_token };
    let (listener, socket) = socket.split();
    let router = rpc::router(&daemon, &tokens, Door::own());
    ros::manage(&daemon, managed, router.clone()).await?;
    ros::contain(&daemon, &settings.config, router.clone()).await?;
    let life = Life { router: router.clone(), supervisor: Arc::clone(supervisor) };
    let mut entrances = vec![Entrance { listener, router }];
    if let Some((console, listener)) = console {
        // For its timeline.
        supervisor.bus.keep();
        let api = rpc::router(&daemon, &tokens, Door::proved(Arc::clone(&log)));
        entrances.push(console.entrance(listener, api));
    }
    if let Some((foxglove, listener)) = foxglove {
        let api = rpc::router(&daemon, &tokens, Door::proved(Arc::clone(&log)));
        entrances.push(foxglove.entrance(listener, api, daemon.name.as_deref()));
    }
    if let Some(listener) = tcp {
        let tls = daemon.rpc.tls.iter().filter(|tls| tls.client_ca.is_some());
        let certified = tls.flat_map(|tls| tls.client_rights.clone()).collect();
        let door = Door::guarded(Arc::clone(&tokens), log, certified);
        entrances.push(Entrance { listener, router: rpc::router(&daemon, &tokens, door) });
    }
    let server = tokio::spawn(serve(entrances, most, daemon.closed.clone()));
    heartbeat(Arc::clone(&daemon.manager), life, Handle::current()).map_err(Refusal::own)?;
    let outcome = tokio::select! {
        outcome = work(&daemon, &settings) => outcome,
        () = supervisor.forced.raised() => {
            let left = supervisor.components.stopping().join(", ");
            Err(Refusal::left_behind(format!("stopped before all codels had ended: {left}")))
        }
    };
    // Removed before the last stream ends: clients that wait for that end find no socket.
    drop(socket);
    supervisor.closed.raise();
    daemon.closed.cancel();
    if let Err(error) = server.await {
        tracing::error!("the control plane ended badly: {error}");
    }
    daemon.kept.all_over().await;
    if let Some(exporter) = exporter {
        // Waits a moment for the last spans to be sent.
        let _ = exporter.await;
    }
    outcome
}

/// Opens the default middleware. This may take a while: some look for peers first.
async fn open_backend(supervisor: &Arc<Supervisor>) -> Result<(), Refusal> {
    let backend = supervisor.settings.backend.clone();
    let (worker, name) = (Arc::clone(supervisor), backend.clone());
    let opening = tokio::task::spawn_blocking(move || worker.backends.get(&name).map(drop));
    let too_long = async {
        // If it is open by then, it is closed properly.
        supervisor.asked_to_stop().await;
        let patience = tokio::time::sleep(supervisor.settings.stop_timeout);
        tokio::select! { () = patience => {}, () = supervisor.forced.raised() => {} }
    };
    tokio::select! {
        opened = opening => opened.map_err(Refusal::own)?.map_err(Refusal::own),
        () = too_long => {
            Err(Refusal::left_behind(format!("stopped while {backend} was being opened")))
        }
    }
}

/// Loads components, runs until asked to stop, and unloads them.
async fn work(daemon: &Daemon, settings: &Settings) -> Result<(), Refusal> {
    let (supervisor, startup) = (&daemon.supervisor, &daemon.startup);
    let mut outcome = Ok(());
    if daemon.own_cell.is_none() {
        daemon.cells.adopt().await;
    }
    match load_all(daemon, settings).await {
        Ok(rest) => {
            startup.ready.raise();
            let serve = |by: &Program| by.serve(supervisor, &daemon.cells, Handle::current());
            if let Some(Err(error)) = settings.program.as_ref().map(serve) {
                supervisor.ask_to_stop(&format!("its program cannot be served: {error}"));
            }
            // Of a cell, its daemon reports it.
            if daemon.own_cell.is_none() {
                let ready = format!("ready on {}", daemon.rpc.socket.display());
                tracing::info!("{ready}");
                daemon.manager.ready(&ready);
                daemon.boxes.tell_unmatched(supervisor, daemon.cells.all()).await;
            }
            tokio::select! {
                refusal = deploy(daemon, settings, rest) => outcome = Err(refusal),
                () = supervisor.asked_to_stop() => {}
            }
        }
        Err(refusal) => outcome = Err(refusal),
    }
    outcome.and(stop(daemon).await)
}

/// What steps of starting and stopping may take beyond their limits, as the service manager is told.
const SPARE: Duration = Duration::from_secs(10);

/// Loads the components of the configuration, in order; stops at the first that is refused. Returns
/// the remaining steps of the deployment.
async fn load_all(daemon: &Daemon, settings: &Settings) -> Result<Vec<Step>, Refusal> {
    let (supervisor, startup) = (&daemon.supervisor, &daemon.startup);
    if daemon.own_cell.is_none() {
        // Cells that a daemon before this one left hold more than the file says.
        let runs = |name: &str| daemon.cells.of(name).is_some();
        block_in_place(|| check_reactions(&supervisor.settings, &settings.deployment, runs))
            .map_err(|(place, error)| Refusal::usage(told(settings, &place, &error)))?;
    }
    let steps = supervisor
        .steps_to(&settings.deployment, false)
        .map(|steps| steps.to_take)
        .map_err(|error| Refusal::usage(told(settings, &error.place(), &error)))?;
    let (loads, rest): (Vec<_>, Vec<_>) =
        steps.into_iter().partition(|step| matches!(step, Step::Load(_)));
    let names = loads.iter().filter_map(|step| match step {
        Step::Load(request) => Some(request.instance()),
        _ => None,
    });
    startup.begins(names.collect());
    if daemon.own_cell.is_none() {
        daemon.cells.open_all(&settings.deployment.component).await;
    }
    let longest = supervisor.settings.start_timeout.max(settings.cells.ready_timeout);
    for step in loads {
        let Step::Load(request) = step else { continue };
        if supervisor.stopping() {
            return Ok(Vec::new());
        }
        let status = format!("loads {}", startup.to_load().join(", then "));
        daemon.manager.status_of_work(&status, longest + SPARE);
        if let (Some(cell), None) = (&request.cell, &daemon.own_cell) {
            load_into(daemon, settings, cell, &request).await?;
            startup.one_is_loaded();
            continue;
        }
        let (worker, asked) = (Arc::clone(supervisor), request.clone());
        let mut loading = tokio::task::spawn_blocking(move || worker.load(&request));
        let loaded = tokio::select! {
            loaded = &mut loading => loaded,
            // Running components are stopped without waiting for one that is starting.
            () = supervisor.asked_to_stop() => tokio::join!(unload_all(supervisor), loading).1,
        };
        match loaded {
            Ok(Ok(_) | Err(LoadError::Stopping)) => startup.one_is_loaded(),
            Ok(Err(error)) => {
                let place = Spot::component(&asked).key(error.key());
                let message = told(settings, &place, &error);
                let given_up = supervisor.start_is_given_up();
                let refuse = if given_up { Refusal::left_behind } else { Refusal::component };
                return Err(refuse(message));
            }
            Err(error) => return Err(Refusal::own(error)),
        }
    }
    Ok(rest)
}

/// Loads a component into a cell, unless one that a daemon before this one left has it.
async fn load_into(
    daemon: &Daemon,
    settings: &Settings,
    cell: &str,
    request: &LoadRequest,
) -> Result<(), Refusal> {
    if daemon.cells.of(&request.instance()).is_some() {
        return Ok(());
    }
    let loading = daemon.cells.load(cell, request);
    let loaded = tokio::select! {
        loaded = loading => loaded,
        () = daemon.supervisor.asked_to_stop() => return Ok(()),
    };
    let place = || Spot::component(request);
    loaded.map(drop).map_err(|error| Refusal::component(told(settings, &place(), &error)))
}

/// Takes the remaining steps of the deployment: connections, which wait for other daemons without a
/// limit, calls and activities. Returns only if a step is refused.
async fn deploy(daemon: &Daemon, settings: &Settings, steps: Vec<Step>) -> Refusal {
    let (supervisor, startup) = (&daemon.supervisor, &daemon.startup);
    let (steps, connections) = match daemon.own_cell {
        Some(_) => (steps, settings.deployment.connection.clone()),
        None => own_part(daemon, settings, steps),
    };
    let in_cells = deploy_in_cells(daemon, settings);
    let worker = Arc::clone(supervisor);
    let work = move || {
        let _turn = worker.deploying();
        worker.apply(&steps, None)?;
        worker.connections.declare(&connections);
        if !steps.is_empty() {
            tracing::info!("deployed: everything is wired and started");
        }
        Ok::<_, ApplyError>(())
    };
    let (own, in_cells) = tokio::join!(tokio::task::spawn_blocking(work), in_cells);
    match (own, in_cells) {
        (_, Err(_)) if supervisor.stopping() => std::future::pending().await,
        (_, Err(refusal)) => refusal,
        (Ok(Ok(())), Ok(asked)) => {
            startup.deployed.raise();
            if let Some(asked) = asked {
                daemon.cells.opened_for(supervisor, asked).await;
            }
            std::future::pending().await
        }
        (Ok(Err(_)), _) if supervisor.stopping() => std::future::pending().await,
        (Ok(Err(error)), _) => Refusal::component(told(settings, &error.place, &error)),
        (Err(error), _) => Refusal::own(error),
    }
}

/// The steps and connections of components that this process runs itself.
fn own_part(
    daemon: &Daemon,
    settings: &Settings,
    steps: Vec<Step>,
) -> (Vec<Step>, Vec<ConnectionEntry>) {
    let own = |name: &str| daemon.cells.of(name).is_none();
    let steps = steps.into_iter().filter(|step| match step {
        Step::Connect(entry) => own(entry.reader()),
        Step::Call(entry) | Step::Start(entry) => own(&entry.component),
        _ => true,
    });
    let connections = settings.deployment.connection.iter();
    (steps.collect(), connections.filter(|entry| own(entry.reader())).cloned().collect())
}

/// Has each cell connect, call and start what the configuration says of its components. What
/// connections need of other processes is open until the result is dropped.
async fn deploy_in_cells(daemon: &Daemon, settings: &Settings) -> Result<Option<Asked>, Refusal> {
    if daemon.own_cell.is_some() {
        return Ok(None);
    }
    let Some(file) = settings.file.clone() else { return Ok(None) };
    let text = match settings.config.lifecycle.components.is_empty() {
        true => std::fs::read_to_string(&file).map_err(Refusal::own)?,
        // Without what ROS loads.
        false => toml::to_string(&settings.deployment).map_err(Refusal::own)?,
    };
    let wanted = DeploymentRequest {
        text,
        file,
        daemon: settings.name.clone(),
        prune: false,
        dry_run: false,
        cell: None,
        timeout: Some(86_400.0),
    };
    loop {
        let applied = async {
            let (cells, whole) = (&daemon.cells, &settings.deployment);
            let asked = cells.open_for(&daemon.supervisor, whole).await?;
            cells.apply(&daemon.supervisor, whole, &wanted).await?;
            Ok(asked)
        };
        match applied.await {
            Ok(asked) => return Ok(Some(asked)),
            // One that ended meanwhile comes back with what it held, or has failed: neither is a
            // reason to end the others.
            Err(OpenError::Down(down) | OpenError::Gone(down))
                if down.state == CellState::Failed =>
            {
                tracing::error!("{down}; what the configuration says of it is not done");
                return Ok(None);
            }
            Err(OpenError::Down(_) | OpenError::Gone(_) | OpenError::Ask(AskError::Gone(_))) => {
                tokio::time::sleep(Duration::from_millis(100)).await;
            }
            Err(error) => return Err(Refusal::component(error)),
        }
    }
}

/// The message, preceded by file, line and key if these are known.
pub(crate) fn told(settings: &Settings, place: &Spot, error: &impl std::fmt::Display) -> String {
    let message = error.to_string();
    // Formatted diagnostics of a description name their own file.
    let file = settings.file.as_ref().filter(|_| !message.starts_with("error"));
    let place = file.and_then(|file| place.told(file, &std::fs::read_to_string(file).ok()?));
    place.map_or(message.clone(), |place| format!("{place}: {message}"))
}

/// Stops all components; those that do not stop are logged and left behind.
async fn unload_all(supervisor: &Arc<Supervisor>) -> Result<(), tokio::task::JoinError> {
    let worker = Arc::clone(supervisor);
    for (_, error) in tokio::task::spawn_blocking(move || worker.unload_all()).await? {
        tracing::error!("{error}");
    }
    Ok(())
}

/// Stops all components while requests under way are still answered.
async fn stop(daemon: &Daemon) -> Result<(), Refusal> {
    let supervisor = &daemon.supervisor;
    supervisor.ask_to_stop("a component was refused");
    daemon.manager.stopping(supervisor.settings.stop_timeout + SPARE);
    let (unloaded, ()) = tokio::join!(unload_all(supervisor), daemon.cells.stop_all());
    unloaded.map_err(|error| {
        Refusal::left_behind(format!("stopping the components ended badly: {error}"))
    })?;
    daemon.announcements.withdraw();
    daemon.offers.end();
    daemon.own_cell.iter().for_each(|own| own.close());
    supervisor.backends.close();
    daemon.cells.stop_gateways().await;
    // Including those left behind by earlier requests.
    let left = supervisor.components.left_behind();
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
