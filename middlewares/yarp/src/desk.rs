//! The services of a component at `/<component>/rpc`: requests are bottles such as `goto 0.5`.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, RwLock};

use genom_middleware::describe::types_of_service;
use genom_middleware::{ActivityId, Outcome, Replies, ServiceHandler, ServiceKind, ServiceType};
use genom_types::{DataType, Record};

use crate::bottle::reader::{Item, List, Reader};
use crate::bottle::{Value, decode, encode};
use crate::calls::{Calls, Serve};
use crate::replies::{Reply, Respond};
use crate::runs::{Key, Runs, Waiting};
use crate::words;

/// The services of a component.
pub(crate) struct Desk {
    component: String,
    services: Mutex<BTreeMap<String, Arc<Entry>>>,
    runs: Mutex<Runs>,
    connections: Box<dyn Respond>,
}

/// A service.
struct Entry {
    name: String,
    ty: ServiceType,
    /// Taken away when the service is withdrawn, which waits for calls of it to return.
    handler: RwLock<Option<Arc<dyn ServiceHandler>>>,
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

fn bottle(values: &[Value]) -> Vec<u8> {
    Value::to_bottle(values)
}

fn error(sentence: impl Into<String>) -> Vec<u8> {
    bottle(&[Value::from(words::ERROR), Value::Text(sentence.into())])
}

impl Desk {
    pub(crate) fn new(component: &str, connections: impl Respond + 'static) -> Arc<Self> {
        Arc::new(Self {
            component: component.to_owned(),
            services: Mutex::default(),
            runs: Mutex::default(),
            connections: Box::new(connections),
        })
    }

    /// Adds a service. Returns false if there is one of that name.
    pub(crate) fn add(
        &self,
        name: &str,
        ty: &ServiceType,
        handler: Arc<dyn ServiceHandler>,
    ) -> bool {
        let mut services = lock(&self.services);
        if services.contains_key(name) {
            return false;
        }
        let handler = RwLock::new(Some(handler));
        let entry = Entry { name: name.to_owned(), ty: ty.clone(), handler };
        services.insert(name.to_owned(), Arc::new(entry));
        true
    }

    /// Withdraws a service: who waits for it hears that it has gone.
    pub(crate) fn remove(&self, name: &str) {
        let Some(entry) = lock(&self.services).remove(name) else { return };
        let handler = if Calls::is_here() {
            // The service withdraws itself, amid a call: nobody else can be in one.
            entry.handler.try_write().ok().and_then(|mut handler| handler.take())
        } else {
            entry.handler.write().unwrap_or_else(PoisonError::into_inner).take()
        };
        let waiting = lock(&self.runs).withdraw(name);
        waiting.into_iter().for_each(|token| self.answer(token, gone()));
        drop(handler);
    }

    /// Names of the services.
    pub(crate) fn names(&self) -> Vec<String> {
        lock(&self.services).keys().cloned().collect()
    }

    fn answer(&self, token: u64, bottle: Vec<u8>) {
        self.connections.respond(token, Reply::Bottle(bottle));
    }

    /// `Err` is an answer that is given at once.
    fn serve(self: &Arc<Self>, to: Option<u64>, request: &[u8]) -> Result<(), Vec<u8>> {
        let broken = |why: crate::bottle::NoBottle| error(format!("this is no bottle: {why}"));
        let (mut reader, mut list) = Reader::open(request).map_err(broken)?;
        let word = self.word(&mut reader, &mut list, "a service")?;
        if let Some(entry) = self.find(&word) {
            return self.run(to, &entry, None, &mut reader, list);
        }
        match word.as_str() {
            words::START => {
                let name = self.word(&mut reader, &mut list, "a service")?;
                let digest = self.word(&mut reader, &mut list, "the digest of its types")?;
                let entry = self.find(&name).ok_or_else(|| self.nobody(&name))?;
                self.run(to, &entry, Some(&digest), &mut reader, list)
            }
            words::WAIT | words::CANCEL => {
                let name = self.word(&mut reader, &mut list, "a service")?;
                let number = match reader.next(&mut list).map_err(broken)? {
                    Some(Item::Int(number)) => number as u64,
                    _ => return Err(error(format!("write `{word} SERVICE NUMBER`"))),
                };
                let Some(entry) = self.find(&name) else {
                    // Who follows an activity began it before the service went.
                    return Err(if word == words::WAIT { gone() } else { self.nobody(&name) });
                };
                if word == words::WAIT {
                    return self.wait(to, (entry.name.clone(), number));
                }
                let handler = entry.handler.read().unwrap_or_else(PoisonError::into_inner);
                if let Some(handler) = &*handler {
                    handler.cancel(ActivityId(number));
                }
                Err(bottle(&[Value::from(words::OK)]))
            }
            words::HELP | "help" => Err(self.help()),
            other => Err(self.nobody(other)),
        }
    }

