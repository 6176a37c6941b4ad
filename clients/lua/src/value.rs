//! Values in memory, read and written by their types.

use std::sync::Arc;

use mlua::{Error, Lua, Result, Table, Value};

use crate::foreign::{At, Memory};
use crate::layout::{Kind, Type, Types};
use crate::names::meant;
use crate::view::{Access, View};

/// The value at a place: of types with parts a view.
pub(crate) fn get(
    lua: &Lua,
    types: &Arc<Types>,
    ty: usize,
    at: At,
    access: &Access,
) -> Result<Value> {
    let Type { size, kind, .. } = types.get(ty);
    Ok(match kind {
        Kind::Integer { signed: false } if *size == 8 => {
            let value = u64::from_ne_bytes(at.read());
            i64::try_from(value).map_or_else(|_| Value::Number(value as f64), Value::Integer)
        }
        Kind::Integer { .. } => Value::Integer(number(types, ty, at)),
        Kind::Float if *size == 4 => Value::Number(f32::from_ne_bytes(at.read()).into()),
        Kind::Float => Value::Number(f64::from_ne_bytes(at.read())),
        Kind::Boolean => Value::Boolean(at.read::<1>() != [0]),
        Kind::Char => Value::String(lua.create_string(at.read::<1>())?),
        Kind::Enum(names) => {
            let rank = number(types, ty, at);
            match usize::try_from(rank).ok().and_then(|rank| names.get(rank)) {
                Some(name) => Value::String(lua.create_string(name)?),
                None => Value::Integer(rank),
            }
        }
        Kind::Text(None) => {
            Value::String(lua.create_string(at.follow().map(At::text).unwrap_or_default())?)
        }
        Kind::Text(Some(bound)) => {
            let bytes = at.bytes(*bound);
            let end = bytes.iter().position(|byte| *byte == 0).unwrap_or(*bound);
            Value::String(lua.create_string(&bytes[..end])?)
        }
        Kind::Optional { element, at: inner } => {
            if at.read::<1>() == [0] {
                return Ok(Value::Nil);
            }
            return get(lua, types, *element, at.plus(*inner), access);
        }
        Kind::Array { .. } | Kind::Sequence { .. } | Kind::Struct(_) | Kind::Union { .. } => {
            let view = View { types: Arc::clone(types), ty, at, access: access.clone() };
            Value::UserData(lua.create_userdata(view)?)
        }
        Kind::Unusable => return Err(Error::runtime("codels in Lua cannot use this type")),
    })
}

/// An integer, an enumeration, a boolean or a character as a number.
pub(crate) fn number(types: &Types, ty: usize, at: At) -> i64 {
    let Type { size, kind, .. } = types.get(ty);
    match (size, matches!(kind, Kind::Integer { signed: true })) {
        (1, _) => u8::from_ne_bytes(at.read()).into(),
        (2, true) => i16::from_ne_bytes(at.read()).into(),
        (2, false) => u16::from_ne_bytes(at.read()).into(),
        (4, true) => i32::from_ne_bytes(at.read()).into(),
        (4, false) => u32::from_ne_bytes(at.read()).into(),
        _ => i64::from_ne_bytes(at.read()),
    }
}

/// Stores a value; if it is none of this type, what was there stays.
pub(crate) fn put(lua: &Lua, types: &Arc<Types>, ty: usize, at: At, value: &Value) -> Result<()> {
    let Type { name, size, fixed, kind } = types.get(ty);
    match kind {
        Kind::Integer { signed } => {
            let bytes = integer(value, *size, *signed, name)?;
            // Numbers of less bytes have their low ones first or last.
            match size {
                1 => at.write([bytes as u8]),
                2 => at.write((bytes as u16).to_ne_bytes()),
                4 => at.write((bytes as u32).to_ne_bytes()),
                _ => at.write((bytes as u64).to_ne_bytes()),
            }
        }
        Kind::Float => {
            let value = match value {
                Value::Integer(value) => *value as f64,
                Value::Number(value) => *value,
                other => return Err(wrong(name, other)),
            };
            if *size == 4 {
                at.write((value as f32).to_ne_bytes());
            } else {
                at.write(value.to_ne_bytes());
            }
        }
        Kind::Boolean => match value {
            Value::Boolean(value) => at.write([u8::from(*value)]),
            other => return Err(wrong(name, other)),
        },
        Kind::Char => match value.as_string().map(|text| text.as_bytes().to_vec()) {
            Some(bytes) if bytes.len() == 1 => at.put_bytes(&bytes),
            _ => return Err(wrong("char (one character)", value)),
        },
        Kind::Enum(names) => at.write(enumerator(value, names, name)?.to_ne_bytes()),
        Kind::Text(bound) => put_text(at, value, *bound)?,
        Kind::Optional { .. } if value.is_nil() => empty(types, ty, at),
        Kind::Optional { element, at: inner } => {
            put(lua, types, *element, at.plus(*inner), value)?;
            at.write([1]);
        }
        _ => {
            if let Some(view) = value.as_userdata().and_then(|one| one.borrow::<View>().ok()) {
                view.access.life.check()?;
                if view.ty == ty && *fixed && Arc::ptr_eq(&view.types, types) {
                    at.copy(view.at, *size);
                    return Ok(());
                }
                let copied = copy(lua, &view.types, view.ty, view.at, &view.access)?;
                return made_elsewhere(lua, types, ty, at, &copied);
            }
            return made_elsewhere(lua, types, ty, at, value);
        }
    }
    Ok(())
}

