//! The state of a running system: what `genomctl freeze` writes, and `genomctl thaw` reads.

use std::collections::BTreeMap;
use std::io;

use serde::{Deserialize, Serialize};
use serde_json::ser::{Formatter, Serializer};

use crate::{Deployment, FrozenComponent, is_false};

/// What `format` says.
pub const FORMAT: &str = "genomd freeze";
/// The version of the format that this program writes, and the newest that it reads.
pub const VERSION: u32 = 1;
/// Most bytes of a file that is read: JSON takes several times as much memory.
pub const MOST: usize = 32 << 20;

/// A running system.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Frozen {
    /// Always `genomd freeze`.
    pub format: String,
    /// Version of the format.
    #[cfg_attr(feature = "openapi", schema(value_type = u64))]
    pub version: u32,
    /// Version of the genomd that wrote it.
    pub genomd: String,
    /// Name of the default middleware.
    pub backend: String,
    /// What runs, as a deployment file has it.
    pub deployment: Deployment,
    /// The state of each component, by instance name.
    pub components: BTreeMap<String, FrozenComponent>,
}

/// A system to bring back.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct ThawRequest {
    /// The system.
    pub frozen: Frozen,
    /// Unload components of the same names first.
    #[serde(default, skip_serializing_if = "is_false")]
    pub replace: bool,
}

/// A system was brought back.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Thawed {
    /// The components that go on, in the order in which they were loaded.
    pub components: Vec<ThawedComponent>,
}

/// A component that goes on.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct ThawedComponent {
    /// Instance name.
    pub name: String,
    /// Number of its activities that go on.
    pub activities: usize,
    /// What was not taken over as it was: members that are new or gone, activities that cannot go on.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
}

/// A held component goes on.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct GoesOn {
    /// Always true.
    pub goes_on: bool,
}

/// A text is no frozen system.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum NotFrozen {
    /// It is another kind of file.
    #[error("this is no file of `genomctl freeze`: {0}")]
    Foreign(String),
    /// It is of a later version.
    #[error(
        "written by genomd {genomd} in version {version} of the format, and this one reads up to \
         {VERSION}: use a genomd that is as new"
    )]
    Newer {
        /// Version of the format.
        version: u32,
        /// Version of the program.
        genomd: String,
    },
    /// Something in it is wrong.
    #[error("{0}")]
    Damaged(#[from] serde_json::Error),
    /// It is too large.
    #[error(
        "{size} bytes are more than the {MOST} that are read; freeze fewer components at a time"
    )]
    Large {
        /// Its size.
        size: u64,
    },
}

impl Frozen {
    /// As text of a file: one line for each list.
    #[must_use]
    pub fn text(&self) -> String {
        text_of(self)
    }

    /// Reads the text of a file.
    ///
    /// # Errors
    /// It is another file, damaged or of a later version; the message gives line and column.
    pub fn read(text: &str) -> Result<Self, NotFrozen> {
        #[derive(Deserialize)]
        struct Head {
            format: Option<String>,
            #[serde(default)]
            version: u32,
            #[serde(default)]
            genomd: String,
        }
        if text.len() > MOST {
            return Err(NotFrozen::Large { size: text.len() as u64 });
        }
        let head = serde_json::from_str::<Head>(text);
        let Head { format, version, genomd } =
            head.map_err(|error| NotFrozen::Foreign(error.to_string()))?;
        check(format.as_deref(), version, &genomd)?;
        Ok(serde_json::from_str(text)?)
    }

    /// Whether it is of a format that this program knows.
    ///
    /// # Errors
    /// It is another one, or of a later version.
    pub fn check(&self) -> Result<(), NotFrozen> {
        check(Some(&self.format), self.version, &self.genomd)
    }
}

fn check(format: Option<&str>, version: u32, genomd: &str) -> Result<(), NotFrozen> {
    if format != Some(FORMAT) {
        return Err(NotFrozen::Foreign(format!("it does not have \"format\": \"{FORMAT}\"")));
    }
    if version > VERSION {
        return Err(NotFrozen::Newer { version, genomd: genomd.to_owned() });
    }
    Ok(())
}

/// JSON with a line for each member of an object and for each list.
pub fn text_of(what: &impl Serialize) -> String {
    let mut out = Vec::new();
    let mut serializer = Serializer::with_formatter(&mut out, Lines { depth: 0, empty: true });
    // Neither can fail: keys are strings, and memory takes what is written.
    let written = what.serialize(&mut serializer);
    out.push(b'\n');
    written.ok().and_then(|()| String::from_utf8(out).ok()).unwrap_or_default()
}

struct Lines {
    depth: usize,
    /// Whether the innermost object has no member yet.
    empty: bool,
}

