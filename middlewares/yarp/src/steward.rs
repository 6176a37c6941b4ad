//! The thread that talks with the name server: it connects in ports to the out ports that they
//! read, and registers everything again at a name server that was started anew.

use std::io;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::sync::{Arc, Mutex, PoisonError, Weak};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use crate::core::Core;
use crate::io::{Answer, Command, Errand, Io, Lost, Step};
use crate::jobs::Job;
use crate::port::{Port, Role};
use crate::wire::Carrier;

/// Time between two looks for out ports, and whether the name server is there.
const LOOK: Duration = Duration::from_millis(500);

/// Time until one that was asked for: many who ask at once cost one.
const SOON: Duration = Duration::from_millis(20);

/// With that many in ports without an out port, one list is asked for instead.
const LISTED: usize = 16;

/// Starts the thread.
pub(crate) fn start(jobs: Receiver<Job>, core: Weak<Core>) -> io::Result<JoinHandle<()>> {
    let thread = std::thread::Builder::new().name("yarp-steward".to_owned());
    thread.spawn(move || run(&jobs, &core))
}

fn run(jobs: &Receiver<Job>, core: &Weak<Core>) {
    let (mut due, mut absent) = (Instant::now() + LOOK, false);
    loop {
        let left = due.saturating_duration_since(Instant::now());
        let job = jobs.recv_timeout(left);
        // Nothing is kept alive while this waits.
        let Some(core) = core.upgrade() else { return };
        match job {
            Ok(Job::Connect { port, to, carrier, answer }) => {
                connect(&core, port, to, carrier, answer);
                continue;
            }
            Ok(Job::Look) => {
                due = due.min(Instant::now() + SOON);
                continue;
            }
            Err(RecvTimeoutError::Timeout) => {}
            Ok(Job::End) | Err(RecvTimeoutError::Disconnected) => return,
        }
        look(&core, &mut absent);
        due = Instant::now() + LOOK;
    }
}

fn connect(core: &Core, port: Arc<Port>, to: String, carrier: Carrier, answer: Answer) {
    let found = match core.names.query(&to) {
        Ok(Some(contact)) => contact.address().ok_or_else(|| "its host has no address".to_owned()),
        Ok(None) => Err(format!("there is no port {to}")),
        Err(error) => Err(error.to_string()),
    };
    match found {
        Ok(at) => {
            let answer = Some(answer);
            core.io.submit(Command::Link { port, to, at, carrier, answer });
        }
        Err(why) => answer(Err(why)),
    }
}

fn look(core: &Core, absent: &mut bool) {
    let ports = core.ports();
    if ports.is_empty() {
        return;
    }
    // Any question shows whether the server is there, and is another one than before.
    let looked = core.names.query(&core.settings.namespace).and_then(|_| core.register_again());
    match looked {
        Ok(again) => {
            if std::mem::take(absent) || again {
                tracing::info!(
                    server = core.names.server(),
                    "the YARP name server knows our ports"
                );
            }
        }
        Err(error) => {
            if !std::mem::replace(absent, true) {
                tracing::warn!("{error}; connections that stand go on");
            }
            return;
        }
    }
    let lonely: Vec<_> = ports.iter().filter(|port| is_lonely(port)).collect();
    let listed = if lonely.len() > LISTED { core.names.list("").ok() } else { None };
    for port in lonely {
        let Role::In(reads) = &port.role else { continue };
        let source = match &listed {
            Some(list) => list.iter().find(|contact| contact.name == reads.source).cloned(),
            None => core.names.query(&reads.source).ok().flatten(),
        };
        if let Some(at) = source.and_then(|source| source.address()) {
            Asking::send(&core.io, port, at, core.settings.carrier);
        }
    }
}

fn is_lonely(port: &Port) -> bool {
    matches!(&port.role, Role::In(reads) if !reads.is_connected())
}

/// Asks an out port to connect to an in port of ours, as `yarp connect` does.
pub(crate) struct Asking {
    from: String,
    to: String,
    carrier: Carrier,
    /// Set while somebody asks for this in port.
    under_way: Arc<AtomicBool>,
    refusal: Arc<Mutex<String>>,
}

impl Asking {
    /// Does nothing while the same is being asked already.
    pub(crate) fn send(io: &Io, port: &Port, at: std::net::SocketAddr, carrier: Carrier) {
        let Role::In(reads) = &port.role else { return };
        if reads.asking.swap(true, Ordering::SeqCst) {
            return;
        }
        let asking = Self {
            from: reads.source.clone(),
            to: port.name.clone(),
            carrier,
            under_way: Arc::clone(&reads.asking),
            refusal: Arc::clone(&reads.refusal),
        };
        io.submit(Command::Errand { at, errand: Box::new(asking) });
    }
}

impl Drop for Asking {
    fn drop(&mut self) {
        self.under_way.store(false, Ordering::SeqCst);
    }
}

impl Errand for Asking {
    fn carrier(&self) -> Carrier {
        Carrier::TextAck
    }

    fn begin(&mut self) -> Vec<u8> {
        let to = format!("{}:/{}", self.carrier.name(), self.to);
        format!("a\r\n[add] \"{to}\"\r\n").into_bytes()
    }

    fn hear(&mut self, bytes: &[u8]) -> Step {
        let text = String::from_utf8_lossy(bytes);
        if !text.contains("<ACK>") && bytes.len() < 4096 {
            return Step::Wait;
        }
        if text.trim_start().starts_with('-') {
            let said = text.lines().next().unwrap_or_default();
            let mut known = self.refusal.lock().unwrap_or_else(PoisonError::into_inner);
            if *known != said {
                tracing::warn!(from = self.from, to = self.to, "no YARP connection: {said}");
                said.clone_into(&mut known);
            }
        }
        Step::Done
    }

    fn lost(self: Box<Self>, how: Lost) {
        tracing::debug!(from = self.from, to = self.to, ?how, "a YARP port does not answer");
    }
}
