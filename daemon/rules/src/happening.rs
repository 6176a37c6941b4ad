//! What happens, by name.

use genom_description::model::{Owner, PortDirection, PortIx, ServiceIx, ServiceKind};
use genom_nearest::suggest;
use genom_protocol::supervision::{Atom, What};
use genom_runtime::Happening;

use crate::{Compiler, NoSuchRule};

/// What an atom is about.
pub(crate) enum Means {
    /// One of these happens.
    Happens(Vec<Happening>),
    /// A service has started and not ended.
    Runs(ServiceIx),
}

/// Something has the name, but this never happens to it.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Never {
    #[error("{name} is no activity, of which alone there is {what}({name})")]
    NoActivity { name: String, what: &'static str },
    #[error("{0} is an in port, which codels read and do not write")]
    InPort(String),
    #[error("genom_state is written by no codel, but each second and at changes")]
    StatePort,
}

impl Compiler<'_> {
    /// What an atom means. A name alone means what is natural for what it names.
    pub(crate) fn means(&self, atom: &Atom) -> Result<Means, NoSuchRule> {
        let name = atom.name.as_str();
        if let Some(what) = atom.what {
            return match self.one(what, name) {
                Ok(Some(means)) => Ok(means),
                Ok(None) => {
                    let (kind, known) = self.known(what);
                    let component = &self.model.name;
                    let help = suggest(name, known.iter().copied());
                    self.wrong(atom, format!("{component} has no {kind} `{name}`; {help}"))
                }
                Err(why) => self.wrong(atom, why.to_string()),
            };
        }
        let natural = [What::Codel, What::Start, What::Write, What::Fire, What::Cycle];
        let mut found = natural.iter().filter_map(|what| {
            let means = self.one(*what, name).transpose()?;
            Some((*what, means))
        });
        match (found.next(), found.next()) {
            (Some((_, means)), None) => means.or_else(|why| self.wrong(atom, why.to_string())),
            (Some((a, _)), Some((b, _))) => {
                let (a, b) = (a.name(), b.name());
                self.wrong(atom, format!("`{name}` is two things: say {a}({name}) or {b}({name})"))
            }
            (None, _) => {
                let component = &self.model.name;
                let known: Vec<&str> =
                    natural.iter().flat_map(|what| self.known(*what).1).collect();
                let help = suggest(name, known);
                let why = format!(
                    "{component} has no codel, service, out port, event or task `{name}`; {help}"
                );
                self.wrong(atom, why)
            }
        }
    }

    /// The same, of something that happens and does not last.
    pub(crate) fn happening(&self, atom: &Atom) -> Result<Vec<Happening>, NoSuchRule> {
        match self.means(atom)? {
            Means::Happens(all) => Ok(all),
            Means::Runs(_) => self.wrong(atom, format!("`{atom}` lasts: it is nothing that comes")),
        }
    }

    /// Whether an activity of a service can do this.
    pub(crate) fn of_activity(&self, what: Happening) -> bool {
        let activity = |ix: ServiceIx| self.model.services[ix].kind == ServiceKind::Activity;
        match what {
            Happening::Call(ix) | Happening::Return(ix) => {
                matches!(self.model.codels[ix].owner, Owner::Service(ix) if activity(ix))
            }
            Happening::Accept(ix)
            | Happening::Start(ix)
            | Happening::Stop(ix)
            | Happening::End(ix) => activity(ix),
            Happening::Write(_) => true,
            Happening::Fire(_) | Happening::Cycle(_) => false,
        }
    }

    /// What this is of a name; `None` if there is no such name, the reason if it can never be.
    fn one(&self, what: What, name: &str) -> Result<Option<Means>, Never> {
        let model = self.model;
        let service = || model.services.find(|service| service.name == name);
        let activity = || match service() {
            Some(ix) if model.services[ix].kind != ServiceKind::Activity => {
                Err(Never::NoActivity { name: name.to_owned(), what: what.name() })
            }
            found => Ok(found),
        };
        let happens = |one: Option<Happening>| one.map(|one| Means::Happens(vec![one]));
        Ok(match what {
            What::Codel | What::Return => {
                let named = model.codels.pairs().filter(|(_, codel)| codel.name == name);
                let all: Vec<Happening> = named
                    .map(|(ix, _)| match what {
                        What::Codel => Happening::Call(ix),
                        _ => Happening::Return(ix),
                    })
                    .collect();
                (!all.is_empty()).then_some(Means::Happens(all))
            }
            What::Accept => happens(activity()?.map(Happening::Accept)),
            What::Stop => happens(activity()?.map(Happening::Stop)),
            What::Start => happens(service().map(Happening::Start)),
            What::End => happens(service().map(Happening::End)),
            What::Run => service().map(Means::Runs),
            What::Write => happens(self.out_port(name)?.map(Happening::Write)),
            What::Fire => {
                let at = model.sinks.iter().position(|sink| sink.name == name);
                happens(at.map(Happening::Fire))
            }
            What::Cycle => {
                happens(model.tasks.find(|task| task.name == name).map(Happening::Cycle))
            }
        })
    }

    /// An out port that codels write.
    pub(crate) fn out_port(&self, name: &str) -> Result<Option<PortIx>, Never> {
        let found = self.model.ports.find(|port| port.name == name);
        match found.map(|ix| (ix, self.model.ports[ix].direction)) {
            Some((_, PortDirection::In)) => Err(Never::InPort(name.to_owned())),
            Some(_) if name == "genom_state" => Err(Never::StatePort),
            Some((ix, PortDirection::Out)) => Ok(Some(ix)),
            None => Ok(None),
        }
    }

    /// Names of which there is this, and what they name.
    fn known(&self, what: What) -> (&'static str, Vec<&str>) {
        let model = self.model;
        match what {
            What::Codel | What::Return => {
                let mut names: Vec<&str> =
                    model.codels.iter().map(|one| one.name.as_str()).collect();
                names.sort_unstable();
                names.dedup();
                ("codel", names)
            }
            What::Accept | What::Stop => {
                let all = model.services.iter();
                let all = all.filter(|service| service.kind == ServiceKind::Activity);
                ("activity", all.map(|one| one.name.as_str()).collect())
            }
            What::Start | What::End | What::Run => {
                ("service", model.services.iter().map(|one| one.name.as_str()).collect())
            }
            What::Write => {
                let out = |port: &&genom_description::model::Port| {
                    port.direction == PortDirection::Out && port.name != "genom_state"
                };
                let all = model.ports.iter().filter(out);
                ("out port", all.map(|one| one.name.as_str()).collect())
            }
            What::Fire => ("event", model.sinks.iter().map(|one| one.name.as_str()).collect()),
            What::Cycle => ("task", model.tasks.iter().map(|one| one.name.as_str()).collect()),
        }
    }

    fn wrong<T>(&self, atom: &Atom, why: String) -> Result<T, NoSuchRule> {
        let (at, rule, column) = (self.at, self.text.clone(), atom.column);
        Err(NoSuchRule::Name { at, rule, column, why })
    }
}
