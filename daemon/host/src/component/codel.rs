//! Codels ready to be called: address, call interface, ways to the arguments.

use genom_description::model::{Codel, CodelParameter, Component as Model, Owner, Source};
use genom_types::{CompiledPath, DataType, PathStep};

use super::error::LoadError;
use super::types::{Checker, Kept, ServiceTypes, steps};
use crate::ffi::{Class, Interface};
use crate::library::Library;

/// A codel of a loaded library.
#[derive(Debug)]
pub(super) struct Prepared {
    pub(super) name: String,
    /// Address of the C function.
    pub(super) function: usize,
    pub(super) interface: Interface,
    pub(super) arguments: Vec<Argument>,
}

/// An argument, without the context that ends every argument list.
#[derive(Debug)]
pub(super) struct Argument {
    pub(super) name: String,
    pub(super) class: Class,
    pub(super) from: From,
}

/// What an argument leads to.
#[derive(Debug)]
pub(super) enum From {
    Ids(CompiledPath),
    Input(CompiledPath),
    Output(CompiledPath),
    Local(CompiledPath),
    /// The handle of a port, by rank.
    Port(usize),
    /// The handle of a remote, by rank.
    Remote(usize),
}

/// What codels of one component are prepared from.
pub(super) struct Workshop<'a> {
    pub(super) model: &'a Model,
    pub(super) library: &'a Library,
    pub(super) ids: Option<&'a DataType>,
    pub(super) services: &'a [Option<ServiceTypes>],
}

impl Workshop<'_> {
    /// The codel, ready; `None` for those the runtime supplies, and with the reason noted for
    /// those that are wrong.
    pub(super) fn prepare(&self, checker: &mut Checker<'_>, codel: &Codel) -> Option<Prepared> {
        if let Owner::Service(service) = codel.owner
            && self.model.services.get(service).is_none_or(|service| service.standard)
        {
            return None;
        }
        let found = self.library.function(&codel.name);
        if !matches!(found, Ok(Some(_))) {
            checker.errors.push(LoadError::MissingCodel {
                codel: codel.name.clone(),
                place: (checker.locate)(codel.span),
                hint: match &found {
                    Err(system) => {
                        format!("; {system} has a function of that name, which is no codel")
                    }
                    Ok(_) => self.hint(&codel.name),
                },
            });
        }
        let function = found.ok().flatten();
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
                        why,
                    });
                }
            }
        }
        let function = function.filter(|_| !wrong)?;
        let classes = arguments.iter().map(|argument| argument.class);
        let classes: Vec<Class> = classes.chain([Class::Address]).collect();
        let Some(interface) = Interface::new(&classes) else {
            checker.errors.push(LoadError::NoClosures);
            return None;
        };
        Some(Prepared { name: codel.name.clone(), function, interface, arguments })
    }

    fn argument(
        &self,
        codel: &Codel,
        parameter: &CodelParameter,
        checker: &Checker<'_>,
    ) -> Result<Argument, String> {
        let member = |root: &DataType, rank: usize, path: &[_]| {
            let mut way = vec![PathStep::Member(rank)];
            way.extend(steps(path));
            CompiledPath::new(root, &way).map_err(|error| error.to_string())
        };
        let service = || match codel.owner {
            Owner::Service(service) => self.services.get(service).and_then(Option::as_ref),
            Owner::Task(_) => None,
        };
        let no_service = || "a task has no parameters and no local variables".to_owned();
        let from = match &parameter.source {
            Source::Ids { path } => {
                let ids = self.ids.ok_or("the component has no ids")?;
                let way = CompiledPath::new(ids, &steps(path));
                From::Ids(way.map_err(|error| error.to_string())?)
            }
            Source::Parameter { index, path } => {
                let types = service().ok_or_else(no_service)?;
                match *types.kept.get(*index).ok_or("the service has no such parameter")? {
                    Kept::Input(rank) => From::Input(member(&types.input, rank, path)?),
                    Kept::Output(rank) => From::Output(member(&types.output, rank, path)?),
                }
            }
            Source::Local { index, path } => {
                let types = service().ok_or_else(no_service)?;
                From::Local(member(&types.local, *index, path)?)
            }
            Source::Port(port) => {
                self.model.ports.get(*port).ok_or("the component has no such port")?;
                From::Port(*port)
            }
            Source::Remote(remote) => {
                self.model.remotes.get(*remote).ok_or("the component has no such remote")?;
                From::Remote(*remote)
            }
        };
        let class = match from {
            // genom3.md 5.5: ports and remotes by address, whatever the direction.
            From::Port(_) | From::Remote(_) => Class::Address,
            _ => Class::of(checker.specification.types.resolved(parameter.ty), parameter.direction),
        };
        Ok(Argument { name: parameter.name.clone(), class, from })
    }

    /// A C++ function of that name, compiled without C linkage, is the usual reason.
    fn hint(&self, codel: &str) -> String {
        match self.library.mangled(codel) {
            Some(mangled) => format!(
                "; it has the C++ function `{mangled}`: declare it extern \"C\", or include the \
                 component's header"
            ),
            None => String::new(),
        }
    }
}
