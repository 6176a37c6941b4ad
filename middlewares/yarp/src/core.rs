//! What all ends of a middleware share: its threads, its ports, the name server.

use std::collections::HashMap;
use std::hash::{BuildHasher as _, RandomState};
use std::io::{Read as _, Write as _};
use std::net::{TcpListener, TcpStream};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, Sender as Submit, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use genom_kit::sender::{Duty, Sender};
use genom_middleware::{Address, OpenError};

use crate::calls::Calls;
use crate::error::{BACKEND, NameError, YarpError};
use crate::io::{self, Around, Command, Io};
use crate::jobs::Job;
use crate::line::Line;
use crate::mark::{self, Mark};
use crate::names::{Contact, Names};
use crate::news::News;
use crate::options::Settings;
use crate::port::{Port, Role};
use crate::refusals::Refusals;

/// How long a registered port may take to say that it is there.
const TO_SHOW: Duration = Duration::from_millis(1500);

/// Carriers of our ports, as their properties say it.
const OFFERS: &str = "tcp fast_tcp";
const ACCEPTS: &str = "tcp fast_tcp text text_ack";

/// Duty of the sending thread beside sending: none.
pub(crate) struct Nothing;

impl Duty for Nothing {
    type Line = Line;
}

/// Shared by all ends.
pub(crate) struct Core {
    pub(crate) settings: Settings,
    pub(crate) names: Names,
    pub(crate) io: Io,
    pub(crate) sender: Sender<Nothing>,
    pub(crate) refusals: Arc<Refusals>,
    /// Open ports by name, with their property.
    ports: Mutex<HashMap<String, (Arc<Port>, String)>>,
    /// What ports of others are, as far as it was asked for.
    pub(crate) known: Mutex<HashMap<Contact, Option<Mark>>>,
    steward: Submit<Job>,
    calls: Arc<Calls>,
    threads: Mutex<Vec<JoinHandle<()>>>,
    /// The connection to the name server on which all ports were registered.
    registered: AtomicU64,
    /// Tells in ports of this process from those of others.
    id: String,
}

/// Whether a registered port is there.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Presence {
    /// It answers under its name.
    Here,
    /// Nobody listens there, or another port: a process ended without unregistering.
    Gone,
    /// Something listens there and does not answer.
    Silent,
}

impl Core {
    /// With the jobs that it has for the steward.
    pub(crate) fn new(settings: Settings) -> Result<(Arc<Self>, Receiver<Job>), YarpError> {
        let io = Io::new()?;
        let (steward, jobs) = channel();
        let (calls, calling) = Calls::start()?;
        let refusals = Arc::new(Refusals::default());
        let around = Around {
            steward: steward.clone(),
            calls: Arc::clone(&calls),
            refusals: Arc::clone(&refusals),
            news: News::default(),
            largest: settings.largest_message,
        };
        let connecting = io::start(&io, around)?;
        let core = Arc::new(Self {
            names: Names::new(settings.server.clone()),
            settings,
            io,
            sender: Sender::single(BACKEND, true, Nothing)?,
            refusals,
            ports: Mutex::default(),
            known: Mutex::default(),
            steward,
            calls,
            threads: Mutex::new(vec![calling, connecting]),
            registered: AtomicU64::new(0),
            id: format!("{:08x}", RandomState::new().hash_one(std::process::id()) as u32),
        });
        Ok((core, jobs))
    }

    /// Waits for this thread at the end.
    pub(crate) fn joins(&self, thread: JoinHandle<()>) {
        self.threads.lock().unwrap_or_else(PoisonError::into_inner).push(thread);
    }

    fn lock(&self) -> MutexGuard<'_, HashMap<String, (Arc<Port>, String)>> {
        self.ports.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The open ports.
    pub(crate) fn ports(&self) -> Vec<Arc<Port>> {
        self.lock().values().map(|(port, _)| Arc::clone(port)).collect()
    }

    /// What a port of ours is, if it is open.
    pub(crate) fn own(&self, name: &str) -> Option<Mark> {
        self.lock().get(name).and_then(|(_, property)| Mark::parse(property))
    }

    /// Name on YARP of an address. An absolute one is as it is.
    pub(crate) fn name_of(&self, at: &Address) -> String {
        if at.instance.is_empty() {
            return format!("/{}", at.name);
        }
        format!("{}/{}/{}", self.settings.prefix, at.instance, at.name)
    }

    /// Beginning of the names of in ports that read an out port.
    pub(crate) fn readers_of(name: &str) -> String {
        format!("{name}:i/")
    }

    /// A name for an in port of this process.
    pub(crate) fn reader_of(&self, name: &str) -> String {
        format!("{}{}-{}", Self::readers_of(name), self.id, self.io.token())
    }

    pub(crate) fn failed(&self, at: &Address, why: impl ToString) -> OpenError {
        let (backend, why) = (BACKEND.to_owned(), why.to_string());
        OpenError::Failed { backend, address: at.clone(), why }
    }

