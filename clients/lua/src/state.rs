//! The Lua state of a script, with what scripts have besides the libraries of Lua.

use std::sync::{Mutex, MutexGuard, PoisonError};

use mlua::{AnyUserData, Function, Lua, Result, Table, Value};

use crate::foreign::{self, Log, StateAt};
use crate::view::View;
use crate::{handles, remotes};

/// What of a script its codels share.
#[derive(Debug)]
pub(crate) struct State {
    pub(crate) lua: Lua,
    /// The state of codels that are no coroutines.
    pub(crate) main: StateAt,
    /// Whoever has it runs Lua here.
    turn: Mutex<()>,
    pub(crate) log: Log,
    /// Calls a function with a handler of errors.
    pub(crate) xpcall: Function,
    pub(crate) failed: Function,
    pub(crate) class: Function,
    pub(crate) parameters: Function,
    /// What a coroutine yields first that wants a service called.
    pub(crate) mark: Table,
}

impl State {
    pub(crate) fn new(log: Log) -> Result<Self> {
        let lua = foreign::lua();
        let raw = lua.create_table()?;
        handles::functions(&lua, &raw)?;
        remotes::functions(&lua, &raw)?;
        let copy = |lua: &Lua, value: Value| match &value {
            Value::UserData(view) if view.is::<View>() => view.borrow::<View>()?.copied(lua),
            _ => Ok(value),
        };
        raw.raw_set("copy", lua.create_function(copy)?)?;
        let resize = |_: &Lua, (sequence, count): (AnyUserData, usize)| {
            sequence.borrow::<View>()?.resize(count)
        };
        raw.raw_set("resize", lua.create_function(resize)?)?;
        let prelude = lua.load(include_str!("prelude.lua")).set_name("=[genom]");
        let made: Table = prelude.call(raw)?;
        for name in ["port_index", "port_newindex", "remote_call"] {
            lua.set_named_registry_value(name, made.raw_get::<Function>(name)?)?;
        }
        Ok(Self {
            main: StateAt::of(&lua.current_thread()),
            turn: Mutex::new(()),
            log,
            xpcall: made.raw_get("xpcall")?,
            failed: made.raw_get("failed")?,
            class: made.raw_get("class")?,
            parameters: made.raw_get("parameters")?,
            mark: made.raw_get("mark")?,
            lua,
        })
    }

    /// Waits until no other codel runs here.
    pub(crate) fn turn(&self) -> MutexGuard<'_, ()> {
        self.turn.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
