//! Signs of life, while the daemon does its work: not merely while its process runs.

use std::future::Future;
use std::io;
use std::sync::Arc;
use std::sync::mpsc::sync_channel;
use std::thread;
use std::time::{Duration, Instant};

use tokio::runtime::Handle;

use crate::manager::Manager;

/// Between two looks at the rounds of threads.
const LOOK: Duration = Duration::from_millis(2);
/// What the request waits first: so that a runtime whose timers stand still is found, too.
const TICK: Duration = Duration::from_millis(1);

/// Where signs of life are looked for.
pub trait Signs: Send {
    /// Asks the control plane something; whether it answered.
    fn answers(&self) -> impl Future<Output = bool> + Send + 'static;
    /// Threads that have to go on, by name, with the number of their rounds so far.
    fn rounds(&self) -> Vec<(String, u64)>;
    /// Asks each of them for another round.
    fn wake(&self);
    /// Whether the daemon has ended.
    fn is_over(&self) -> bool;
    /// Why no sign is to be given although there are some, if so.
    fn withheld(&self) -> Option<String> {
        None
    }
}

/// What does not live.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
enum Silence {
    #[error("the control plane does not answer")]
    ControlPlane,
    #[error("the control thread of {0} does not go on")]
    Thread(String),
    #[error("signs of life are withheld: {0}")]
    Withheld(String),
}

/// Tells a manager that waits for it that the daemon lives, twice within the time that it waits, in
/// a thread of its own. When something does not live the manager is told nothing: it will end the
/// daemon, and start it again.
///
/// # Errors
/// The system provides no thread.
pub fn heartbeat(
    manager: Arc<Manager>,
    signs: impl Signs + 'static,
    runtime: Handle,
) -> io::Result<()> {
    let Some(longest) = manager.watchdog() else { return Ok(()) };
    let interval = longest / 2;
    thread::Builder::new().name("genomd-beat".to_owned()).spawn(move || {
        let mut told = None;
        while !signs.is_over() {
            let begun = Instant::now();
            let silence = look(&signs, &runtime, interval).err();
            match &silence {
                None => manager.lives(),
                Some(_) if signs.is_over() => return,
                Some(what) if told == silence => tracing::debug!("no sign of life: {what}"),
                Some(what) => tracing::error!(
                    "{what}: the service manager is not told that genomd lives, and ends it \
                     after {} s",
                    longest.as_secs_f64()
                ),
            }
            told = silence;
            thread::park_timeout(interval.saturating_sub(begun.elapsed()));
        }
    })?;
    Ok(())
}

/// Looks for all signs, for a limited time.
fn look(signs: &impl Signs, runtime: &Handle, longest: Duration) -> Result<(), Silence> {
    if let Some(why) = signs.withheld() {
        return Err(Silence::Withheld(why));
    }
    let end = Instant::now() + longest;
    let (tell, told) = sync_channel(1);
    let answers = signs.answers();
    runtime.spawn(async move {
        tokio::time::sleep(TICK).await;
        let _ = tell.try_send(answers.await);
    });
    let mut waiting = signs.rounds();
    signs.wake();
    while !waiting.is_empty() {
        let now = signs.rounds();
        // One that is not there any more has ended.
        waiting.retain(|before| now.contains(before));
        match waiting.first() {
            Some((name, _)) if Instant::now() >= end => return Err(Silence::Thread(name.clone())),
            Some(_) => thread::park_timeout(LOOK),
            None => {}
        }
    }
    match told.recv_timeout(end.saturating_duration_since(Instant::now()).max(LOOK)) {
        Ok(true) => Ok(()),
        _ => Err(Silence::ControlPlane),
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicU64, Ordering};

    use super::*;

    struct Daemon {
        answers: bool,
        round: AtomicU64,
        goes_on: bool,
        withheld: Option<&'static str>,
    }

    impl Signs for Daemon {
        fn answers(&self) -> impl Future<Output = bool> + Send + 'static {
            let answers = self.answers;
            async move { if answers { true } else { std::future::pending().await } }
        }

        fn rounds(&self) -> Vec<(String, u64)> {
            vec![("arm".to_owned(), self.round.load(Ordering::Relaxed))]
        }

        fn wake(&self) {
            self.round.fetch_add(u64::from(self.goes_on), Ordering::Relaxed);
        }

        fn is_over(&self) -> bool {
            false
        }

        fn withheld(&self) -> Option<String> {
            self.withheld.map(str::to_owned)
        }
    }

    #[test]
    fn a_daemon_lives_only_if_its_control_plane_answers_and_its_threads_go_on() {
        let runtime = tokio::runtime::Builder::new_multi_thread().enable_all().build().unwrap();
        let seen = |answers, goes_on, longest| {
            let daemon = Daemon { answers, round: AtomicU64::new(3), goes_on, withheld: None };
            look(&daemon, runtime.handle(), longest)
        };
        assert_eq!(seen(true, true, Duration::from_secs(60)), Ok(()));
        let brief = Duration::from_millis(20);
        assert_eq!(seen(false, true, brief), Err(Silence::ControlPlane));
        assert_eq!(seen(true, false, brief), Err(Silence::Thread("arm".to_owned())));
        let (round, withheld) = (AtomicU64::new(3), Some("arm is late"));
        let daemon = Daemon { answers: true, round, goes_on: true, withheld };
        let silence = look(&daemon, runtime.handle(), brief).unwrap_err();
        assert_eq!(silence.to_string(), "signs of life are withheld: arm is late");
    }

    #[test]
    fn a_runtime_whose_threads_are_held_up_does_not_live() {
        let runtime = tokio::runtime::Builder::new_multi_thread();
        let runtime = { runtime }.worker_threads(1).enable_all().build().unwrap();
        let (let_go, held) = std::sync::mpsc::channel::<()>();
        runtime.spawn(async move {
            let _ = held.recv();
        });
        let (round, withheld) = (AtomicU64::new(0), None);
        let daemon = Daemon { answers: true, round, goes_on: true, withheld };
        let brief = Duration::from_millis(20);
        assert_eq!(look(&daemon, runtime.handle(), brief), Err(Silence::ControlPlane));
        drop(let_go);
        assert_eq!(look(&daemon, runtime.handle(), Duration::from_secs(60)), Ok(()));
    }
}