    /// Opens a port: it listens, and the name server knows it.
    pub(crate) fn open(
        &self,
        at: &Address,
        name: &str,
        property: String,
        role: Role,
    ) -> Result<Arc<Port>, OpenError> {
        let listening = || -> std::io::Result<_> {
            let listener = TcpListener::bind((self.settings.listen, 0))?;
            listener.set_nonblocking(true)?;
            let address = listener.local_addr()?;
            Ok((listener, address))
        };
        let (listener, address) = listening().map_err(|error| {
            let ip = self.settings.listen;
            self.failed(at, format!("cannot listen at {ip}: {error}"))
        })?;
        let (id, name) = (self.io.token(), name.to_owned());
        let port = Arc::new(Port { id, name: name.clone(), at: address, role });
        let mut ports = self.lock();
        if ports.contains_key(&name) {
            return Err(OpenError::Taken { address: at.clone() });
        }
        ports.insert(name.clone(), (Arc::clone(&port), property.clone()));
        drop(ports);
        self.io.submit(Command::Listen { port: Arc::clone(&port), listener });
        match self.register(&port, &property) {
            Ok(()) => Ok(port),
            Err(error) => {
                self.close(&port);
                Err(self.failed(at, error))
            }
        }
    }

    fn register(&self, port: &Port, property: &str) -> Result<(), NameError> {
        self.names.register(&port.name, port.at)?;
        self.names.set(&port.name, mark::PROPERTY, property)?;
        let offers = if matches!(port.role, Role::Out(_)) { OFFERS } else { "" };
        if !offers.is_empty() {
            self.names.set(&port.name, "offers", offers)?;
        }
        self.names.set(&port.name, "accepts", ACCEPTS)
    }

    /// Changes what a port says of itself.
    pub(crate) fn describe(&self, port: &Port, property: String) {
        let told = self.names.set(&port.name, mark::PROPERTY, &property);
        if let Err(error) = told {
            tracing::debug!(name = port.name, %error, "the YARP name server was not told");
        }
        if let Some((_, kept)) = self.lock().get_mut(&port.name) {
            *kept = property;
        }
    }

    /// Registers all ports at a name server that may have been started anew. Returns whether it
    /// was another one than before.
    pub(crate) fn register_again(&self) -> Result<bool, NameError> {
        let now = self.names.connections();
        let before = self.registered.load(Ordering::SeqCst);
        if before == now {
            return Ok(false);
        }
        let ports: Vec<_> = self.lock().values().cloned().collect();
        for (port, property) in ports {
            self.register(&port, &property)?;
            if !self.lock().contains_key(&port.name) {
                // Closed meanwhile.
                self.names.unregister(&port.name)?;
            }
        }
        self.registered.store(now, Ordering::SeqCst);
        Ok(before != 0)
    }

    /// Closes a port: its name is free again when this returns.
    pub(crate) fn close(&self, port: &Port) {
        self.lock().remove(&port.name);
        self.io.submit(Command::Close { port: port.id });
        // Unless another one has taken the name over.
        let ours = |contact: &Contact| contact.port == port.at.port();
        let unregistered = self.names.query(&port.name).and_then(|found| {
            found.filter(ours).map_or(Ok(()), |_| self.names.unregister(&port.name))
        });
        if let Err(error) = unregistered {
            tracing::debug!(name = port.name, %error, "a YARP name was not unregistered");
        }
    }

    /// Looks for out ports soon.
    pub(crate) fn look(&self) {
        let _ = self.steward.send(Job::Look);
    }

    /// Whether a registered port is there.
    pub(crate) fn presence(&self, contact: &Contact) -> Presence {
        if self.lock().contains_key(&contact.name) {
            return Presence::Here;
        }
        let Some(address) = contact.address() else { return Presence::Gone };
        let Ok(mut stream) = TcpStream::connect_timeout(&address, TO_SHOW) else {
            return Presence::Gone;
        };
        let _ = stream.set_read_timeout(Some(TO_SHOW));
        if stream.write_all(b"CONNACK genomd\r\n*\r\n").is_err() {
            return Presence::Gone;
        }
        let mut said = Vec::new();
        let mut piece = [0; 1024];
        while said.len() < 4096 {
            match stream.read(&mut piece) {
                Ok(0) => return Presence::Gone,
                Ok(size) => said.extend_from_slice(piece.get(..size).unwrap_or_default()),
                Err(_) => return Presence::Silent,
            }
            let text = String::from_utf8_lossy(&said);
            let Some((_, after)) = text.split_once("This is ") else { continue };
            let Some((name, _)) = after.split_once(" at ") else { continue };
            let here = name.trim_matches('"') == contact.name;
            return if here { Presence::Here } else { Presence::Gone };
        }
        Presence::Silent
    }
}

impl Drop for Core {
    fn drop(&mut self) {
        let _ = self.steward.send(Job::End);
        if !Calls::is_here() {
            self.calls.end();
        }
        self.io.end();
        let threads =
            std::mem::take(&mut *self.threads.lock().unwrap_or_else(PoisonError::into_inner));
        for thread in threads {
            // This may be one of them: what a handler held was the last.
            if thread.thread().id() != std::thread::current().id() {
                // A panic of the thread has been reported already.
                let _ = thread.join();
            }
        }
    }
}
