//! Codels: C functions that call functions of a script.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicI32, AtomicU8, Ordering};
use std::sync::{Arc, MutexGuard};

use mlua::{AnyUserData, Error, Function, MultiValue, Result, Table, Value};

use crate::events::{self, Events, Exceptions, plain};
use crate::foreign::{self, Arguments, At, Callee, Class, Running, StateAt};
use crate::layout::Types;
use crate::remotes::Prepared;
use crate::state::State;
use crate::view::{Access, Life, View};
use crate::{handles, remotes, request, value};

/// What a parameter is.
#[derive(Debug)]
pub(crate) enum Source {
    /// A value that is passed in a register.
    Value(Class),
    /// A value that is read at each call, at an address.
    Read,
    /// A view of what is at an address.
    View {
        constant: bool,
    },
    Port(Arc<handles::Described>),
    Remote(Arc<remotes::Described>),
}

/// A parameter of a codel.
#[derive(Debug)]
pub(crate) struct Parameter {
    pub(crate) ty: usize,
    pub(crate) source: Source,
}

/// A codel of a script.
#[derive(Debug)]
pub(crate) struct Codel {
    pub(crate) described: request::Codel,
    pub(crate) parameters: Vec<Parameter>,
    /// Which of them the function takes, in its order.
    pub(crate) order: Vec<usize>,
    pub(crate) function: Function,
    /// File and line where it is defined.
    pub(crate) defined: String,
    /// What it may return, and the events of that; empty if it returns nothing.
    pub(crate) returns: Vec<(String, usize)>,
    /// It calls services of other components.
    pub(crate) waits: bool,
    pub(crate) state: Arc<State>,
    pub(crate) types: Arc<Types>,
    pub(crate) events: Arc<Events>,
    pub(crate) exceptions: Arc<Exceptions>,
    pub(crate) at: Doing,
}

/// What a codel is doing, for whom it takes too long, and in which thread.
#[derive(Debug, Default)]
pub(crate) struct Doing(AtomicU8, AtomicI32);

impl Doing {
    const IDLE: u8 = 0;
    const WAITS: u8 = 1;
    const RUNS: u8 = 2;
    const CALLS: u8 = 3;

    fn set(&self, what: u8) {
        self.1.store(foreign::thread(), Ordering::Relaxed);
        self.0.store(what, Ordering::Relaxed);
    }

    /// The thread in which it runs Lua.
    pub(crate) fn runs(&self) -> Option<i32> {
        let runs = self.0.load(Ordering::Relaxed) == Self::RUNS;
        runs.then(|| self.1.load(Ordering::Relaxed))
    }

    /// In words; `None` if it is not called.
    pub(crate) fn told(&self) -> Option<&'static str> {
        match self.0.load(Ordering::Relaxed) {
            Self::WAITS => Some("waits for another codel of its component, which runs Lua"),
            Self::RUNS => Some("runs Lua"),
            Self::CALLS => Some("waits for the service of another component that it calls"),
            _ => None,
        }
    }
}

/// The same codel, for its C function.
#[derive(Debug)]
pub(crate) struct Called(pub(crate) Arc<Codel>);

impl Callee for Called {
    fn call(&self, arguments: Arguments) -> usize {
        let codel = &self.0;
        let Some(context) = arguments.at(codel.parameters.len()).follow() else { return 0 };
        let life = Life::new();
        // What the callee of C code must not do is to unwind into it.
        let called = catch_unwind(AssertUnwindSafe(|| codel.called(arguments, context, &life)));
        codel.at.set(Doing::IDLE);
        life.end();
        called.unwrap_or_else(|_| codel.unkex("genom-lua panicked", "", context))
    }
}

impl Codel {
    fn called(&self, arguments: Arguments, context: At, life: &Life) -> usize {
        self.at.set(Doing::WAITS);
        let turn = self.state.turn();
        self.at.set(Doing::RUNS);
        let outcome = self.made(arguments, context, life).and_then(|made| {
            if self.waits { self.resumed(made, turn) } else { self.run(made, turn) }
        });
        match outcome {
            Ok((_turn, true, event)) => self.event(&event, context),
            Ok((_turn, false, error)) => self.failed(&error, context, life),
            Err(why) => self.unkex(&plain(&why), "", context),
        }
    }

    /// What `xpcall` is called with.
    fn made(&self, arguments: Arguments, context: At, life: &Life) -> Result<MultiValue> {
        let (lua, types) = (&self.state.lua, &self.types);
        let mut made = MultiValue::with_capacity(self.order.len() + 2);
        made.push_back(Value::Function(self.function.clone()));
        made.push_back(Value::Function(self.state.failed.clone()));
        for &rank in &self.order {
            let Parameter { ty, source } = &self.parameters[rank];
            let place = arguments.at(rank);
            let access = |constant| Access { constant, life: life.clone() };
            let at = match source {
                Source::Value(_) => place,
                _ => place.follow().ok_or_else(|| Error::runtime("an argument has no address"))?,
            };
            made.push_back(match source {
                Source::Value(_) | Source::Read => value::get(lua, types, *ty, at, &access(true))?,
                Source::View { constant } => {
                    let access = access(*constant);
                    let view = View { types: Arc::clone(types), ty: *ty, at, access };
                    Value::UserData(lua.create_userdata(view)?)
                }
                Source::Port(described) => {
                    let (described, life) = (Arc::clone(described), life.clone());
                    let port =
                        handles::Port { described, handle: at, context, element: None, life };
                    Value::UserData(lua.create_userdata(port)?)
                }
                Source::Remote(described) => {
                    let (described, life) = (Arc::clone(described), life.clone());
                    let remote = remotes::Remote { described, handle: at, context, life };
                    Value::UserData(lua.create_userdata(remote)?)
                }
            });
        }
        Ok(made)
    }

