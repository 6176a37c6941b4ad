//! Codels prepared for calls: address, call interface, paths to the arguments.

use genom_description::model::{
    Codel, CodelParameter, Component as Model, Indexed, Owner, PortIx, RemoteIx, ServiceIx, Source,
};
use genom_types::{CompiledPath, DataType, PathError, PathStep};

use super::checker::Checker;
use super::code::Placed;
use super::copies::steps;
use super::cxx::CxxTypes;
use super::error::LoadError;
use super::types::{Kept, ServiceTypes};
use super::way::Way;
use crate::contract::Difference;
use crate::cxx::{self, CxxPath, CxxPathError, CxxType, Function};
use crate::ffi::{Class, Interface};
use crate::library::{FoundFunction, Library};

/// A codel of a loaded library.
#[derive(Debug)]
pub(super) struct Prepared {
    pub(super) name: String,
    /// What it belongs to: `service NAME` or `task NAME`.
    pub(super) owner: String,
    pub(super) interface: Interface,
    pub(super) arguments: Vec<Argument>,
    /// Whether the context is the last argument: not in C++.
    pub(super) context: bool,
}

/// An argument other than the context.
#[derive(Debug)]
pub(super) struct Argument {
    pub(super) name: String,
    pub(super) class: Class,
    pub(super) from: From,
}

/// The source of an argument.
#[derive(Debug)]
pub(super) enum From {
    Ids(Way),
    Input(Way),
    Output(Way),
    Local(Way),
    /// The handle of a port, by index.
    Port(PortIx),
    /// The handle of a remote, by index.
    Remote(RemoteIx),
}

/// Why an argument has no address.
#[derive(Debug, thiserror::Error)]
pub(super) enum ArgumentError {
    #[error("the component has no ids")]
    NoIds,
    #[error("a task has no parameters and no local variables")]
    NoService,
    #[error("the service has no such parameter")]
    NoParameter,
    #[error("the component has no such port")]
    NoPort,
    #[error("the component has no such remote")]
    NoRemote,
    #[error("{0}")]
    Path(#[from] PathError),
    #[error("{0}")]
    CxxPath(#[from] CxxPathError),
}

/// Data for preparing the codels of one component.
pub(super) struct Workshop<'a> {
    pub(super) model: &'a Model,
    pub(super) library: &'a Library,
    pub(super) ids: Option<&'a DataType>,
    pub(super) services: &'a Indexed<ServiceIx, Option<ServiceTypes>>,
    /// For codels in C++.
    pub(super) cxx: Option<&'a CxxTypes>,
}

impl Workshop<'_> {
    /// Prepares a codel; `None` for one that the runtime supplies, and, with an error recorded, for
    /// one that is wrong.
    pub(super) fn prepare(
        &self,
        checker: &mut Checker<'_>,
        codel: &Codel,
    ) -> Option<(Prepared, Placed)> {
        if let Owner::Service(service) = codel.owner
            && self.model.services.get(service).is_none_or(|service| service.standard)
        {
            return None;
        }
        let function = match self.cxx {
            Some(_) => self.function_in_cxx(checker, codel),
            None => self.function(checker, codel),
        };
        let mut arguments = Vec::new();
        let mut wrong = false;
        for parameter in &codel.parameters {
            match self.argument(codel, parameter, checker) {
                Ok(argument) => arguments.push(argument),
                Err(why) => {
                    wrong = true;
                    checker.errors.push(LoadError::Argument {
                        codel: codel.name.clone(),
                        parameter: parameter.name.clone(),
                        place: (checker.locate)(parameter.span),
                        why: why.to_string(),
                    });
                }
            }
        }
        let at = function.filter(|_| !wrong)?;
        let context = self.cxx.is_none();
        let classes = arguments.iter().map(|argument| argument.class);
        let classes: Vec<Class> = classes.chain(context.then_some(Class::Address)).collect();
        let Some(interface) = Interface::new(&classes) else {
            checker.errors.push(LoadError::NoClosures);
            return None;
        };
        let name = codel.name.clone();
        let words = format!("codel `{name}` of {}", self.library.path().display());
        let owner = match codel.owner {
            Owner::Service(rank) => format!("service {}", self.model.services.get(rank)?.name),
            Owner::Task(rank) => format!("task {}", self.model.tasks.get(rank)?.name),
        };
        Some((Prepared { name, owner, interface, arguments, context }, Placed { at, words }))
    }

    /// Address of the C function; records an error if there is none.
    fn function(&self, checker: &mut Checker<'_>, codel: &Codel) -> Option<usize> {
        let found = self.library.function(&codel.name);
        if let FoundFunction::At(at) = found {
            return Some(at);
        }
        checker.errors.push(LoadError::MissingCodel {
            codel: codel.name.clone(),
            place: (checker.locate)(codel.span),
            hint: match &found {
                FoundFunction::InSystem(system) => {
                    format!("; {system} has a function of that name, which is no codel")
                }
                _ => self.hint(&codel.name),
            },
        });
        None
    }

