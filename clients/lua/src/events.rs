//! Events: what codels return; and the exceptions among them.

use std::collections::HashMap;
use std::sync::Arc;

use mlua::{Function, Lua, Result, Table, Value};

use crate::foreign::{self, At, Memory};
use crate::layout::{Kind, Types};
use crate::value;
use crate::view::{Access, Life};

/// An error that no description declares.
pub(crate) const UNKEX: &str = "::genom::unkex";

/// Bytes of the message in its detail, the NUL included.
const WHAT: usize = 128;

/// The events of one script, as texts that stay where they are as long as it is loaded.
#[derive(Debug)]
pub(crate) struct Events {
    memory: Box<[u8]>,
    places: HashMap<String, usize>,
}

impl Events {
    pub(crate) fn new<'a>(names: impl Iterator<Item = &'a str>) -> Self {
        let (mut memory, mut places) = (Vec::new(), HashMap::new());
        for name in names {
            if !places.contains_key(name) {
                places.insert(name.to_owned(), memory.len());
                memory.extend_from_slice(name.as_bytes());
                memory.push(0);
            }
        }
        Self { memory: memory.into(), places }
    }

    /// Address of an event.
    pub(crate) fn get(&self, name: &str) -> Option<usize> {
        self.places.get(name).map(|at| self.memory.as_ptr() as usize + at)
    }

    /// The addresses of all.
    pub(crate) fn range(&self) -> std::ops::Range<usize> {
        let start = self.memory.as_ptr() as usize;
        start..start + self.memory.len()
    }
}

/// The exceptions that codels of a component may raise.
#[derive(Debug)]
pub(crate) struct Exceptions {
    /// Their classes in Lua, and the types of their details.
    known: HashMap<String, (Table, Option<usize>)>,
    /// Makes a class of an event and the names of its members.
    class: Function,
    types: Arc<Types>,
}

impl Exceptions {
    pub(crate) fn new(class: Function, types: Arc<Types>) -> Self {
        Self { known: HashMap::new(), class, types }
    }

    /// Makes the class of an exception.
    pub(crate) fn add(&mut self, event: &str, ty: Option<usize>) -> Result<Table> {
        let kind = ty.map(|ty| &self.types.get(ty).kind);
        let names: Vec<&str> = match kind {
            Some(Kind::Struct(members)) => members.iter().map(|one| one.name.as_str()).collect(),
            _ => Vec::new(),
        };
        let made: Table = self.class.call((event, names))?;
        self.known.insert(event.to_owned(), (made.clone(), ty));
        Ok(made)
    }

    /// The exception for an event that a port or a remote returned, with its detail.
    pub(crate) fn of(&self, lua: &Lua, event: At, context: At, life: &Life) -> Result<Table> {
        let name = String::from_utf8_lossy(&event.text()).into_owned();
        let known = self.known.get(&name);
        let class = match known {
            Some((class, _)) => class.clone(),
            None => self.class.call((name.as_str(), ["what"]))?,
        };
        let made: Table = lua.create_table()?;
        let detail = foreign::raised(context, event);
        if let (Some(detail), Some((_, Some(ty)))) = (detail, known) {
            let access = Access { constant: true, life: life.clone() };
            let copied = value::copy(lua, &self.types, *ty, detail, &access)?;
            if let Value::Table(members) = copied {
                members.for_each(|name: Value, value: Value| made.raw_set(name, value))?;
            }
        } else if let (Some(detail), None, UNKEX | "::genom::mwerr") =
            (detail, known, name.as_str())
        {
            let bytes = detail.bytes(WHAT);
            let end = bytes.iter().position(|byte| *byte == 0).unwrap_or(WHAT);
            made.raw_set("what", String::from_utf8_lossy(&bytes[..end]))?;
        }
        // Within the same call it can be returned as it is.
        made.raw_set("_recorded", event.address())?;
        made.raw_set("_call", life.number())?;
        made.set_metatable(Some(class))?;
        Ok(made)
    }

    /// Records an exception of a script; returns what the codel is to return.
    ///
    /// # Errors
    /// It cannot be one of the component, for this reason.
    pub(crate) fn raise(
        &self,
        lua: &Lua,
        error: &Table,
        events: &Events,
        context: At,
        life: &Life,
    ) -> std::result::Result<usize, String> {
        let name = event_of(error).unwrap_or_default();
        let number = |key| error.raw_get::<Option<u64>>(key).ok().flatten();
        if let (Some(recorded), Some(call)) = (number("_recorded"), number("_call"))
            && call == life.number()
            && let Ok(recorded) = usize::try_from(recorded)
        {
            return Ok(recorded);
        }
        let (Some((_, ty)), Some(event)) = (self.known.get(&name), events.get(&name)) else {
            return Err(name);
        };
        let Some(ty) = *ty else { return Ok(event) };
        let (size, Kind::Struct(members)) = (self.types.get(ty).size, &self.types.get(ty).kind)
        else {
            return Ok(event);
        };
        let mut memory = Memory::new(size);
        let at = memory.at();
        let filled = members.iter().try_for_each(|member| {
            let value: Value = error.raw_get(member.name.as_str())?;
            if value.is_nil() {
                return Ok(());
            }
            value::put(lua, &self.types, member.ty, at.plus(member.offset), &value)
        });
        let outcome = match filled {
            Ok(()) => Ok(foreign::raise(context, event, at, size)),
            Err(why) => Err(format!("{name}: {}", plain(&why))),
        };
        value::empty(&self.types, ty, at);
        outcome
    }
}

/// The event of an exception, or of a class of exceptions.
pub(crate) fn event_of(error: &Table) -> Option<String> {
    let own = error.raw_get::<Option<String>>("__event").ok().flatten();
    own.or_else(|| error.metatable()?.raw_get::<Option<String>>("__event").ok().flatten())
}

/// Ends an activity with a message; returns what the codel is to return.
pub(crate) fn unkex(events: &Events, what: &str, context: At) -> usize {
    let mut end = what.len().min(WHAT - 1);
    while !what.is_char_boundary(end) {
        end -= 1;
    }
    let mut memory = Memory::new(WHAT);
    memory.at().put_bytes(&what.as_bytes()[..end]);
    let event = events.get(UNKEX).unwrap_or_default();
    foreign::raise(context, event, memory.at(), WHAT)
}

/// The text of an error, without what mlua puts around it.
pub(crate) fn plain(why: &mlua::Error) -> String {
    let text = why.to_string();
    let text = text.strip_prefix("runtime error: ").unwrap_or(&text);
    text.split("\nstack traceback:").next().unwrap_or_default().to_owned()
}