    fn run<'a>(&self, made: MultiValue, turn: Turn<'a>) -> Result<(Turn<'a>, bool, Value)> {
        let _running = Running::enter(self.state.main);
        let (well, value) = self.state.xpcall.call(made)?;
        Ok((turn, well, value))
    }

    /// Runs the function as a coroutine, and makes the calls that it yields for.
    fn resumed<'a>(
        &'a self,
        made: MultiValue,
        mut turn: Turn<'a>,
    ) -> Result<(Turn<'a>, bool, Value)> {
        let lua = &self.state.lua;
        let thread = lua.create_thread(self.state.xpcall.clone())?;
        let state = StateAt::of(&thread);
        let mut running = Running::enter(state);
        let mut came: MultiValue = thread.resume(made)?;
        while thread.is_resumable() {
            let for_us = came.pop_front().is_some_and(|first| {
                first.as_table().is_some_and(|first| first == &self.state.mark)
            });
            let prepared = came.pop_front().and_then(|one| one.as_userdata().cloned());
            let (true, Some(prepared)) = (for_us, prepared) else {
                return Err(Error::runtime(
                    "it yields: a codel returns its event, and is called again",
                ));
            };
            let mut prepared = AnyUserData::take::<Prepared>(&prepared)?;
            drop((running, turn));
            self.at.set(Doing::CALLS);
            let event = prepared.call();
            self.at.set(Doing::WAITS);
            turn = self.state.turn();
            self.at.set(Doing::RUNS);
            running = Running::enter(state);
            came = thread.resume(prepared.result(lua, event)?)?;
        }
        drop(running);
        let value = came.get(1).cloned().unwrap_or_default();
        Ok((turn, came.front() == Some(&Value::Boolean(true)), value))
    }

    /// The event that the codel returned.
    fn event(&self, returned: &Value, context: At) -> usize {
        if self.returns.is_empty() && returned.is_nil() {
            return 0;
        }
        if let Value::String(text) = returned {
            let text = text.as_bytes();
            let found = self.returns.iter().find(|(name, _)| *name.as_bytes() == *text);
            if let Some((_, event)) = found {
                return *event;
            }
        }
        let all: Vec<String> = self.returns.iter().map(|(name, _)| format!("`{name}`")).collect();
        let may = if all.is_empty() { "nothing".to_owned() } else { all.join(", ") };
        let (returned, request::Codel { name, place, owner, .. }) =
            (value::shown(returned), &self.described);
        self.state.log.error(&format!(
            "codel {name} ({place}) of {owner}, {}, returned {returned}; it may return {may}",
            self.defined
        ));
        let what = format!("{name} returned {returned} ({})", end(&self.defined));
        events::unkex(&self.events, &what, context)
    }

    /// An error left the codel: an exception, or another one with its lines.
    fn failed(&self, error: &Value, context: At, life: &Life) -> usize {
        let Value::Table(error) = error else {
            return self.unkex(&value::shown(error), "", context);
        };
        if events::event_of(error).is_some() {
            let lua = &self.state.lua;
            return match self.exceptions.raise(lua, error, &self.events, context, life) {
                Ok(event) => event,
                Err(why) => self.unkex(&why, "", context),
            };
        }
        let text = |key| text_of(error, key);
        let (what, trace) = (text("text").unwrap_or_default(), text("trace").unwrap_or_default());
        match (text("file"), text("line")) {
            (Some(file), Some(line)) => {
                let place = format!("{file}:{line}");
                self.unkex(&format!("{what} ({})", end(&place)), &trace, context)
            }
            _ => self.unkex(&what, &trace, context),
        }
    }

    /// Logs an error that the description does not declare, and ends the activity with it.
    fn unkex(&self, what: &str, trace: &str, context: At) -> usize {
        let request::Codel { name, place, owner, .. } = &self.described;
        let trace = trace.trim();
        let trace = if trace.is_empty() { &self.defined } else { trace };
        self.state.log.error(&format!(
            "codel {name} ({place}) of {owner} raised an error that the description does not \
             declare: {what}\n{trace}"
        ));
        events::unkex(&self.events, what, context)
    }
}

type Turn<'a> = MutexGuard<'a, ()>;

/// A text of a table that the handler of errors made.
pub(crate) fn text_of(error: &Table, key: &str) -> Option<String> {
    error.raw_get::<Option<String>>(key).ok().flatten()
}

/// The last part of a path, since messages have little room.
fn end(place: &str) -> &str {
    place.rsplit('/').next().unwrap_or(place)
}
