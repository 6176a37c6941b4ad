//! A script: from a request to C functions, or to all that is wrong.

use std::sync::Arc;

use mlua::chunk::ChunkMode;
use mlua::{Error, Lua, MultiValue, Result, Table, Value};
use serde_json::{Value as Json, json};

use crate::check::{Fitting, fitting};
use crate::codel::{Called, Codel, Doing, Parameter, Source, text_of};
use crate::events::{Events, Exceptions, UNKEX, plain};
use crate::foreign::{Class, Closure, Function, Log};
use crate::layout::{Kind, Types};
use crate::limit::Limit;
use crate::request::{self, Direction, From, Request};
use crate::state::State;
use crate::{handles, remotes, value};

/// A script that is loaded.
#[derive(Debug)]
pub(crate) struct Script {
    path: String,
    codels: Vec<Arc<Codel>>,
    closures: Vec<Closure>,
    events: Arc<Events>,
}

impl Script {
    /// Runs a script, and makes a C function of each codel.
    ///
    /// # Errors
    /// All that is wrong with it, as sentences.
    pub(crate) fn load(mut request: Request, log: Log) -> std::result::Result<Self, Vec<String>> {
        let types = Arc::new(Types::new(std::mem::take(&mut request.types)));
        let unusable = unusable(&request, &types);
        if !unusable.is_empty() {
            return Err(unusable);
        }
        Self::made(request, types, log).map_err(|why| vec![plain(&why)])?
    }

    fn made(
        request: Request,
        types: Arc<Types>,
        log: Log,
    ) -> Result<std::result::Result<Self, Vec<String>>> {
        let state = Arc::new(State::new(log)?);
        let mut exceptions = Exceptions::new(state.class.clone(), Arc::clone(&types));
        let module = module(&state.lua, &request, &types, &mut exceptions)?;
        let scope = match run(&state, &request, module)? {
            Ok(scope) => scope,
            Err(why) => return Ok(Err(vec![why])),
        };
        let path = request.path.to_string_lossy().into_owned();
        let found = request.codels.iter().map(|codel| fitting(&state, &scope, &path, codel));
        let mut wrong = Vec::new();
        let found: Vec<Fitting> =
            found.filter_map(|one| one.map_err(|more| wrong.extend(more)).ok()).collect();
        if !wrong.is_empty() {
            let mut told = Vec::new();
            wrong.into_iter().for_each(|one| {
                if !told.contains(&one) {
                    told.push(one);
                }
            });
            return Ok(Err(told));
        }
        let events = Arc::new(events(&request));
        let maker = Maker::new(&request, state, types, events, Arc::new(exceptions));
        let codels = request.codels.iter().zip(found).map(|(one, found)| maker.codel(one, found));
        let codels: Vec<Arc<Codel>> = codels.map(Arc::new).collect();
        let closures: Option<Vec<Closure>> = codels.iter().map(closure).collect();
        let none = || Error::runtime("the system provides no memory for C functions");
        let closures = closures.ok_or_else(none)?;
        Ok(Ok(Self { path, codels, closures, events: maker.events }))
    }

    /// What is told genomd of it.
    pub(crate) fn answer(&self, number: u64) -> Json {
        let names = self.codels.iter().map(|codel| codel.described.name.clone());
        let functions = names.zip(self.closures.iter().map(|one| json!(one.address())));
        let functions: serde_json::Map<String, Json> = functions.collect();
        let events = self.events.range();
        json!({
            "functions": functions,
            "events": { "start": events.start, "end": events.end },
            "number": number,
        })
    }

    /// The C function of a codel.
    pub(crate) fn function(&self, codel: &str) -> Option<Function> {
        let rank = self.codels.iter().position(|one| one.described.name == codel)?;
        self.closures.get(rank).map(Closure::function)
    }

    /// The event of errors.
    pub(crate) fn unkex(&self) -> Option<usize> {
        self.events.get(UNKEX)
    }

    /// The thread that runs a codel of this name.
    pub(crate) fn runs(&self, codel: &str) -> Option<i32> {
        let called = self.codels.iter().filter(|one| one.described.name == codel);
        called.filter_map(|one| one.at.runs()).next()
    }

    /// What a codel of this name is doing, if it is called.
    pub(crate) fn told(&self, codel: &str) -> Option<String> {
        let called = self.codels.iter().filter(|one| one.described.name == codel);
        let (found, what) = called.filter_map(|one| Some((one, one.at.told()?))).next()?;
        Some(format!(
            "codel {codel} of {} ({}) has not returned: it {what}",
            found.defined, self.path
        ))
    }
}