/// Makes a value with parts of a table, and moves it to its place when it is whole.
fn made_elsewhere(lua: &Lua, types: &Arc<Types>, ty: usize, at: At, value: &Value) -> Result<()> {
    let Type { name, size, .. } = types.get(ty);
    let Value::Table(table) = value else { return Err(wrong(name, value)) };
    let mut memory = Memory::new(*size);
    if let Err(why) = fill(lua, types, ty, memory.at(), table) {
        empty(types, ty, memory.at());
        return Err(why);
    }
    empty(types, ty, at);
    at.copy(memory.at(), *size);
    Ok(())
}

/// Stores the parts of a table in empty memory.
fn fill(lua: &Lua, types: &Arc<Types>, ty: usize, at: At, table: &Table) -> Result<()> {
    let Type { name, kind, .. } = types.get(ty);
    match kind {
        Kind::Struct(members) => table.for_each(|key: String, value: Value| {
            let member = members.iter().find(|member| member.name == key).ok_or_else(|| {
                let names = members.iter().map(|member| member.name.as_str());
                Error::runtime(format!("{name} has no member `{key}`{}", meant(&key, names)))
            })?;
            put(lua, types, member.ty, at.plus(member.offset), &value)
                .map_err(|why| within(&key, why))
        }),
        Kind::Union { discriminant, members } => {
            let d: Value = table.raw_get("d")?;
            if !d.is_nil() {
                put(lua, types, *discriminant, at, &d)?;
            }
            let mut chosen = None;
            table.for_each(|key: String, value: Value| {
                if key == "d" {
                    return Ok(());
                }
                let member = members.iter().find(|member| member.name == key);
                let member = member.filter(|_| chosen.is_none()).ok_or_else(|| {
                    Error::runtime(format!("{name}: `{key}` is not its one member"))
                })?;
                chosen = Some(member);
                put(lua, types, member.ty, at.plus(member.offset), &value)
            })?;
            let Some(member) = chosen else { return Ok(()) };
            let label = member.labels.iter().flatten().next();
            match (d.is_nil(), label) {
                (true, Some(label)) => {
                    put_number(types, *discriminant, at, *label);
                    Ok(())
                }
                (true, None) => {
                    Err(Error::runtime(format!("{name}: give `d` with `{}`", member.name)))
                }
                (false, _) => {
                    let d = number(types, *discriminant, at);
                    let named = members.iter().find(|one| one.labels.contains(&Some(d)));
                    let default = || members.iter().find(|one| one.labels.contains(&None));
                    if named.or_else(default).is_some_and(|one| one.name == member.name) {
                        return Ok(());
                    }
                    Err(Error::runtime(format!("{name}: `{}` is not that of d = {d}", member.name)))
                }
            }
        }
        Kind::Array { element, length } => {
            let count = table.raw_len();
            if count != *length {
                return Err(Error::runtime(format!("{length} elements are needed, not {count}")));
            }
            elements_of(lua, types, *element, at, table)
        }
        Kind::Sequence { element, bound, buffer } => {
            resize(types, ty, at, table.raw_len())?;
            match elements(at, *bound, *buffer) {
                Some((first, _)) => elements_of(lua, types, *element, first, table),
                None => Ok(()),
            }
        }
        _ => Err(Error::runtime(format!("{name} has no parts"))),
    }
}

fn elements_of(lua: &Lua, types: &Arc<Types>, element: usize, at: At, table: &Table) -> Result<()> {
    let size = types.get(element).size;
    for rank in 0..table.raw_len() {
        let value: Value = table.raw_get(rank + 1)?;
        put(lua, types, element, at.plus(rank * size), &value)
            .map_err(|why| within(&format!("element {}", rank + 1), why))?;
    }
    Ok(())
}

