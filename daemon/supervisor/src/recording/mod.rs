//! Recordings of samples of ports and of calls to services, for `genomctl record`.
//!
//! Samples are taken where codels write and read them, with the date of that moment, whatever the
//! middleware. Losses are counted. Dates of a recording continue from its start: if the machine's
//! clock is set meanwhile they do not jump, but a note is recorded.

mod apart;
mod blackbox;
pub(crate) mod heads;
mod notes;
mod pump;

use std::collections::BTreeSet;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use genom_bus::Numbered;
use genom_description::model::PortDirection;
use genom_middleware::Address;
use genom_ports::dates::{Calendar, Dates};
use genom_ports::tape::{Reel, Tape, Tapes, What, tape};
use genom_protocol::RecordingRequest;
use genom_protocol::frames::{Channel, EVENTS};
use genom_types::DataType;
use serde_json::{Value, json};

use crate::outcome::Outcome;
pub use apart::Apart;
pub use blackbox::BlackBox;
use notes::{Notes, Subject};
pub use pump::run;

/// Number of the black box among the recordings that tapes are for; those begin with 1.
const BLACK_BOX: u64 = 0;

/// The running recordings.
#[derive(Default)]
pub struct Recordings {
    dates: Dates,
    last: AtomicU64,
    /// Whether there are recordings; spares the lock when there are none.
    any: AtomicBool,
    /// Whether one of them has calls of services; spares their inputs as JSON otherwise.
    noting: AtomicBool,
    sessions: Mutex<Vec<Arc<Session>>>,
    calls: AtomicU64,
    /// What keeps the last seconds, if anything does.
    blackbox: OnceLock<Arc<BlackBox>>,
    /// Ports of which it was told that they cannot be recorded.
    told: Mutex<BTreeSet<String>>,
}

/// A recording.
pub struct Session {
    /// Its number, unique during the life of the daemon.
    pub number: u64,
    /// Names of components, ports and elements to record; everything if empty.
    wanted: Vec<String>,
    /// What it has of each sample.
    what: What,
    /// Whether it has samples and no notes.
    quiet: bool,
    /// Whether it says how far the clock is.
    ordered: bool,
    /// Channels that the recording's thread has not seen yet.
    new: Mutex<Vec<(Channel, Reel)>>,
    notes: Notes,
    /// Who has what it tells in a recording of its own.
    apart: Arc<Apart>,
    /// Converts moments to dates, as of the beginning of the recording.
    calendar: Calendar,
    dates: Dates,
    /// Whether somebody asked for its end.
    end: AtomicBool,
}

impl Session {
    fn wants(&self, address: &str) -> bool {
        let within = |name: &String| {
            address
                .strip_prefix(name.as_str())
                .is_some_and(|rest| rest.is_empty() || rest.starts_with('/'))
        };
        self.wanted.is_empty() || self.wanted.iter().any(within)
    }

    /// Whether a change belongs into this part of the recording, and its subject.
    fn takes(&self, change: &Numbered) -> Option<Subject> {
        if change.teller.as_ref().is_some_and(|teller| self.apart.has(teller)) {
            return None;
        }
        let (on, component) = notes::subject(change);
        component.is_none_or(|component| self.concerns(component)).then_some(on)
    }

    /// Whether what happens in this component is to be recorded.
    fn concerns(&self, component: &str) -> bool {
        let of = |name: &String| matches!(name.split('/').next(), Some(of) if of == component || of == EVENTS);
        !self.quiet && (self.wanted.is_empty() || self.wanted.iter().any(of))
    }
}

impl Recordings {
    /// No recordings; their dates come from `dates`.
    pub fn new(dates: Dates) -> Self {
        Self { dates, ..Self::default() }
    }

    /// Starts a recording. It covers ports opened from now on, and open ones for which `opened` is
    /// called again.
    pub fn start(&self, wanted: RecordingRequest, apart: Arc<Apart>) -> Arc<Session> {
        self.begin(wanted, apart, false)
    }

    fn begin(&self, wanted: RecordingRequest, apart: Arc<Apart>, quiet: bool) -> Arc<Session> {
        let session = Arc::new(Session {
            number: self.last.fetch_add(1, Ordering::Relaxed) + 1,
            wanted: wanted.ports,
            what: if wanted.times { What::Times } else { What::Contents },
            quiet,
            ordered: wanted.ordered && self.dates.is_stepped(),
            new: Mutex::default(),
            notes: Notes::default(),
            apart,
            calendar: self.dates.calendar(),
            dates: self.dates.clone(),
            end: AtomicBool::new(false),
        });
        self.with(|sessions| {
            sessions.push(Arc::clone(&session));
            self.note_what_there_is(sessions);
        });
        session
    }

    /// Asks a recording to end, once all samples taken are sent. Returns whether there is such a
    /// recording.
    pub fn end(&self, number: u64) -> bool {
        self.with(|sessions| {
            let found = sessions.iter().find(|session| session.number == number);
            found.inspect(|session| session.end.store(true, Ordering::Release)).is_some()
        })
    }

