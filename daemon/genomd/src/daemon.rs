//! The parts of the daemon: a supervisor of components, and the state of the control plane.

use std::path::PathBuf;
use std::sync::{Arc, OnceLock};

use genom_cells::{BlackBoxes, Cells, Failure, Kept, Reports, Rules, Setup, Told, react};
use genom_configuration::RpcSettings;
use genom_doors::{Slots, Streams};
use genom_launch::Offers;
use genom_supervisor::Supervisor;
use genom_systemd::Manager;
use genom_telemetry::logs;
use genom_web::Console;
use serde_json::Value;
use tokio::sync::mpsc::{UnboundedSender, unbounded_channel};
use tokio_util::sync::CancellationToken;

use crate::announcements::Announcements;
use crate::settings::Settings;
use genom_cells::OwnCell;
use genom_supervisor::bus::startup::Startup;

/// Maximum number of questions to other daemons under way; each may occupy a thread.
const QUESTIONS: usize = 64;

/// The daemon: a supervisor with a control plane.
pub(crate) struct Daemon {
    /// Everything that concerns components.
    pub(crate) supervisor: Arc<Supervisor>,
    /// What its processes did last.
    pub(crate) boxes: Arc<BlackBoxes>,
    /// Recordings that it makes itself.
    pub(crate) kept: Arc<Kept>,
    /// Processes of their own for components; none within a cell.
    pub(crate) cells: Arc<Cells>,
    /// What makes this a cell of another daemon, when it is one.
    pub(crate) own_cell: Option<Arc<OwnCell>>,
    /// Name of this daemon in files that describe several.
    pub(crate) name: Option<String>,
    /// Addresses and limits of the control plane.
    pub(crate) rpc: RpcSettings,
    /// Announcements that make this daemon visible to others.
    pub(crate) announcements: Announcements,
    /// Components that ROS 2 manages.
    pub(crate) offers: Offers,
    /// Progress of loading what the daemon was started with.
    pub(crate) startup: Arc<Startup>,
    /// The service manager that started this process.
    pub(crate) manager: Arc<Manager>,
    /// Open streams.
    pub(crate) streams: Streams,
    /// Slots for questions to other daemons.
    pub(crate) questions: Arc<Slots>,
    /// The web console, once it is open.
    pub(crate) console: OnceLock<Console>,
    /// Cancelled when everything has stopped, to end the control plane.
    pub(crate) closed: CancellationToken,
}

impl Daemon {
    /// A daemon without components.
    pub(crate) fn new(settings: &mut Settings) -> Arc<Self> {
        let (rpc, closed) = (settings.rpc.clone(), CancellationToken::new());
        let supervisor = Supervisor::new(settings.supervisor.clone());
        let (failures, failed) = unbounded_channel();
        let own = settings.own_cell.clone().map(|own| (Arc::downgrade(&supervisor), own));
        supervisor.reactions.set(Rules { failures: failures.clone(), own });
        let boxes = Arc::new(BlackBoxes::new(&settings.config.blackbox));
        boxes.attach(&supervisor, settings.lease.as_mut());
        let cells = Arc::new(cells(settings, &supervisor, Arc::clone(&boxes), failures));
        let reacting = react(Arc::downgrade(&cells), Arc::clone(&supervisor), failed);
        tokio::spawn(reacting);
        tokio::spawn(Cells::keep_ends(Arc::downgrade(&cells), Arc::clone(&supervisor)));
        let known = Arc::clone(&cells);
        supervisor.connections.look_elsewhere(move |name| known.of(name).is_some());
        Arc::new(Self {
            boxes,
            kept: Arc::new(Kept::new(&settings.config.recordings)),
            cells,
            own_cell: settings.own_cell.clone(),
            supervisor,
            name: settings.name.clone(),
            announcements: Announcements::default(),
            offers: Offers::default(),
            startup: Arc::new(Startup::default()),
            manager: Arc::new(Manager::new(&settings.invitation)),
            streams: Streams::new(rpc.max_streams, rpc.max_streams_per_token, closed.clone()),
            questions: Slots::new(QUESTIONS, QUESTIONS / 4),
            console: OnceLock::new(),
            closed,
            rpc,
        })
    }
}

/// The component of a cell that broke a rule whose reaction is `withhold`, and how.
fn withholds(change: &Value) -> Option<(&str, String)> {
    let component = change["component"].as_str()?;
    let broken = change["event"] == "supervision_violated";
    let reactions = change["reactions"].as_array().filter(|_| broken)?;
    let kind = change["kind"].as_str().unwrap_or_default();
    let what = change["what"].as_str().unwrap_or_default();
    let withheld = reactions.iter().any(|reaction| reaction == "withhold");
    withheld.then(|| (component, format!("{kind} supervision of {component}: {what}")))
}

/// The cells there may be; what they tell is told on.
fn cells(
    settings: &Settings,
    supervisor: &Supervisor,
    boxes: Arc<BlackBoxes>,
    failures: UnboundedSender<Failure>,
) -> Cells {
    let (bus, withheld) = (Arc::clone(&supervisor.bus), Arc::clone(&supervisor.withheld));
    Cells::new(Setup {
        // Also when the file was replaced by a newer one since.
        program: PathBuf::from("/proc/self/exe"),
        socket: settings.rpc.socket.clone(),
        config: settings.config.clone(),
        settings: settings.cells.clone(),
        reports: Reports::new(&settings.config.crashes, &settings.rpc.socket),
        boxes,
        stop_timeout: settings.supervisor.stop_timeout,
        embedded: settings.program.is_some(),
        hears: Box::new(move |told| match told {
            Told::Change(change, teller) => {
                if let Some((component, why)) = withholds(&change) {
                    withheld.withhold(component, why);
                }
                bus.tell_on(&change, teller);
            }
            Told::Log(entry) => logs::past().add(&entry),
            Told::Cell(change) => bus.tell(&change),
            // Nobody listens any more when the daemon ends.
            Told::Failed(failure) => drop(failures.send(failure)),
        }),
    })
}