    /// Address of the C++ function with the codel's name and parameters; records an error if there
    /// is none.
    fn function_in_cxx(&self, checker: &mut Checker<'_>, codel: &Codel) -> Option<usize> {
        let types = &checker.specification.types;
        let place = (checker.locate)(codel.span);
        match cxx::find(self.library, self.model, types, codel) {
            Function::Found(symbol) => return self.library.symbol(&symbol),
            Function::Others(others) => {
                checker.errors.push(LoadError::Contract(Difference {
                    subject: format!("codel `{}`", codel.name),
                    place,
                    why: "the C++ function takes other parameters".to_owned(),
                    description: genom_description_tools::prototype(types, self.model, codel),
                    library: others.join("; "),
                }));
            }
            Function::Missing => {
                let hint = match self.library.own_symbol(&codel.name) {
                    Some(_) => {
                        "; it has a function of that name with C linkage: in a lang \"c++\" \
                         component codels have none (no extern \"C\"), or say lang \"c\""
                    }
                    None => "; a lang \"c++\" codel is a C++ function that the library exports",
                };
                let (codel, hint) = (codel.name.clone(), hint.to_owned());
                checker.errors.push(LoadError::MissingCodel { codel, place, hint });
            }
        }
        None
    }

    fn argument(
        &self,
        codel: &Codel,
        parameter: &CodelParameter,
        checker: &Checker<'_>,
    ) -> Result<Argument, ArgumentError> {
        let member = |root: (&DataType, Option<&CxxType>), rank: usize, path: &[_]| {
            let mut steps = steps(path);
            steps.insert(0, PathStep::Member(rank));
            way(root, &steps)
        };
        let service = || match codel.owner {
            Owner::Service(service) => self.services.get(service).and_then(Option::as_ref),
            Owner::Task(_) => None,
        };
        let in_cxx = || match codel.owner {
            Owner::Service(service) => self.cxx?.services.get(service)?.as_ref(),
            Owner::Task(_) => None,
        };
        let from = match &parameter.source {
            Source::Ids { path } => {
                let ids = self.ids.ok_or(ArgumentError::NoIds)?;
                let in_cxx = self.cxx.and_then(|cxx| cxx.ids.as_ref());
                From::Ids(way((ids, in_cxx), &steps(path))?)
            }
            Source::Parameter { index, path } => {
                let types = service().ok_or(ArgumentError::NoService)?;
                match *types.kept.get(*index).ok_or(ArgumentError::NoParameter)? {
                    Kept::Input(rank) => {
                        let root = (&types.input, in_cxx().map(|cxx| &cxx.input));
                        From::Input(member(root, rank, path)?)
                    }
                    Kept::Output(rank) => {
                        let root = (&types.output, in_cxx().map(|cxx| &cxx.output));
                        From::Output(member(root, rank, path)?)
                    }
                }
            }
            Source::Local { index, path } => {
                let types = service().ok_or(ArgumentError::NoService)?;
                let root = (&types.local, in_cxx().map(|cxx| &cxx.local));
                From::Local(member(root, *index, path)?)
            }
            Source::Port(port) => {
                self.model.ports.get(*port).ok_or(ArgumentError::NoPort)?;
                From::Port(*port)
            }
            Source::Remote(remote) => {
                self.model.remotes.get(*remote).ok_or(ArgumentError::NoRemote)?;
                From::Remote(*remote)
            }
        };
        let class = match from {
            // genom3.md 5.5: ports and remotes are passed by address, whatever the direction.
            From::Port(_) | From::Remote(_) => Class::Address,
            _ => {
                let kind = checker.specification.types.resolved(parameter.ty);
                match self.cxx {
                    Some(_) => Class::of_cxx(kind, parameter.direction),
                    None => Class::of(kind, parameter.direction),
                }
            }
        };
        Ok(Argument { name: parameter.name.clone(), class, from })
    }

    /// The usual reason is a C++ function of that name without C linkage.
    fn hint(&self, codel: &str) -> String {
        match self.library.mangled(codel).first() {
            Some(mangled) => format!(
                "; it has the C++ function `{mangled}`: declare it extern \"C\", or include the \
                 component's header"
            ),
            None => String::new(),
        }
    }
}

/// The path from a root, in C layout, or in C++ layout for codels in C++.
fn way(root: (&DataType, Option<&CxxType>), steps: &[PathStep]) -> Result<Way, ArgumentError> {
    let in_c = CompiledPath::new(root.0, steps)?;
    match root.1 {
        Some(root) => Ok(Way::Cxx(CxxPath::new(root, steps)?)),
        None => Ok(Way::C(in_c)),
    }
}
