//! Lists that may be written as one item alone.

use std::fmt;
use std::marker::PhantomData;

use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer, StrDeserializer};
use serde::de::{DeserializeOwned, Error, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};

/// An item of such a list.
pub(crate) trait Item: DeserializeOwned {
    /// What may stand there.
    const EXPECTED: &str;
    /// Whether it may be a text.
    const TEXT: bool = false;

    /// What is wrong with it beyond its form.
    fn mistake(&self) -> Option<String>;
}

/// Reads one item, or a list of them.
pub(crate) fn one_or_several<'de, D: Deserializer<'de>, T: Item>(
    from: D,
) -> Result<Vec<T>, D::Error> {
    let all: Vec<T> = from.deserialize_any(OneOrSeveral(PhantomData))?;
    match all.iter().find_map(Item::mistake) {
        Some(mistake) => Err(D::Error::custom(mistake)),
        None => Ok(all),
    }
}

struct OneOrSeveral<T>(PhantomData<T>);

impl<'de, T: Item> Visitor<'de> for OneOrSeveral<T> {
    type Value = Vec<T>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(T::EXPECTED)
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<Vec<T>, E> {
        if T::TEXT {
            return T::deserialize(StrDeserializer::new(text)).map(|one| vec![one]);
        }
        Err(E::invalid_type(serde::de::Unexpected::Str(text), &self))
    }

    fn visit_map<M: MapAccess<'de>>(self, map: M) -> Result<Vec<T>, M::Error> {
        T::deserialize(MapAccessDeserializer::new(map)).map(|one| vec![one])
    }

    fn visit_seq<S: SeqAccess<'de>>(self, all: S) -> Result<Vec<T>, S::Error> {
        Vec::deserialize(SeqAccessDeserializer::new(all))
    }
}