    /// Removes a recording that ended.
    pub fn forget(&self, session: &Session) {
        self.with(|sessions| {
            sessions.retain(|other| other.number != session.number);
            self.note_what_there_is(sessions);
        });
    }

    fn note_what_there_is(&self, sessions: &[Arc<Session>]) {
        self.any.store(!sessions.is_empty(), Ordering::Release);
        self.noting.store(sessions.iter().any(|session| !session.quiet), Ordering::Release);
    }

    /// Whether there are recordings.
    pub fn any(&self) -> bool {
        self.any.load(Ordering::Acquire)
    }

    /// A port was opened or connected. To be called before it is used, or with codels excluded.
    pub fn opened(
        &self,
        address: &Address,
        of: PortDirection,
        reads: Option<&Address>,
        ty: &DataType,
        tapes: &Tapes,
    ) {
        let topic = format!("/{address}");
        let sessions = match self.any() {
            true => {
                self.with(|all| all.iter().filter(|one| one.wants(&topic[1..])).cloned().collect())
            }
            false => Vec::new(),
        };
        let blackbox = self.blackbox.get().filter(|one| one.wants_port(&topic[1..]));
        if sessions.is_empty() && blackbox.is_none() {
            return;
        }
        let Some(head) = heads::of_port(address, of, reads, ty) else {
            let mut told = self.told.lock().unwrap_or_else(PoisonError::into_inner);
            if told.insert(topic.clone()) {
                let (port, ty) = (&topic[1..], ty.name());
                tracing::warn!(
                    "{port} is not recorded: its type {ty} has native members, which only codels \
                     can read"
                );
            }
            return;
        };
        for session in sessions {
            tapes.add(session.number, || {
                let (tape, reel) = tape(session.number, ty, self.dates.clone(), session.what);
                let mut head = head.clone();
                if session.what == What::Times {
                    head.encoding = "times".to_owned();
                }
                let mut new = session.new.lock().unwrap_or_else(PoisonError::into_inner);
                new.push((head, reel));
                tape
            });
        }
        if let Some(blackbox) = blackbox
            && let Some(track) = blackbox.track(&head)
        {
            let make = || Tape::boxed(BLACK_BOX, ty, self.dates.clone(), track);
            tapes.add(BLACK_BOX, make);
        }
    }

    /// From now on, this box takes what ports and services do, besides recordings. To be called
    /// once, before components are loaded.
    pub fn keep(&self, blackbox: Arc<BlackBox>) {
        let _ = self.blackbox.set(blackbox);
    }

    /// A service was called. Returns `None` if there is no recording; otherwise the end of the call
    /// is to be reported to the returned [`Call`].
    pub fn called(
        self: &Arc<Self>,
        component: &str,
        service: &str,
        inputs: impl FnOnce() -> Value,
    ) -> Option<Call> {
        let boxed = self.blackbox.get().filter(|one| one.wants_service(component, service));
        if !self.noting.load(Ordering::Acquire) && boxed.is_none() {
            return None;
        }
        let call = Call {
            recordings: Arc::clone(self),
            number: self.calls.fetch_add(1, Ordering::Relaxed) + 1,
            begin: self.dates.moment(),
            component: component.to_owned(),
            service: service.to_owned(),
        };
        let inputs = inputs();
        self.note(Subject::Calls, (component, service), call.begin, || {
            json!({
                "component": component, "service": service, "call": call.number,
                "phase": "request", "inputs": inputs,
            })
        });
        Some(call)
    }

    fn note(
        &self,
        on: Subject,
        (component, service): (&str, &str),
        moment: u64,
        content: impl FnOnce() -> Value,
    ) {
        let all = match self.any() {
            true => self.with(|sessions| sessions.clone()),
            false => Vec::new(),
        };
        let boxed = self.blackbox.get().filter(|one| one.wants_service(component, service));
        if boxed.is_some() || all.iter().any(|session| session.concerns(component)) {
            let content = content();
            boxed.inspect(|blackbox| blackbox.note(on, moment, &content));
            for session in all.iter().filter(|session| session.concerns(component)) {
                session.notes.add(on, moment, &content);
            }
        }
    }