fn within(part: &str, why: Error) -> Error {
    match why {
        Error::RuntimeError(text) => Error::RuntimeError(format!("{part}: {text}")),
        other => other,
    }
}

/// Stores a number that is one of its type.
fn put_number(types: &Types, ty: usize, at: At, value: i64) {
    match types.get(ty).size {
        1 => at.write([value as u8]),
        2 => at.write((value as u16).to_ne_bytes()),
        4 => at.write((value as u32).to_ne_bytes()),
        _ => at.write(value.to_ne_bytes()),
    }
}

/// An integer of so many bytes.
fn integer(value: &Value, size: usize, signed: bool, name: &str) -> Result<i128> {
    let whole = match value {
        Value::Integer(value) => i128::from(*value),
        Value::Number(value) if value.fract() == 0.0 && value.abs() < 2f64.powi(65) => {
            *value as i128
        }
        other => return Err(wrong(name, other)),
    };
    let bits = size * 8;
    let (low, high) = if signed {
        (-(1i128 << (bits - 1)), (1i128 << (bits - 1)) - 1)
    } else {
        (0, (1i128 << bits) - 1)
    };
    if (low..=high).contains(&whole) {
        return Ok(whole);
    }
    Err(Error::runtime(format!("{whole} is no {name}: {low} to {high}")))
}

fn enumerator(value: &Value, names: &[String], name: &str) -> Result<u32> {
    let rank = match value {
        Value::Integer(rank) => usize::try_from(*rank).ok().filter(|rank| *rank < names.len()),
        Value::String(given) => {
            let given = given.to_string_lossy();
            let rank = names.iter().position(|name| *name == given);
            if rank.is_none() {
                let meant = meant(&given, names.iter().map(String::as_str));
                return Err(Error::runtime(format!("{name} has no `{given}`{meant}")));
            }
            rank
        }
        _ => None,
    };
    rank.and_then(|rank| u32::try_from(rank).ok()).ok_or_else(|| wrong(name, value))
}

fn put_text(at: At, value: &Value, bound: Option<usize>) -> Result<()> {
    let Value::String(text) = value else { return Err(wrong("string", value)) };
    let text = text.to_str().map_err(|_| Error::runtime("a string of IDL is in UTF-8"))?;
    if text.contains('\0') {
        return Err(Error::runtime("a string of IDL has no NUL inside"));
    }
    match bound {
        None => {
            let made = At::of_text(text.as_bytes());
            let made = made.ok_or_else(|| Error::runtime("there is no memory for a string"))?;
            if let Some(before) = at.follow() {
                before.free();
            }
            at.point(Some(made));
        }
        Some(bound) if text.len() < bound => {
            at.clear(bound);
            at.put_bytes(text.as_bytes());
        }
        Some(bound) => {
            let text = format!("{:?} is longer than {} bytes", &*text, bound.saturating_sub(1));
            return Err(Error::runtime(text));
        }
    }
    Ok(())
}

fn wrong(name: &str, value: &Value) -> Error {
    Error::runtime(format!("a {name} is needed, not {}", shown(value)))
}

/// A value in a message.
pub(crate) fn shown(value: &Value) -> String {
    match value {
        Value::String(text) => format!("`{}`", text.to_string_lossy()),
        Value::Integer(value) => value.to_string(),
        Value::Number(value) => value.to_string(),
        Value::Boolean(value) => value.to_string(),
        other => format!("a {}", other.type_name()),
    }
}

/// Releases what a value owns, and makes it the empty one.
pub(crate) fn empty(types: &Types, ty: usize, at: At) {
    let Type { size, fixed, kind, .. } = types.get(ty);
    if *fixed {
        at.clear(*size);
        return;
    }
    match kind {
        Kind::Text(None) => at.follow().into_iter().for_each(At::free),
        Kind::Array { element, length } => {
            let each = types.get(*element).size;
            (0..*length).for_each(|rank| empty(types, *element, at.plus(rank * each)));
        }
        Kind::Sequence { element, bound, buffer } => {
            if let Some((first, count)) = elements(at, *bound, *buffer) {
                let each = types.get(*element).size;
                (0..count).for_each(|rank| empty(types, *element, first.plus(rank * each)));
                if bound.is_none() {
                    first.free_by(at.plus(buffer + 8));
                }
            }
        }
        Kind::Optional { element, at: inner } if at.read::<1>() != [0] => {
            empty(types, *element, at.plus(*inner));
        }
        Kind::Struct(members) => {
            members.iter().for_each(|member| empty(types, member.ty, at.plus(member.offset)));
        }
        Kind::Union { discriminant, members } => {
            let d = number(types, *discriminant, at);
            let named = members.iter().find(|member| member.labels.contains(&Some(d)));
            let default = || members.iter().find(|member| member.labels.contains(&None));
            if let Some(member) = named.or_else(default) {
                empty(types, member.ty, at.plus(member.offset));
            }
        }
        _ => {}
    }
    at.clear(*size);
}

