//! Errors of [`genom_middleware`] as codes with a text, and back.

use std::time::Duration;

use genom_middleware::{Address, AnnounceError, AskError, CallError, OpenError};

/// What functions of the table return.
#[repr(transparent)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Code(pub i32);

#[allow(missing_docs, reason = "the header documents them")]
impl Code {
    pub const OK: Self = Self(0);
    pub const FAILED: Self = Self(1);
    pub const TYPE_MISMATCH: Self = Self(2);
    pub const TAKEN: Self = Self(3);
    pub const UNSUPPORTED: Self = Self(4);
    pub const NOBODY: Self = Self(5);
    pub const TIMEOUT: Self = Self(6);
    pub const GONE: Self = Self(7);
    pub const BAD_DATA: Self = Self(8);
}

/// A code other than [`Code::OK`], with what goes with it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Failure {
    /// What went wrong.
    pub code: Code,
    /// Its text.
    pub text: String,
    /// Nanoseconds of a time-out.
    pub value: u64,
}

/// What an error says that does not cross, because both sides know it.
#[derive(Clone, Debug)]
pub struct Sides {
    /// Name of the middleware.
    pub backend: String,
    /// What was opened or called.
    pub address: Address,
    /// Name of the type of this side.
    pub name: String,
    /// The type of this side, spelled in full.
    pub ours: String,
}

impl Failure {
    /// A failure with a text.
    pub fn new(code: Code, text: impl Into<String>) -> Self {
        Self { code, text: text.into(), value: 0 }
    }

    /// The error of opening an end.
    #[must_use]
    pub fn opening(self, sides: &Sides) -> OpenError {
        let Sides { backend, address, name, ours } = sides.clone();
        match self.code {
            Code::TYPE_MISMATCH => OpenError::TypeMismatch { address, ours, theirs: self.text },
            Code::TAKEN => OpenError::Taken { address },
            Code::UNSUPPORTED => OpenError::Unsupported { backend, ty: name, why: self.text },
            _ => OpenError::Failed { backend, address, why: self.why() },
        }
    }

    /// The error of a call.
    #[must_use]
    pub fn calling(self, sides: &Sides) -> CallError {
        let Sides { backend, address, ours, .. } = sides.clone();
        match self.code {
            Code::NOBODY => CallError::Nobody { address },
            Code::TYPE_MISMATCH => CallError::TypeMismatch { address, ours, theirs: self.text },
            Code::TIMEOUT => CallError::Timeout(Duration::from_nanos(self.value)),
            Code::GONE => CallError::Gone,
            Code::BAD_DATA => CallError::Serialization(self.text),
            _ => CallError::Failed { backend, why: self.why() },
        }
    }

    /// The error of making a daemon reachable under a name.
    #[must_use]
    pub fn announcing(self, backend: &str, name: &str) -> AnnounceError {
        let (backend, name) = (backend.to_owned(), name.to_owned());
        match self.code {
            Code::TAKEN => AnnounceError::Taken { name, backend },
            _ => AnnounceError::Failed { name, backend, why: self.why() },
        }
    }

    /// The error of a request to the daemon of a name.
    #[must_use]
    pub fn asking(self, backend: &str, name: &str) -> AskError {
        let (backend, name) = (backend.to_owned(), name.to_owned());
        let why = match self.code {
            Code::NOBODY => return AskError::Unknown { name, backend },
            Code::TIMEOUT => format!("nothing within {:?}", Duration::from_nanos(self.value)),
            Code::GONE => "it went away".to_owned(),
            _ => self.why(),
        };
        AskError::Silent { name, backend, why }
    }

    /// Its text, also where the other side gave none.
    #[must_use]
    pub fn why(self) -> String {
        match self.text.is_empty() {
            true => format!("the plugin gave no reason (code {})", self.code.0),
            false => self.text,
        }
    }
}

impl From<OpenError> for Failure {
    fn from(error: OpenError) -> Self {
        match error {
            OpenError::TypeMismatch { theirs, .. } => Self::new(Code::TYPE_MISMATCH, theirs),
            OpenError::Taken { .. } => Self::new(Code::TAKEN, ""),
            OpenError::Unsupported { why, .. } => Self::new(Code::UNSUPPORTED, why),
            OpenError::Failed { why, .. } => Self::new(Code::FAILED, why),
            other => Self::new(Code::FAILED, other.to_string()),
        }
    }
}

