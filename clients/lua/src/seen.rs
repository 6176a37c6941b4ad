//! What codels can do with views.

use mlua::{Error, Lua, MetaMethod, Result, UserData, UserDataMethods, Value};

use crate::foreign::At;
use crate::layout::{Kind, Member};
use crate::names::meant;
use crate::value;
use crate::view::View;

impl View {
    /// How many elements it has.
    fn count(&self) -> Option<usize> {
        match &self.types.get(self.ty).kind {
            Kind::Array { length, .. } => Some(*length),
            Kind::Sequence { bound, buffer, .. } => {
                Some(value::elements(self.at, *bound, *buffer).map_or(0, |(_, count)| count))
            }
            _ => None,
        }
    }

    /// The type of a part, and where it lies; `None` of an element beyond the last.
    fn part(&self, key: &Value) -> Result<Option<(usize, At)>> {
        let ty = self.types.get(self.ty);
        match &ty.kind {
            Kind::Struct(members) => self.member(members, key).map(Some),
            Kind::Union { discriminant, members } => {
                if is_word(key, "d") {
                    return Ok(Some((*discriminant, self.at)));
                }
                let found = self.member(members, key)?;
                let d = value::number(&self.types, *discriminant, self.at);
                let chosen = members.iter().find(|member| member.labels.contains(&Some(d)));
                let other = || members.iter().find(|member| member.labels.contains(&None));
                match chosen.or_else(other) {
                    Some(has) if found.1 == self.at.plus(has.offset) && is_word(key, &has.name) => {
                        Ok(Some(found))
                    }
                    Some(has) => Err(Error::runtime(format!("d is {d}: it has `{}`", has.name))),
                    None => Err(Error::runtime(format!("d is {d}: it has no member"))),
                }
            }
            Kind::Array { element, .. } | Kind::Sequence { element, .. } => {
                let Some(rank) = key.as_integer().or_else(|| whole(key)) else {
                    let key = value::shown(key);
                    let text = format!("{} has elements from 1 to its length, no {key}", ty.name);
                    return Err(Error::runtime(text));
                };
                let first = match &ty.kind {
                    Kind::Sequence { bound, buffer, .. } => {
                        value::elements(self.at, *bound, *buffer).map(|(first, _)| first)
                    }
                    _ => Some(self.at),
                };
                let rank = usize::try_from(rank).unwrap_or_default();
                let there = (1..=self.count().unwrap_or_default()).contains(&rank);
                let size = self.types.get(*element).size;
                let at = first.filter(|_| there);
                Ok(at.map(|first| (*element, first.plus(rank.saturating_sub(1) * size))))
            }
            _ if is_word(key, "value") => Ok(Some((self.ty, self.at))),
            _ => {
                let key = value::shown(key);
                let text = format!("it is a place for a {}: use its `value`, not {key}", ty.name);
                Err(Error::runtime(text))
            }
        }
    }

    fn member(&self, members: &[Member], key: &Value) -> Result<(usize, At)> {
        let found = key.as_string().and_then(|name| {
            let name = name.as_bytes();
            members.iter().find(|member| *member.name.as_bytes() == *name)
        });
        let found = found.ok_or_else(|| {
            let name = key.as_string().map(mlua::LuaString::to_string_lossy).unwrap_or_default();
            let names = members.iter().map(|member| member.name.as_str());
            let (ty, key) = (&self.types.get(self.ty).name, value::shown(key));
            Error::runtime(format!("{ty} has no member {key}{}", meant(&name, names)))
        })?;
        Ok((found.ty, self.at.plus(found.offset)))
    }

    fn set(&self, lua: &Lua, key: &Value, new: &Value) -> Result<()> {
        self.access.life.check()?;
        if self.access.constant {
            return Err(Error::runtime("an `in` argument cannot be changed"));
        }
        if let Some((ty, at)) = self.part(key)? {
            return value::put(lua, &self.types, ty, at, new);
        }
        // One more element.
        let count = self.count().unwrap_or_default();
        let next = key.as_integer().and_then(|rank| usize::try_from(rank).ok()) == Some(count + 1);
        if !next || !matches!(self.types.get(self.ty).kind, Kind::Sequence { .. }) {
            let text = format!("there is no element {}, only {count}", value::shown(key));
            return Err(Error::runtime(text));
        }
        value::resize(&self.types, self.ty, self.at, count + 1)?;
        let put = match self.part(key)? {
            Some((ty, at)) => value::put(lua, &self.types, ty, at, new),
            None => Ok(()),
        };
        if put.is_err() {
            value::resize(&self.types, self.ty, self.at, count)?;
        }
        put
    }

    /// A copy as tables.
    pub(crate) fn copied(&self, lua: &Lua) -> Result<Value> {
        self.access.life.check()?;
        value::copy(lua, &self.types, self.ty, self.at, &self.access)
    }

    /// Has a sequence have so many elements.
    pub(crate) fn resize(&self, count: usize) -> Result<()> {
        self.access.life.check()?;
        if self.access.constant {
            return Err(Error::runtime("an `in` argument cannot be changed"));
        }
        value::resize(&self.types, self.ty, self.at, count)
    }
}

fn is_word(key: &Value, word: &str) -> bool {
    key.as_string().is_some_and(|key| *key.as_bytes() == *word.as_bytes())
}

/// An index that was computed.
fn whole(key: &Value) -> Option<i64> {
    let number = key.as_number().filter(|number| number.fract() == 0.0 && number.abs() < 1e15)?;
    Some(number as i64)
}

impl UserData for View {
    fn add_methods<M: UserDataMethods<Self>>(methods: &mut M) {
        methods.add_meta_method(MetaMethod::Index, |lua, view, key: Value| {
            view.access.life.check()?;
            match view.part(&key)? {
                Some((ty, at)) => value::get(lua, &view.types, ty, at, &view.access),
                None => Ok(Value::Nil),
            }
        });
        methods.add_meta_method(MetaMethod::NewIndex, |lua, view, (key, new): (Value, Value)| {
            view.set(lua, &key, &new)
        });
        methods.add_meta_method(MetaMethod::Len, |_, view, ()| {
            view.access.life.check()?;
            view.count().ok_or_else(|| {
                Error::runtime(format!("{} has no length", view.types.get(view.ty).name))
            })
        });
        methods.add_meta_method(MetaMethod::ToString, |_, view, ()| {
            Ok(format!("view of {}", view.types.get(view.ty).name))
        });
        methods.add_meta_method(MetaMethod::Pairs, |lua, view, ()| {
            let next: Value = lua.globals().get("next")?;
            Ok((next, view.copied(lua)?, Value::Nil))
        });
    }
}