/// The first element of a sequence, and how many there are; `None` of one without memory.
pub(crate) fn elements(at: At, bound: Option<usize>, buffer: usize) -> Option<(At, usize)> {
    let count = u32::from_ne_bytes(at.plus(4).read()) as usize;
    match bound {
        Some(bound) => Some((at.plus(buffer), count.min(bound))),
        None => Some((at.plus(buffer).follow()?, count)),
    }
}

/// Takes elements of a sequence away at the end, or adds empty ones.
pub(crate) fn resize(types: &Types, ty: usize, at: At, count: usize) -> Result<()> {
    let Type { name, kind, .. } = types.get(ty);
    let Kind::Sequence { element, bound, buffer } = kind else {
        return Err(Error::runtime(format!("{name} is no sequence")));
    };
    let most = bound.unwrap_or(u32::MAX as usize);
    let wanted = u32::try_from(count)
        .ok()
        .filter(|_| count <= most)
        .ok_or_else(|| Error::runtime(format!("{count} elements: {name} has at most {most}")))?;
    let each = types.get(*element).size;
    let there = elements(at, *bound, *buffer);
    let before = there.map_or(0, |(_, before)| before);
    if let Some((first, _)) = there {
        (count..before).for_each(|rank| empty(types, *element, first.plus(rank * each)));
    }
    let mut first = there.map(|(first, _)| first);
    let room = u32::from_ne_bytes(at.read()) as usize;
    if let Some(bound) = bound {
        at.write(u32::try_from(*bound).unwrap_or(u32::MAX).to_ne_bytes());
    } else if count > room || (count > 0 && first.is_none()) {
        // As `genom_sequence_resize` in C: twice as many, so that appending is cheap.
        let room = count.max(2 * before).min(u32::MAX as usize);
        let made = At::calloc(room, each);
        let made = made.ok_or_else(|| Error::runtime(format!("no memory for {room} {name}")))?;
        if let Some(old) = first {
            made.copy(old, before * each);
            old.free_by(at.plus(buffer + 8));
        }
        at.write((room as u32).to_ne_bytes());
        at.plus(*buffer).point(Some(made));
        at.plus(buffer + 8).point_to_free();
        first = Some(made);
    }
    if let Some(first) = first.filter(|_| count > before) {
        first.plus(before * each).clear((count - before) * each);
    }
    at.plus(4).write(wanted.to_ne_bytes());
    Ok(())
}

/// A copy of a value: of one with parts, a table.
pub(crate) fn copy(
    lua: &Lua,
    types: &Arc<Types>,
    ty: usize,
    at: At,
    access: &Access,
) -> Result<Value> {
    let list = |element: usize, first: At, count: usize| {
        let table = lua.create_table()?;
        let size = types.get(element).size;
        for rank in 0..count {
            let value = copy(lua, types, element, first.plus(rank * size), access)?;
            table.raw_set(rank + 1, value)?;
        }
        Ok(Value::Table(table))
    };
    match &types.get(ty).kind {
        Kind::Struct(members) => {
            let table = lua.create_table()?;
            for member in members {
                let at = at.plus(member.offset);
                table.raw_set(member.name.as_str(), copy(lua, types, member.ty, at, access)?)?;
            }
            Ok(Value::Table(table))
        }
        Kind::Union { discriminant, members } => {
            let table = lua.create_table()?;
            table.raw_set("d", get(lua, types, *discriminant, at, access)?)?;
            let d = number(types, *discriminant, at);
            let named = members.iter().find(|member| member.labels.contains(&Some(d)));
            let default = || members.iter().find(|member| member.labels.contains(&None));
            if let Some(member) = named.or_else(default) {
                let at = at.plus(member.offset);
                table.raw_set(member.name.as_str(), copy(lua, types, member.ty, at, access)?)?;
            }
            Ok(Value::Table(table))
        }
        Kind::Array { element, length } => list(*element, at, *length),
        Kind::Sequence { element, bound, buffer } => match elements(at, *bound, *buffer) {
            Some((first, count)) => list(*element, first, count),
            None => list(*element, at, 0),
        },
        Kind::Optional { element, at: inner } if at.read::<1>() != [0] => {
            copy(lua, types, *element, at.plus(*inner), access)
        }
        _ => get(lua, types, ty, at, access),
    }
}