    fn with<T>(&self, work: impl FnOnce(&mut Vec<Arc<Session>>) -> T) -> T {
        work(&mut self.sessions.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

/// Samples of some ports; nobody else can end it.
pub struct Watch(Arc<Session>);

impl Watch {
    /// Its number among the recordings.
    pub(crate) fn number(&self) -> u64 {
        self.0.number
    }

    /// What to read samples of a port from, since it was opened or connected, with the address of
    /// the port or of its element. Empty most of the time.
    #[must_use]
    pub fn take_new(&self) -> Vec<(String, Reel)> {
        let mut new = self.0.new.lock().unwrap_or_else(PoisonError::into_inner);
        let all = new.drain(..).map(|(head, reel)| {
            let topic = head.topic;
            (topic.strip_prefix('/').unwrap_or(&topic).to_owned(), reel)
        });
        all.collect()
    }
}

impl Recordings {
    /// Starts to watch these ports, those that are opened or connected from now on. What is open
    /// gets a tape of [`tape_of`](Self::tape_of).
    pub(crate) fn watch(&self, ports: Vec<String>) -> Watch {
        let wanted = RecordingRequest { ports, ..RecordingRequest::default() };
        Watch(self.begin(wanted, Arc::default(), true))
    }

    /// Ends a watch.
    pub(crate) fn unwatch(&self, watch: &Watch) {
        self.forget(&watch.0);
    }

    /// A tape for a port that is open already; `None` if it is not watched. Made before codels are
    /// excluded, so that attaching it is all that they wait for.
    pub(crate) fn tape_of(
        &self,
        watch: &Watch,
        address: &Address,
        of: PortDirection,
        ty: &DataType,
    ) -> Option<Tape> {
        let Watch(session) = watch;
        if !session.wants(&address.to_string()) {
            return None;
        }
        let head = heads::of_port(address, of, None, ty)?;
        let (tape, reel) = tape(session.number, ty, self.dates.clone(), session.what);
        session.new.lock().unwrap_or_else(PoisonError::into_inner).push((head, reel));
        Some(tape)
    }
}

/// A recorded call of a service.
pub struct Call {
    recordings: Arc<Recordings>,
    number: u64,
    begin: u64,
    component: String,
    service: String,
}

impl Call {
    /// The service ended.
    pub fn ended(&self, activity: Option<u64>, outcome: &Outcome) {
        let Self { recordings, component, service, .. } = self;
        let now = recordings.dates.moment();
        let told = |more: Value| {
            let mut note = json!({"component": component, "service": service});
            if let (Value::Object(note), Value::Object(more)) = (&mut note, more) {
                note.extend(activity.map(|number| ("activity".to_owned(), number.into())));
                note.extend(more);
                match outcome {
                    Outcome::Success(outputs) => {
                        note.insert("result".to_owned(), outputs.clone());
                    }
                    Outcome::Exception { name, detail } => {
                        note.insert("exception".to_owned(), name.as_str().into());
                        note.insert("detail".to_owned(), detail.clone());
                    }
                }
            }
            note
        };
        recordings.note(Subject::Calls, (component, service), now, || {
            told(json!({
                "call": self.number, "phase": "reply",
                "duration_ns": now.saturating_sub(self.begin),
            }))
        });
        if let Some(exception) = outcome.exception() {
            recordings.note(Subject::Exceptions, (component, service), now, || told(json!({})));
            if let Some(blackbox) = recordings.blackbox.get() {
                blackbox.exception(component, service, activity, exception);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use genom_ports::tape::Way;
    use genom_types::{Kind, Record, ScopedName, TypeTable};

    use super::*;

    #[test]
    fn a_port_that_cannot_be_recorded_is_told_once() {
        let mut table = TypeTable::default();
        let native = table.add(Kind::Native { name: ScopedName::new(["demo", "handle"]) });
        let ty = DataType::new(&Arc::new(table), native).unwrap();
        let recordings = Recordings::default();
        let session = recordings.start(RecordingRequest::default(), Arc::default());
        let at = Address::new("demo", "handle");
        for _ in 0..3 {
            recordings.opened(&at, PortDirection::Out, None, &ty, &Tapes::default());
        }
        let told = recordings.told.lock().unwrap();
        assert_eq!((told.len(), session.new.lock().unwrap().len()), (1, 0));
    }

    #[test]
    fn a_watch_has_every_sample_of_its_ports_and_no_calls() {
        let mut table = TypeTable::default();
        let id = table.add(Kind::Double);
        let ty = DataType::new(&Arc::new(table), id).unwrap();
        let recordings = Arc::new(Recordings::default());
        let watch = recordings.watch(vec!["demo/position".to_owned()]);
        let tape =
            |port| recordings.tape_of(&watch, &Address::new("demo", port), PortDirection::Out, &ty);
        assert!(tape("positions").is_none() && watch.take_new().is_empty());
        let tapes = Tapes::default();
        let made = tape("position").unwrap();
        tapes.add(watch.number(), || made);
        let mut value = Record::new(&ty);
        for number in [1.0, 2.0] {
            value.merge_json(&f64::into(number)).unwrap();
            tapes.take(&value, Way::default());
        }
        // A port that is opened later.
        let later = Tapes::default();
        let at = Address::new("demo", "position/left");
        recordings.opened(&at, PortDirection::Out, None, &ty, &later);
        later.take(&value, Way::default());
        let mut seen = Vec::new();
        for (address, mut reel) in watch.take_new() {
            reel.wind(|sample| seen.push((address.clone(), sample.number)));
        }
        let expected = [("demo/position", 0), ("demo/position", 1), ("demo/position/left", 0)];
        assert_eq!(seen, expected.map(|(address, number)| (address.to_owned(), number)));
        assert!(recordings.any());
        assert!(recordings.called("demo", "goto", || panic!("nobody records calls")).is_none());
        recordings.unwatch(&watch);
        assert!(!recordings.any());
    }
}