/// Codels with parameters that Lua cannot use.
fn unusable(request: &Request, types: &Types) -> Vec<String> {
    let mut wrong = Vec::new();
    for codel in &request.codels {
        for one in &codel.parameters {
            if let Some(name) = types.unusable(one.ty) {
                wrong.push(format!(
                    "codel `{}` ({}): parameter `{}` ({}): codels in Lua cannot use `{name}`",
                    codel.name, codel.place, one.name, one.place
                ));
            }
        }
    }
    wrong
}

/// Runs the text of a script; returns where its functions are: in the table that it returned, or among
/// the global ones. An error of the script is told with its line.
fn run(
    state: &State,
    request: &Request,
    module: Table,
) -> Result<std::result::Result<Table, String>> {
    let lua = &state.lua;
    let package: Table = lua.globals().get("package")?;
    let preload: Table = package.get("preload")?;
    let given = lua.create_function(move |_, _: MultiValue| Ok(module.clone()))?;
    preload.set(format!("{}_types", request.component), given)?;
    if let Some(beside) = request.path.parent() {
        let (beside, before) = (beside.display(), package.get::<String>("path")?);
        package.set("path", format!("{beside}/?.lua;{beside}/?/init.lua;{before}"))?;
    }
    let path = request.path.to_string_lossy();
    let chunk = lua.load(request.text.as_str()).set_name(format!("@{path}"));
    let function = match chunk.set_mode(ChunkMode::Text).into_function() {
        Ok(function) => function,
        Err(Error::SyntaxError { message, .. }) => return Ok(Err(with_line(&message))),
        Err(why) => return Err(why),
    };
    let limit = Limit::set(lua, request.seconds)?;
    let (well, came): (bool, Value) = state.xpcall.call((function, state.failed.clone()))?;
    drop(limit);
    if well {
        return Ok(Ok(came.as_table().cloned().unwrap_or_else(|| lua.globals())));
    }
    let Value::Table(error) = came else { return Ok(Err(value::shown(&came))) };
    let text = text_of(&error, "text").unwrap_or_else(|| "an exception".to_owned());
    Ok(Err(match (text_of(&error, "file"), text_of(&error, "line")) {
        (Some(file), Some(line)) if *file == *path => format!("line {line}: {text}"),
        (Some(file), Some(line)) => format!("{text} ({file}:{line})"),
        _ => text,
    }))
}

/// The message of a compiler, which has the file first.
fn with_line(message: &str) -> String {
    let number = |part: &str| !part.is_empty() && part.bytes().all(|byte| byte.is_ascii_digit());
    let parts: Vec<&str> = message.splitn(2, ": ").collect();
    match (parts.first().and_then(|place| place.rsplit_once(':')), parts.get(1)) {
        (Some((_, line)), Some(text)) if number(line) => format!("line {line}: {text}"),
        _ => message.to_owned(),
    }
}

/// The module `COMPONENT_types`: exceptions, enumerations and constants by their names; those of other
/// scopes within their scope.
fn module(
    lua: &Lua,
    request: &Request,
    types: &Types,
    exceptions: &mut Exceptions,
) -> Result<Table> {
    let module = lua.create_table()?;
    let place = |name: &[String], value: Value| -> Result<()> {
        let Some((last, scope)) = name.split_last() else { return Ok(()) };
        let own = scope.first() == Some(&request.component);
        let mut at = module.clone();
        for one in if own { &scope[1..] } else { scope } {
            at = match at.raw_get::<Value>(one.as_str())? {
                Value::Table(inner) => inner,
                _ => {
                    let inner = lua.create_table()?;
                    at.raw_set(one.as_str(), &inner)?;
                    inner
                }
            };
        }
        // A type whose name is that of a scope as well has what is in it.
        if let (Value::Table(before), Value::Table(new)) = (at.raw_get(last.as_str())?, &value) {
            before.for_each(|key: Value, inner: Value| new.raw_set(key, inner))?;
        }
        at.raw_set(last.as_str(), value)
    };
    for one in &request.constants {
        place(&one.name, constant(lua, &one.value)?)?;
    }
    for one in &request.declared {
        let Kind::Enum(names) = &types.get(one.ty).kind else { continue };
        let table = lua.create_table()?;
        for name in names {
            table.raw_set(name.as_str(), name.as_str())?;
        }
        place(&one.name, Value::Table(table))?;
        // In IDL, enumerators stand in the scope of their enumeration.
        for name in names {
            let scope = one.name.split_last().map_or(&[][..], |(_, scope)| scope);
            let whole: Vec<String> = scope.iter().chain([name]).cloned().collect();
            place(&whole, Value::String(lua.create_string(name)?))?;
        }
    }
    for one in &request.exceptions {
        let class = exceptions.add(&one.event, one.ty)?;
        place(&one.name, Value::Table(class))?;
    }
    Ok(module)
}