impl From<CallError> for Failure {
    fn from(error: CallError) -> Self {
        match error {
            CallError::Nobody { .. } => Self::new(Code::NOBODY, ""),
            CallError::TypeMismatch { theirs, .. } => Self::new(Code::TYPE_MISMATCH, theirs),
            CallError::Timeout(after) => {
                let value = u64::try_from(after.as_nanos()).unwrap_or(u64::MAX);
                Self { value, ..Self::new(Code::TIMEOUT, "") }
            }
            CallError::Gone => Self::new(Code::GONE, ""),
            CallError::Serialization(why) => Self::new(Code::BAD_DATA, why),
            CallError::Failed { why, .. } => Self::new(Code::FAILED, why),
            other => Self::new(Code::FAILED, other.to_string()),
        }
    }
}

impl From<AnnounceError> for Failure {
    fn from(error: AnnounceError) -> Self {
        match error {
            AnnounceError::Taken { .. } => Self::new(Code::TAKEN, ""),
            AnnounceError::Failed { why, .. } => Self::new(Code::FAILED, why),
            other => Self::new(Code::FAILED, other.to_string()),
        }
    }
}

impl From<AskError> for Failure {
    fn from(error: AskError) -> Self {
        match error {
            AskError::Unknown { .. } => Self::new(Code::NOBODY, ""),
            AskError::Silent { why, .. } => Self::new(Code::FAILED, why),
            other => Self::new(Code::FAILED, other.to_string()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sides() -> Sides {
        let address = Address::new("demo", "goto");
        let (backend, name, ours) = ("mine".into(), "::demo::in".into(), "ours".into());
        Sides { backend, address, name, ours }
    }

    #[test]
    fn errors_are_the_same_on_the_other_side() {
        let Sides { backend, address, name, ours } = sides();
        let opening = [
            OpenError::TypeMismatch {
                address: address.clone(),
                ours: ours.clone(),
                theirs: "b".into(),
            },
            OpenError::Taken { address: address.clone() },
            OpenError::Unsupported { backend: backend.clone(), ty: name, why: "c".into() },
            OpenError::Failed {
                backend: backend.clone(),
                address: address.clone(),
                why: "d".into(),
            },
        ];
        for error in opening {
            assert_eq!(Failure::from(error.clone()).opening(&sides()), error);
        }
        let calling = [
            CallError::Nobody { address: address.clone() },
            CallError::TypeMismatch { address, ours, theirs: "e".into() },
            CallError::Timeout(Duration::from_millis(5)),
            CallError::Gone,
            CallError::Serialization("f".into()),
            CallError::Failed { backend, why: "g".into() },
        ];
        for error in calling {
            assert_eq!(Failure::from(error.clone()).calling(&sides()), error);
        }
    }

    #[test]
    fn errors_of_daemons_are_the_same_on_the_other_side() {
        let (name, backend) = (|| "robot".to_owned(), || "mine".to_owned());
        let announcing = [
            AnnounceError::Taken { name: name(), backend: backend() },
            AnnounceError::Failed { name: name(), backend: backend(), why: "a".into() },
        ];
        for error in announcing {
            assert_eq!(Failure::from(error.clone()).announcing("mine", "robot"), error);
        }
        let asking = [
            AskError::Unknown { name: name(), backend: backend() },
            AskError::Silent { name: name(), backend: backend(), why: "b".into() },
        ];
        for error in asking {
            assert_eq!(Failure::from(error.clone()).asking("mine", "robot"), error);
        }
        let late = Failure { value: 5_000_000, ..Failure::new(Code::TIMEOUT, "") };
        let told = late.asking("mine", "robot").to_string();
        assert_eq!(told, "daemon robot on mine does not answer: nothing within 5ms");
        let told = Failure::new(Code::GONE, "").asking("mine", "robot").to_string();
        assert!(told.ends_with("it went away"), "{told}");
    }

    #[test]
    fn a_code_that_is_not_known_here_is_a_failure() {
        let told = Failure::new(Code(77), "").opening(&sides()).to_string();
        assert_eq!(told, "mine failed on demo/goto: the plugin gave no reason (code 77)");
        assert!(matches!(Failure::new(Code(-1), "x").calling(&sides()), CallError::Failed { .. }));
    }
}