impl Lines {
    fn line<W: ?Sized + io::Write>(&self, to: &mut W) -> io::Result<()> {
        write!(to, "\n{:1$}", "", self.depth * 2)
    }
}

impl Formatter for Lines {
    fn begin_object<W: ?Sized + io::Write>(&mut self, to: &mut W) -> io::Result<()> {
        self.depth += 1;
        self.empty = true;
        to.write_all(b"{")
    }

    fn end_object<W: ?Sized + io::Write>(&mut self, to: &mut W) -> io::Result<()> {
        self.depth -= 1;
        if !std::mem::replace(&mut self.empty, false) {
            self.line(to)?;
        }
        to.write_all(b"}")
    }

    fn begin_object_key<W: ?Sized + io::Write>(
        &mut self,
        to: &mut W,
        first: bool,
    ) -> io::Result<()> {
        self.empty = false;
        if !first {
            to.write_all(b",")?;
        }
        self.line(to)
    }

    fn begin_object_value<W: ?Sized + io::Write>(&mut self, to: &mut W) -> io::Result<()> {
        to.write_all(b": ")
    }

    fn begin_array_value<W: ?Sized + io::Write>(
        &mut self,
        to: &mut W,
        first: bool,
    ) -> io::Result<()> {
        if first { Ok(()) } else { to.write_all(b", ") }
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;
    use crate::state::{FrozenActivity, FrozenPhase, FrozenState, FrozenValue, FrozenWait};

    fn sample() -> Frozen {
        let value = |value| FrozenValue { digest: "1a".to_owned(), value, left_out: Vec::new() };
        let activity = FrozenActivity {
            id: 4,
            service: "goto".to_owned(),
            phase: FrozenPhase::Run,
            pending: false,
            stopped_by: None,
            states: vec![FrozenState { state: "main".to_owned(), waits: FrozenWait::Pause }],
            inputs: value(json!({"goal": -0.0})),
            outputs: value(json!({})),
            locals: value(json!({"list": [1, [2, 3]]})),
        };
        let demo = FrozenComponent {
            component: "demo".to_owned(),
            ids: Some(value(json!({"reals": [0.1, null, "inf"]}))),
            activities: vec![activity],
            ..FrozenComponent::default()
        };
        Frozen {
            format: FORMAT.to_owned(),
            version: VERSION,
            genomd: "9.9".to_owned(),
            backend: "local".to_owned(),
            deployment: Deployment::default(),
            components: [("demo".to_owned(), demo)].into(),
        }
    }

    #[test]
    fn what_is_written_is_read_again_and_lists_take_one_line() {
        let text = sample().text();
        assert_eq!(Frozen::read(&text).unwrap(), sample());
        assert!(text.contains("\n          \"reals\": [0.1, null, \"inf\"]\n"), "{text}");
        assert!(text.contains("\"goal\": -0.0"), "{text}");
        assert!(text.contains("\"outputs\": {\n"), "{text}");
        assert!(text.contains("\"value\": {}\n"), "{text}");
    }

    #[test]
    fn other_files_later_versions_and_damage_are_told_apart() {
        let told = |text: &str| Frozen::read(text).unwrap_err().to_string();
        let text = sample().text();
        assert!(told("").starts_with("this is no file of `genomctl freeze`: EOF"), "{}", told(""));
        assert!(told("{\"version\": 1}").contains("\"format\": \"genomd freeze\""));
        let newer = text.replace("\"version\": 1", "\"version\": 7, \"more\": 1");
        assert!(told(&newer).contains("written by genomd 9.9 in version 7"), "{}", told(&newer));
        let newer = Frozen { version: 7, ..sample() };
        assert!(matches!(newer.check(), Err(NotFrozen::Newer { version: 7, .. })));
        let foreign = Frozen { format: String::new(), ..sample() };
        assert!(matches!(foreign.check(), Err(NotFrozen::Foreign(_))));
        let cut = &text[..text.len() / 2];
        assert!(
            told(cut).starts_with("this is no file of `genomctl freeze`: EOF"),
            "{}",
            told(cut)
        );
        let other = text.replace("\"phase\": \"run\"", "\"phase\": \"fly\"");
        assert!(told(&other).contains("unknown variant `fly`"), "{}", told(&other));
        assert!(told(&other).contains(" line "), "{}", told(&other));
        let more = text.replace("\"component\": \"demo\"", "\"component\": \"demo\", \"x\": 1");
        assert!(told(&more).contains("unknown field `x`"), "{}", told(&more));
        let large = format!("{text}{}", " ".repeat(MOST));
        assert!(told(&large).contains("more than the 33554432 that are read"));
    }
}