fn constant(lua: &Lua, value: &Json) -> Result<Value> {
    Ok(match value {
        Json::Bool(value) => Value::Boolean(*value),
        Json::Number(value) => match value.as_i64() {
            Some(value) => Value::Integer(value),
            None => Value::Number(value.as_f64().unwrap_or(f64::NAN)),
        },
        Json::String(text) => Value::String(lua.create_string(text)?),
        _ => Value::Nil,
    })
}

/// All events that codels of a component may return.
fn events(request: &Request) -> Events {
    let states = request.codels.iter().flat_map(|codel| codel.yields.iter().flatten());
    let states: Vec<String> =
        states.map(|state| format!("::{}::{state}", request.component)).collect();
    let exceptions = request.exceptions.iter().map(|one| one.event.as_str());
    Events::new(states.iter().map(String::as_str).chain(exceptions).chain([UNKEX]))
}

/// Makes codels.
struct Maker {
    component: String,
    ports: Vec<Arc<handles::Described>>,
    remotes: Vec<Arc<remotes::Described>>,
    state: Arc<State>,
    types: Arc<Types>,
    events: Arc<Events>,
    exceptions: Arc<Exceptions>,
}

impl Maker {
    fn new(
        request: &Request,
        state: Arc<State>,
        types: Arc<Types>,
        events: Arc<Events>,
        exceptions: Arc<Exceptions>,
    ) -> Self {
        let ports = request.ports.iter().map(|one| {
            Arc::new(handles::Described {
                name: one.name.clone(),
                out: one.out,
                multiple: one.multiple,
                ty: one.ty,
                types: Arc::clone(&types),
                exceptions: Arc::clone(&exceptions),
            })
        });
        let remotes = request.remotes.iter().map(|one| {
            Arc::new(remotes::Described {
                name: one.name.clone(),
                parameters: one.parameters.clone(),
                types: Arc::clone(&types),
                exceptions: Arc::clone(&exceptions),
            })
        });
        let (ports, remotes) = (ports.collect(), remotes.collect());
        Self {
            component: request.component.clone(),
            ports,
            remotes,
            state,
            types,
            events,
            exceptions,
        }
    }

    fn codel(&self, described: &request::Codel, found: Fitting) -> Codel {
        let each = described.parameters.iter().map(|one| self.parameter(one));
        let parameters: Vec<Parameter> = each.collect();
        let event = |state: &String| {
            let event = self.events.get(&format!("::{}::{state}", self.component));
            Some((state.clone(), event?))
        };
        Codel {
            described: described.clone(),
            waits: parameters.iter().any(|one| matches!(one.source, Source::Remote(_))),
            parameters,
            order: found.order,
            function: found.function,
            defined: found.defined,
            returns: described.yields.iter().flatten().filter_map(event).collect(),
            state: Arc::clone(&self.state),
            types: Arc::clone(&self.types),
            events: Arc::clone(&self.events),
            exceptions: Arc::clone(&self.exceptions),
            at: Doing::default(),
        }
    }

    fn parameter(&self, one: &request::Parameter) -> Parameter {
        let rank = one.rank.unwrap_or(usize::MAX);
        let constant = one.direction == Direction::In;
        let by_value = self.types.by_value(one.ty).filter(|_| constant);
        let source = match (one.from, self.ports.get(rank), self.remotes.get(rank)) {
            (From::Port, Some(port), _) => Source::Port(Arc::clone(port)),
            (From::Remote, _, Some(remote)) => Source::Remote(Arc::clone(remote)),
            _ => match by_value {
                Some(class) => Source::Value(class),
                None if constant && !self.types.get(one.ty).kind.has_parts() => Source::Read,
                None => Source::View { constant },
            },
        };
        Parameter { ty: one.ty, source }
    }
}

fn closure(codel: &Arc<Codel>) -> Option<Closure> {
    let class = |one: &Parameter| match one.source {
        Source::Value(class) => class,
        _ => Class::Address,
    };
    let classes = codel.parameters.iter().map(class).chain([Class::Address]);
    let classes: Vec<Class> = classes.collect();
    Closure::new(&classes, Box::new(Called(Arc::clone(codel))))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_of_the_compiler_tells_the_line() {
        assert_eq!(with_line("/a/b.lua:3: '=' expected"), "line 3: '=' expected");
        assert_eq!(with_line("no place"), "no place");
    }
}
