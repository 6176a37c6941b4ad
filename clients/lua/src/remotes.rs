//! Services of other components, as codels call them.

use std::sync::Arc;

use mlua::{Error, Lua, Result, Table, UserData, UserDataFields, UserDataRef, Value};

use crate::events::Exceptions;
use crate::foreign::{self, At, Class, Function, Memory};
use crate::layout::Types;
use crate::names::meant;
use crate::request::{Direction, Passed};
use crate::value;
use crate::view::{Access, Life};

/// What is the same of a remote in all calls.
#[derive(Debug)]
pub(crate) struct Described {
    pub(crate) name: String,
    pub(crate) parameters: Vec<Passed>,
    pub(crate) types: Arc<Types>,
    pub(crate) exceptions: Arc<Exceptions>,
}

/// A remote in a call of a codel.
#[derive(Clone, Debug)]
pub(crate) struct Remote {
    pub(crate) described: Arc<Described>,
    /// A table with its function.
    pub(crate) handle: At,
    pub(crate) context: At,
    pub(crate) life: Life,
}

impl UserData for Remote {
    fn add_fields<F: UserDataFields<Self>>(fields: &mut F) {
        fields.add_meta_field_with("__call", |lua| {
            lua.named_registry_value::<mlua::Function>("remote_call")
        });
    }
}

/// A call that has its inputs, and waits to be made.
#[derive(Debug)]
pub(crate) struct Prepared {
    remote: Remote,
    function: Function,
    /// The value of each parameter.
    values: Vec<Memory>,
    /// What is passed: a value, or the place of its address in `addresses`.
    arguments: Vec<(Class, At)>,
    _addresses: Vec<Memory>,
}

impl UserData for Prepared {}

impl Prepared {
    fn new(lua: &Lua, remote: &Remote, inputs: &Table) -> Result<Self> {
        remote.life.check()?;
        let Described { name, parameters, types, .. } = &*remote.described;
        let inputs_of = || parameters.iter().filter(|one| one.direction != Direction::Out);
        inputs.for_each(|given: String, _: Value| {
            if inputs_of().any(|one| one.name == given) {
                return Ok(());
            }
            let meant = meant(&given, inputs_of().map(|one| one.name.as_str()));
            Err(Error::runtime(format!("{name} has no input `{given}`{meant}")))
        })?;
        let function = Function::of(remote.handle, 0);
        let mut made = Self {
            remote: remote.clone(),
            function: function.ok_or_else(|| Error::runtime("the remote has no function"))?,
            values: Vec::new(),
            arguments: Vec::new(),
            _addresses: Vec::new(),
        };
        for one in parameters {
            let mut memory = Memory::new(types.get(one.ty).size);
            let at = memory.at();
            // Dropped with what the value owns if a later one is refused.
            made.values.push(memory);
            if one.direction != Direction::Out {
                let value: Value = inputs.raw_get(one.name.as_str())?;
                if value.is_nil() && !is_optional(types, one.ty) {
                    return Err(Error::runtime(format!("{name} wants input `{}`", one.name)));
                }
                value::put(lua, types, one.ty, at, &value)?;
            }
            let by_value = types.by_value(one.ty).filter(|_| one.direction == Direction::In);
            made.arguments.push(match by_value {
                Some(class) => (class, at),
                None => {
                    let mut address = Memory::new(size_of::<usize>());
                    let place = address.at();
                    place.point(Some(at));
                    made._addresses.push(address);
                    (Class::Address, place)
                }
            });
        }
        Ok(made)
    }

    /// Calls the service and waits for its end; no Lua runs.
    pub(crate) fn call(&self) -> Option<At> {
        foreign::passed(self.function, &self.arguments, self.remote.context)
    }

    /// The exception that it returned, or its outputs.
    pub(crate) fn result(
        &mut self,
        lua: &Lua,
        event: Option<At>,
    ) -> Result<(Option<Table>, Option<Table>)> {
        let Described { parameters, types, exceptions, .. } = &*self.remote.described;
        if let Some(event) = event {
            let failure = exceptions.of(lua, event, self.remote.context, &self.remote.life)?;
            return Ok((Some(failure), None));
        }
        let outputs = lua.create_table()?;
        let access = Access { constant: false, life: self.remote.life.clone() };
        for (one, memory) in parameters.iter().zip(&mut self.values) {
            if one.direction != Direction::In {
                let value = value::copy(lua, types, one.ty, memory.at(), &access)?;
                outputs.raw_set(one.name.as_str(), value)?;
            }
        }
        Ok((None, Some(outputs)))
    }
}

fn is_optional(types: &Types, ty: usize) -> bool {
    matches!(types.get(ty).kind, crate::layout::Kind::Optional { .. })
}

impl Drop for Prepared {
    fn drop(&mut self) {
        let Described { parameters, types, .. } = &*self.remote.described;
        for (one, memory) in parameters.iter().zip(&mut self.values) {
            value::empty(types, one.ty, memory.at());
        }
    }
}

/// Functions for the prelude.
pub(crate) fn functions(lua: &Lua, raw: &Table) -> Result<()> {
    let prepare = |lua: &Lua, (remote, inputs): (UserDataRef<Remote>, Table)| {
        lua.create_userdata(Prepared::new(lua, &remote, &inputs)?)
    };
    raw.raw_set("prepare", lua.create_function(prepare)?)
}