    fn word(
        &self,
        reader: &mut Reader<'_>,
        list: &mut List,
        what: &str,
    ) -> Result<String, Vec<u8>> {
        match reader.next(list) {
            Ok(Some(Item::Text(text))) => Ok(String::from_utf8_lossy(text).into_owned()),
            Ok(Some(Item::Vocab(word))) => Ok(Value::Vocab(word).as_word().unwrap_or_default()),
            Ok(other) => {
                let found = other.map_or_else(|| "nothing".to_owned(), |item| item.described());
                Err(error(format!(
                    "{found} where the name of {what} is expected; `help` lists all"
                )))
            }
            Err(why) => Err(error(format!("this is no bottle: {why}"))),
        }
    }

    fn find(&self, name: &str) -> Option<Arc<Entry>> {
        lock(&self.services).get(name).cloned()
    }

    fn nobody(&self, name: &str) -> Vec<u8> {
        let names = self.names().join(", ");
        let sentence = format!("{} has no service `{name}`; it has: {names}", self.component);
        bottle(&[Value::from(words::NOBODY), Value::Text(sentence)])
    }

    fn help(&self) -> Vec<u8> {
        let mut lines = vec![Value::vocab("many")];
        for (name, entry) in &*lock(&self.services) {
            let inputs = members(&entry.ty.input);
            let outputs = members(&entry.ty.output);
            let arrow = if outputs.is_empty() { "" } else { " ->" };
            let kind = match entry.ty.kind {
                ServiceKind::Attribute => "attribute",
                ServiceKind::Function => "function",
                ServiceKind::Activity => "activity",
            };
            lines.push(Value::Text(format!("{name}{inputs}{arrow}{outputs} ({kind})")));
        }
        bottle(&lines)
    }

    fn run(
        self: &Arc<Self>,
        to: Option<u64>,
        entry: &Arc<Entry>,
        digest: Option<&str>,
        reader: &mut Reader<'_>,
        mut list: List,
    ) -> Result<(), Vec<u8>> {
        if digest.is_some_and(|digest| digest != entry.ty.digest()) {
            let ours = Value::Text(types_of_service(&entry.ty));
            return Err(bottle(&[Value::from(words::MISMATCH), ours]));
        }
        let mut message = Vec::new();
        let input = &entry.ty.input;
        let read = decode::values(input, reader, &mut list, &mut message);
        let wrong = |why: String| error(format!("{}{}: {why}", entry.name, members(input)));
        read.map_err(|misfit| wrong(misfit.to_string()))?;
        let mut record = Record::new(input);
        record.decode_message(&message).map_err(|cut| wrong(cut.to_string()))?;
        let answering = Answering {
            desk: Arc::clone(self),
            to,
            service: entry.name.clone(),
            output: entry.ty.output.clone(),
            follows: digest.is_some(),
            run: None,
        };
        let handler = entry.handler.read().unwrap_or_else(PoisonError::into_inner);
        match &*handler {
            Some(handler) => handler.request(record, Box::new(answering)),
            // Withdrawn meanwhile; `answering` says so.
            None => drop(answering),
        }
        Ok(())
    }

