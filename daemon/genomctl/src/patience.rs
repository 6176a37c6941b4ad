//! Waits for a daemon without a limit while it answers other requests, and only up to a limit if it
//! answers none, because its process is stopped or hangs.

use std::future::Future;
use std::pin::pin;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use http_body_util::Empty;
use hyper::body::Bytes;
use hyper::client::conn::http1;
use hyper::{Request, header};
use hyper_util::rt::TokioIo;
use tokio::sync::watch;
use tokio::task::AbortHandle;
use tokio::time::{Instant, sleep_until, timeout};

use crate::failure::Failure;
use crate::target::Target;

/// Waits for `waiting`. Whenever nothing has arrived for half of `limit`, `ask` makes another
/// request; the wait fails if that is not answered within the other half.
pub(crate) async fn patiently<T, A: Future<Output = Result<(), Failure>>>(
    limit: Duration,
    waiting: impl Future<Output = T>,
    ask: impl Fn() -> A,
    silent: impl Fn() -> Failure,
) -> Result<T, Failure> {
    let mut waiting = pin!(waiting);
    loop {
        if let Ok(done) = timeout(limit / 2, &mut waiting).await {
            return Ok(done);
        }
        tokio::select! {
            biased;
            done = &mut waiting => return Ok(done),
            answer = timeout(limit / 2, ask()) => answer.unwrap_or_else(|_| Err(silent()))?,
        }
    }
}

/// Monitors a daemon while its reply is awaited, in a task of its own. A wait that is cancelled and
/// repeated, as a recorder does each second, therefore does not restart the limit.
#[derive(Debug)]
pub(crate) struct Watch {
    target: Arc<Target>,
    /// The daemon's process, if known.
    process: Option<i32>,
    /// When the daemon last sent something.
    heard: Arc<Mutex<Instant>>,
    /// Becomes true when the daemon answers no requests.
    silent: watch::Receiver<bool>,
    guard: AbortHandle,
}

impl Watch {
    pub(crate) fn new(target: &Arc<Target>, process: Option<i32>) -> Self {
        let heard = Arc::new(Mutex::new(Instant::now()));
        let (tell, silent) = watch::channel(false);
        let guard = tokio::spawn(guard(Arc::clone(target), Arc::clone(&heard), tell));
        let guard = guard.abort_handle();
        Self { target: Arc::clone(target), process, heard, silent, guard }
    }

    /// Waits for `waiting`; fails when the daemon answers no requests.
    pub(crate) async fn over<T>(&self, waiting: impl Future<Output = T>) -> Result<T, Failure> {
        let mut silent = self.silent.clone();
        tokio::select! {
            biased;
            done = waiting => {
                *self.heard.lock().unwrap_or_else(PoisonError::into_inner) = Instant::now();
                Ok(done)
            }
            Ok(_) = silent.wait_for(|silent| *silent) => Err(self.target.silent(self.process)),
        }
    }
}

impl Drop for Watch {
    fn drop(&mut self) {
        self.guard.abort();
    }
}

/// Monitors a daemon until it answers no requests.
async fn guard(target: Arc<Target>, heard: Arc<Mutex<Instant>>, tell: watch::Sender<bool>) {
    let last = || *heard.lock().unwrap_or_else(PoisonError::into_inner);
    loop {
        let before = last();
        sleep_until(before + target.limit / 2).await;
        if last() != before {
            continue;
        }
        match timeout(target.limit / 2, answers(&target)).await {
            Err(_) | Ok(Err(Failure::Silent { .. })) if last() == before => {
                let _ = tell.send(true);
                return;
            }
            // It answers, or the connection is closed, which the wait itself detects.
            _ => *heard.lock().unwrap_or_else(PoisonError::into_inner) = Instant::now(),
        }
    }
}

/// Makes the cheapest request; any reply will do.
async fn answers(target: &Target) -> Result<(), Failure> {
    let (stream, _) = target.open().await?;
    let (mut sender, connection) = http1::handshake(TokioIo::new(stream))
        .await
        .map_err(|error| target.misread(error.to_string()))?;
    tokio::spawn(connection);
    let request = Request::get("/").header(header::HOST, "genomd").body(Empty::<Bytes>::new());
    let request = request.map_err(|error| target.misread(error.to_string()))?;
    sender.send_request(request).await.map_err(|_| target.lost())?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::Cell;

    fn runtime() -> tokio::runtime::Runtime {
        tokio::runtime::Builder::new_current_thread().enable_time().build().unwrap()
    }

    const MOMENT: Duration = Duration::from_millis(2);

    #[test]
    fn who_answers_others_is_waited_for() {
        let asked = Cell::new(0);
        let ask = || {
            asked.set(asked.get() + 1);
            std::future::ready(Ok(()))
        };
        let slow = async {
            while asked.get() < 3 {
                tokio::task::yield_now().await;
            }
            7
        };
        let silent = || Failure::refused("silent", String::new());
        assert_eq!(runtime().block_on(patiently(MOMENT, slow, ask, silent)).unwrap(), 7);
    }

    #[test]
    fn who_answers_nobody_is_given_up() {
        let never = std::future::pending::<()>;
        let ask = std::future::pending::<Result<(), Failure>>;
        let silent = || Failure::refused("silent", "no answer".to_owned());
        let given_up = runtime().block_on(patiently(MOMENT, never(), ask, silent)).unwrap_err();
        assert_eq!(given_up.to_string(), "no answer");
    }
}
