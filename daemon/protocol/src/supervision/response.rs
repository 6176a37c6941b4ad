//! What is done when a rule is broken.

use std::fmt;

use genom_nearest::suggest;
use serde::de::value::MapAccessDeserializer;
use serde::de::{Error, MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};

use crate::Reaction;
use crate::several::Item;

/// One thing that is done when a rule is broken: a word, or something of another component as in
/// `on_failure`.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub enum Response {
    /// `log`, `event`, `interrupt`, `kill`, `restart` or `withhold`.
    Own(OwnResponse),
    /// A service is called, an activity started, or an event fired.
    Other(Reaction),
}

/// What is done within the component.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub enum OwnResponse {
    /// An entry in the log, and no event.
    Log,
    /// An event on `/events`, and an entry in the log.
    Event,
    /// The activity that broke the rule is asked to stop.
    Interrupt,
    /// The component is asked to end, as by its service `kill`.
    Kill,
    /// The process of the component's cell is ended, and started again by its policy.
    Restart,
    /// The watchdog of the service manager gets no sign of life until somebody clears that.
    Withhold,
}

impl OwnResponse {
    const ALL: [(&str, Self); 6] = [
        ("log", Self::Log),
        ("event", Self::Event),
        ("interrupt", Self::Interrupt),
        ("kill", Self::Kill),
        ("restart", Self::Restart),
        ("withhold", Self::Withhold),
    ];
}

impl Response {
    /// Whether it is this.
    #[must_use]
    pub fn is(&self, own: OwnResponse) -> bool {
        *self == Self::Own(own)
    }
}

impl fmt::Display for Response {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Own(own) => {
                let known = OwnResponse::ALL.iter().find(|(_, one)| one == own);
                f.write_str(known.map_or("", |(name, _)| name))
            }
            Self::Other(reaction) => reaction.fmt(f),
        }
    }
}

impl Item for Response {
    const EXPECTED: &str = "`log`, `event`, `interrupt`, `kill`, `restart`, `withhold`, a table with \
                            `call`, `start` or `fire`, or a list of these";
    const TEXT: bool = true;

    fn mistake(&self) -> Option<String> {
        match self {
            Self::Own(_) => None,
            Self::Other(reaction) => reaction.mistake(),
        }
    }
}

impl<'de> Deserialize<'de> for Response {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        struct One;

        impl<'de> Visitor<'de> for One {
            type Value = Response;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str(<Response as Item>::EXPECTED)
            }

            fn visit_str<E: Error>(self, text: &str) -> Result<Response, E> {
                let known = OwnResponse::ALL.iter().find(|(name, _)| *name == text);
                known.map(|(_, own)| Response::Own(*own)).ok_or_else(|| {
                    let help = suggest(text, OwnResponse::ALL.iter().map(|(name, _)| *name));
                    E::custom(format!("supervision: there is no reaction `{text}`; {help}"))
                })
            }

            fn visit_map<M: MapAccess<'de>>(self, map: M) -> Result<Response, M::Error> {
                Reaction::deserialize(MapAccessDeserializer::new(map)).map(Response::Other)
            }
        }

        from.deserialize_any(One)
    }
}