    fn wait(&self, to: Option<u64>, key: Key) -> Result<(), Vec<u8>> {
        let Some(token) = to else { return Ok(()) };
        let mut runs = lock(&self.runs);
        match runs.wait(&key, token) {
            Waiting::Report(report) => Err(report),
            Waiting::Later(former) => {
                drop(runs);
                if let Some(former) = former {
                    self.answer(former, error("another one waits for this activity now"));
                }
                Ok(())
            }
            Waiting::Unknown => {
                Err(error(format!("{} has no run {} that is not over", key.0, key.1)))
            }
        }
    }

    fn report(&self, key: &Key, report: Vec<u8>, last: bool) {
        let waiting = lock(&self.runs).report(key, report, last);
        if let Some((token, report)) = waiting {
            self.answer(token, report);
        }
    }
}

impl Serve for Desk {
    fn hear(self: Arc<Self>, token: u64, replies: bool, request: &[u8]) {
        let to = replies.then_some(token);
        if let Err(answer) = self.serve(to, request)
            && replies
        {
            self.answer(token, answer);
        }
    }
}

fn gone() -> Vec<u8> {
    bottle(&[Value::from(words::GONE)])
}

/// ` double goal, long side`: what a bottle holds.
fn members(ty: &DataType) -> String {
    let member = |index: usize| {
        let (name, ty) = (ty.member_name(index)?, ty.member(index)?);
        Some(format!(" {name}:{}", ty.name().trim_start_matches("::")))
    };
    (0..ty.member_count()).filter_map(member).collect()
}

/// Answers a request.
struct Answering {
    desk: Arc<Desk>,
    /// The connection that waits; `None` once it has its answer.
    to: Option<u64>,
    service: String,
    output: DataType,
    /// Whether the caller follows an activity, rather than waiting for its end only.
    follows: bool,
    run: Option<Key>,
}

impl Answering {
    fn say(&mut self, bottle: Vec<u8>, last: bool) {
        if let Some(key) = &self.run {
            self.desk.report(key, bottle, last);
        } else if let Some(to) = self.to.take() {
            self.desk.answer(to, bottle);
        }
    }

    fn outcome(&self, outcome: Outcome) -> Vec<u8> {
        match outcome {
            Outcome::Success(record) => {
                let (mut message, mut answer) = (Vec::new(), Vec::new());
                let encoded = record.encode_message(&mut message).map_err(|why| why.to_string());
                let appended = encoded.and_then(|()| {
                    encode::after(&[words::OK], record.ty(), &message, &mut answer)
                        .map_err(|cut| cut.to_string())
                });
                match appended {
                    Ok(()) => answer,
                    Err(why) => {
                        let ty = self.output.name();
                        error(format!("the result cannot be sent, which is a {ty}: {why}"))
                    }
                }
            }
            Outcome::Exception { name, detail } => {
                let mut values = vec![Value::from(words::EXCEPTION), Value::Text(name)];
                if !detail.is_null() {
                    values.push(Value::Text(detail.to_string()));
                }
                bottle(&values)
            }
            Outcome::Lost(why) => error(why.to_string()),
        }
    }
}

impl Replies for Answering {
    fn accepted(&mut self, id: ActivityId) {
        if !self.follows || self.run.is_some() {
            return;
        }
        let key = (self.service.clone(), id.0);
        if !lock(&self.desk.runs).begin(key.clone()) {
            // It runs, but nobody can follow it.
            self.say(error("too many activities are followed"), true);
            return;
        }
        self.say(bottle(&[Value::from(words::ACCEPTED), Value::Int(id.0 as i64)]), false);
        self.run = Some(key);
    }

    fn feedback(&mut self, state: &str) {
        if self.run.is_some() {
            self.say(bottle(&[Value::from(words::STATE), Value::from(state)]), false);
        }
    }

    fn finish(mut self: Box<Self>, outcome: Outcome) {
        let answer = self.outcome(outcome);
        self.say(answer, true);
        (self.to, self.run) = (None, None);
    }
}

impl Drop for Answering {
    fn drop(&mut self) {
        if self.to.is_some() || self.run.is_some() {
            self.say(gone(), true);
        }
    }
}
