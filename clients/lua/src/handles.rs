//! Ports, as codels get them.

use std::ffi::CString;
use std::sync::Arc;

use mlua::{AnyUserData, Error, Lua, Result, Table, UserData, UserDataFields, UserDataRef, Value};

use crate::events::Exceptions;
use crate::foreign::{self, At, Function};
use crate::layout::Types;
use crate::value;
use crate::view::{Access, Life};

/// What is the same of a port in all calls.
#[derive(Debug)]
pub(crate) struct Described {
    pub(crate) name: String,
    pub(crate) out: bool,
    pub(crate) multiple: bool,
    pub(crate) ty: usize,
    pub(crate) types: Arc<Types>,
    pub(crate) exceptions: Arc<Exceptions>,
}

/// A port in a call, or an element of one.
#[derive(Clone, Debug)]
pub(crate) struct Port {
    pub(crate) described: Arc<Described>,
    /// A table of functions.
    pub(crate) handle: At,
    pub(crate) context: At,
    pub(crate) element: Option<CString>,
    pub(crate) life: Life,
}

/// The functions of a table, by their rank.
const DATA: usize = 0;
const EXCHANGE: usize = 1;
const OPEN: usize = 2;
const CLOSE: usize = 3;

impl Port {
    fn call(&self, rank: usize, element: Option<&CString>) -> Result<Option<At>> {
        self.life.check()?;
        let function = Function::of(self.handle, rank);
        let function = function.ok_or_else(|| Error::runtime("the port has no such function"))?;
        match (self.described.multiple, element) {
            (false, _) => Ok(foreign::simple(function, self.context)),
            (true, Some(element)) => Ok(foreign::named(function, element, self.context)),
            (true, None) => {
                let name = &self.described.name;
                Err(Error::runtime(format!("port {name} is multiple: use {name}:at(NAME)")))
            }
        }
    }

    fn failure(&self, lua: &Lua, event: Option<At>) -> Result<Option<Table>> {
        let exceptions = &self.described.exceptions;
        event.map(|event| exceptions.of(lua, event, self.context, &self.life)).transpose()
    }

    /// Where the value is, if there is one.
    fn place(&self) -> Result<Option<At>> {
        self.call(DATA, self.element.as_ref())
    }

    fn data(&self, lua: &Lua) -> Result<Value> {
        let Some(at) = self.place()? else { return Ok(Value::Nil) };
        let access = Access { constant: !self.described.out, life: self.life.clone() };
        value::get(lua, &self.described.types, self.described.ty, at, &access)
    }

    fn is(&self, out: bool, what: &str) -> Result<()> {
        let name = &self.described.name;
        match (out, self.described.out) {
            (true, false) => Err(Error::runtime(format!("in port {name}: it has no {what}"))),
            (false, true) => Err(Error::runtime(format!("out port {name}: it has no {what}"))),
            _ => Ok(()),
        }
    }

    fn set(&self, lua: &Lua, new: &Value) -> Result<()> {
        self.is(true, "value to be set")?;
        let at = self.place()?.ok_or_else(|| {
            let element = self.element.as_ref().map(|name| name.to_string_lossy());
            let element = element.unwrap_or_default();
            Error::runtime(format!(
                "port {} has no element `{element}`: open it",
                self.described.name
            ))
        })?;
        value::put(lua, &self.described.types, self.described.ty, at, new)
    }

    fn at(&self, element: &str) -> Result<Self> {
        if !self.described.multiple {
            let text = format!("port {} is not multiple", self.described.name);
            return Err(Error::runtime(text));
        }
        Ok(Self { element: Some(c_name(element)?), ..self.clone() })
    }

    /// Creates or removes an element.
    fn change(&self, lua: &Lua, rank: usize, element: &str) -> Result<Option<Table>> {
        self.is(true, "elements to open or close")?;
        if !self.described.multiple {
            let text = format!("port {} is not multiple", self.described.name);
            return Err(Error::runtime(text));
        }
        let event = self.call(rank, Some(&c_name(element)?))?;
        self.failure(lua, event)
    }
}

fn c_name(element: &str) -> Result<CString> {
    CString::new(element).map_err(|_| Error::runtime("the name of an element has no NUL inside"))
}

impl UserData for Port {
    fn add_fields<F: UserDataFields<Self>>(fields: &mut F) {
        for name in ["index", "newindex"] {
            fields.add_meta_field_with(format!("__{name}"), move |lua| {
                lua.named_registry_value::<mlua::Function>(&format!("port_{name}"))
            });
        }
    }
}

type PortRef = UserDataRef<Port>;

/// Functions for the prelude.
pub(crate) fn functions(lua: &Lua, raw: &Table) -> Result<()> {
    let data = |lua: &Lua, port: PortRef| port.data(lua);
    raw.raw_set("data", lua.create_function(data)?)?;
    let set = |lua: &Lua, (port, new): (PortRef, Value)| port.set(lua, &new);
    raw.raw_set("set", lua.create_function(set)?)?;
    for (name, out, what) in [("take", false, "values to read"), ("publish", true, "write")] {
        let exchange = move |lua: &Lua, port: PortRef| {
            port.is(out, what)?;
            let event = port.call(EXCHANGE, port.element.as_ref())?;
            port.failure(lua, event)
        };
        raw.raw_set(name, lua.create_function(exchange)?)?;
    }
    let at = |lua: &Lua, (port, name): (PortRef, String)| -> Result<AnyUserData> {
        lua.create_userdata(port.at(&name)?)
    };
    raw.raw_set("at", lua.create_function(at)?)?;
    for (name, rank) in [("open", OPEN), ("close", CLOSE)] {
        let change =
            move |lua: &Lua, (port, element): (PortRef, String)| port.change(lua, rank, &element);
        raw.raw_set(name, lua.create_function(change)?)?;
    }
    Ok(())
}
