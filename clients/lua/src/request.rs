//! What genomd asks the runner to load.

use std::path::PathBuf;

use serde::Deserialize;
use serde_json::Value;

use crate::layout::RawType;

/// A script, and the component that it is for.
#[derive(Debug, Deserialize)]
pub(crate) struct Request {
    pub(crate) path: PathBuf,
    pub(crate) text: String,
    /// How long the text may take to define its functions.
    pub(crate) seconds: f64,
    pub(crate) component: String,
    pub(crate) codels: Vec<Codel>,
    pub(crate) ports: Vec<Port>,
    pub(crate) remotes: Vec<Remote>,
    pub(crate) exceptions: Vec<Exception>,
    pub(crate) declared: Vec<Declared>,
    pub(crate) constants: Vec<Constant>,
    pub(crate) types: Vec<RawType>,
}

/// A codel that the script is to have.
#[derive(Clone, Debug, Deserialize)]
pub(crate) struct Codel {
    pub(crate) name: String,
    pub(crate) place: String,
    pub(crate) owner: String,
    /// `None` of one that returns nothing.
    pub(crate) yields: Option<Vec<String>>,
    pub(crate) parameters: Vec<Parameter>,
}

/// One of its parameters.
#[derive(Clone, Debug, Deserialize)]
pub(crate) struct Parameter {
    pub(crate) name: String,
    pub(crate) place: String,
    pub(crate) from: From,
    pub(crate) direction: Direction,
    #[serde(rename = "type")]
    pub(crate) ty: usize,
    /// Index of the port or the remote.
    pub(crate) rank: Option<usize>,
}

/// Where a parameter comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum From {
    Data,
    Port,
    Remote,
}

/// What the codel does with it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Direction {
    In,
    Out,
    InOut,
}

/// A port.
#[derive(Clone, Debug, Deserialize)]
pub(crate) struct Port {
    pub(crate) name: String,
    pub(crate) out: bool,
    pub(crate) multiple: bool,
    #[serde(rename = "type")]
    pub(crate) ty: usize,
}

/// A service of another component.
#[derive(Clone, Debug, Deserialize)]
pub(crate) struct Remote {
    pub(crate) name: String,
    pub(crate) parameters: Vec<Passed>,
}

/// A parameter of a service.
#[derive(Clone, Debug, Deserialize)]
pub(crate) struct Passed {
    pub(crate) name: String,
    pub(crate) direction: Direction,
    #[serde(rename = "type")]
    pub(crate) ty: usize,
}

/// An exception that codels may raise.
#[derive(Clone, Debug, Deserialize)]
pub(crate) struct Exception {
    pub(crate) event: String,
    pub(crate) name: Vec<String>,
    /// Of its detail.
    #[serde(rename = "type")]
    pub(crate) ty: Option<usize>,
}

/// A type that has a name in the description.
#[derive(Clone, Debug, Deserialize)]
pub(crate) struct Declared {
    pub(crate) name: Vec<String>,
    #[serde(rename = "type")]
    pub(crate) ty: usize,
}

/// A constant of the description.
#[derive(Clone, Debug, Deserialize)]
pub(crate) struct Constant {
    pub(crate) name: Vec<String>,
    pub(crate) value: Value,
}
