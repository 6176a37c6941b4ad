//! Heartbeats.

use std::time::Duration;

use genom_description::model::{CodelIx, Owner, ServiceIx, ServiceKind};
use genom_nearest::suggest;
use genom_protocol::Beats as Named;
use genom_runtime::{Beats, Rule};

use crate::{Compiler, NoSuchRule};

impl Compiler<'_> {
    pub(crate) fn beat(
        &self,
        of: &Named,
        (least, longest): (Duration, Duration),
        during: Option<&str>,
    ) -> Result<Rule, NoSuchRule> {
        let during = during.map(|name| self.activity(name)).transpose()?;
        let (of, own) = match of {
            Named::Port(name) => match self.out_port(name) {
                Ok(Some(port)) => (Beats::Port(port), None),
                Ok(None) => {
                    let ports = self.model.ports.iter().map(|port| port.name.as_str());
                    let help = suggest(name, ports);
                    let component = &self.model.name;
                    return self.idle(format!("{component} has no out port `{name}`; {help}"));
                }
                Err(why) => return self.idle(why.to_string()),
            },
            Named::Codel(name) => {
                let codels = self.codels(name)?;
                let own = self.common_activity(&codels);
                (Beats::Codels(codels), own)
            }
        };
        // The codel of an activity is called only while that runs.
        Ok(Rule::Beat { of, least, longest, during: during.or(own) })
    }

    /// The activity that all these codels belong to.
    fn common_activity(&self, codels: &[CodelIx]) -> Option<ServiceIx> {
        let owner = |ix: &CodelIx| match self.model.codels[*ix].owner {
            Owner::Service(service) => Some(service),
            Owner::Task(_) => None,
        };
        let first = owner(codels.first()?)?;
        let all = codels.iter().all(|ix| owner(ix) == Some(first));
        (all && self.model.services[first].kind == ServiceKind::Activity).then_some(first)
    }
}
