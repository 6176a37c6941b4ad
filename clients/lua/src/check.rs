//! Compares the functions of a script with the codels of the description, before any of them runs.

use mlua::{Function, Result, Table, Value};

use crate::names::{lua_name, meant};
use crate::request::Codel;
use crate::state::State;

/// The function of a codel, which fits.
#[derive(Debug)]
pub(crate) struct Fitting {
    pub(crate) function: Function,
    /// Which parameters of the description it takes, in its order.
    pub(crate) order: Vec<usize>,
    /// Where it is defined.
    pub(crate) defined: String,
}

/// The names of a function's parameters; whether it takes any number; its file and line. Nothing of one
/// in C.
type Told = (Option<Vec<String>>, Option<bool>, Option<String>, Option<u32>);

/// Looks a codel up among what the script defined.
///
/// # Errors
/// All that is wrong with it.
pub(crate) fn fitting(
    state: &State,
    scope: &Table,
    path: &str,
    codel: &Codel,
) -> std::result::Result<Fitting, Vec<String>> {
    let what = format!("codel `{}` ({})", codel.name, codel.place);
    let function = match scope.get::<Value>(codel.name.as_str()) {
        Ok(Value::Function(function)) => function,
        Ok(Value::Nil) => {
            let known = functions(scope).unwrap_or_default();
            let meant = match genom_nearest::nearest(&codel.name, known.iter().map(String::as_str))
            {
                Some(near) => format!("; did you mean `{near}`?"),
                None => String::new(),
            };
            return Err(vec![format!("{what} is not defined{meant}")]);
        }
        Ok(other) => {
            return Err(vec![format!("{what} is a {} here, not a function", other.type_name())]);
        }
        Err(why) => return Err(vec![format!("{what}: {why}")]),
    };
    let (names, any, file, line): Told =
        state.parameters.call(function.clone()).map_err(|why| vec![format!("{what}: {why}")])?;
    let (Some(names), Some(file), Some(line)) = (names, file, line) else {
        return Err(vec![format!("{what} is a function of C here")]);
    };
    let place = if file == path { format!("line {line}") } else { format!("{file}:{line}") };
    let wanted: Vec<String> = codel.parameters.iter().map(|one| lua_name(&one.name)).collect();
    let (mut wrong, mut order) = (Vec::new(), Vec::new());
    if any == Some(true) {
        let what = "it takes any number of arguments (`...`): name those of the description";
        wrong.push(what.to_owned());
    }
    for name in &names {
        match wanted.iter().position(|one| one == name) {
            Some(rank) if !order.contains(&rank) => order.push(rank),
            Some(_) => wrong.push(format!("it takes `{name}` twice")),
            None => {
                let meant = meant(name, wanted.iter().map(String::as_str));
                wrong.push(format!("the description has no parameter `{name}`{meant}"));
            }
        }
    }
    for (name, parameter) in wanted.iter().zip(&codel.parameters) {
        if !names.contains(name) {
            wrong.push(format!("it does not take parameter `{name}` ({})", parameter.place));
        }
    }
    if wrong.is_empty() {
        return Ok(Fitting { function, order, defined: format!("{file}:{line}") });
    }
    Err(wrong.into_iter().map(|one| format!("{what}, {place}: {one}")).collect())
}

/// The names of all functions that a script defined.
fn functions(scope: &Table) -> Result<Vec<String>> {
    let mut names = Vec::new();
    scope.for_each(|name: Value, value: Value| {
        if let (Some(name), true) = (name.as_string(), value.is_function()) {
            names.push(name.to_string_lossy());
        }
        Ok(())
    })?;
    Ok(names)
}
