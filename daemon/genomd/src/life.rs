//! The signs that this daemon lives, for the watchdog of the service manager that started it.

use std::sync::Arc;

use axum::Router;
use genom_protocol::routes;
use genom_supervisor::Supervisor;
use genom_systemd::Signs;

/// In place of a component's name, for the thread that all of them share.
const SHARED: &str = "all components (execution = \"single\")";

/// Where signs of life are looked for: the control plane, and the control threads of components.
/// A codel that does not return is none of the daemon's: it is reported as stuck. On the thread that
/// all components share it is: none of them goes on.
pub(crate) struct Life {
    /// The control plane, as for its own socket.
    pub(crate) router: Router,
    /// What runs the components.
    pub(crate) supervisor: Arc<Supervisor>,
}

impl Signs for Life {
    fn answers(&self) -> impl Future<Output = bool> + Send + 'static {
        let router = self.router.clone();
        async move { genom_doors::answers(router, &routes::about().path).await }
    }

    fn rounds(&self) -> Vec<(String, u64)> {
        let all = self.supervisor.components.all();
        let rounds = all.iter().map(|one| Some((one.name.clone(), one.control_rounds()?)));
        let shared = self.supervisor.shared_rounds().map(|rounds| (SHARED.to_owned(), rounds));
        rounds.flatten().chain(shared).collect()
    }

    fn wake(&self) {
        self.supervisor.components.all().iter().for_each(|one| one.wake_control());
        self.supervisor.wake_shared();
    }

    fn withheld(&self) -> Option<String> {
        self.supervisor.withheld.why()
    }

    fn is_over(&self) -> bool {
        self.supervisor.closed.is_up()
    }
}
