//! All settings of a run, made from the configuration file and the command line.

use std::path::PathBuf;
use std::sync::Arc;

use genom_configuration::{
    CellSettings, ClockKind, Config, Deployment, LoadRequest, MOST_ACTIVITIES, MemoryCheck,
    RpcSettings, UsageError, levels,
};
use genom_embedding::Program;
use genom_gateway::Reach;
use genom_registry::Gateways;
use genom_supervisor::settings::Settings as Supervised;

use crate::cli::Cli;
use genom_cells::{Lease, OwnCell, isolate_scripts};
use genom_systemd::Invitation;
use genom_telemetry::Collector;

/// All settings of a run.
#[derive(Debug)]
pub(crate) struct Settings {
    /// Path of the configuration file, for messages.
    pub(crate) file: Option<PathBuf>,
    /// The deployment to apply. Components of the command line come last.
    pub(crate) deployment: Deployment,
    /// Name of this daemon in files that describe several.
    pub(crate) name: Option<String>,
    /// Filter of the log.
    pub(crate) log: String,
    /// Whether to continue when the terminal is closed.
    pub(crate) keep: bool,
    /// Whether to lock all memory in RAM.
    pub(crate) lock_memory: bool,
    /// When to check whether codels wrote past their memory.
    pub(crate) check_memory: genom_host::MemoryCheck,
    /// The collector that receives spans, if any.
    pub(crate) collector: Option<Collector>,
    /// The control plane.
    pub(crate) rpc: RpcSettings,
    /// Settings that apply to all components.
    pub(crate) supervisor: Supervised,
    /// When cells are restarted, and given up.
    pub(crate) cells: CellSettings,
    /// The configuration that cells run by, too.
    pub(crate) config: Config,
    /// What makes this a cell of another daemon, when it is one.
    pub(crate) own_cell: Option<Arc<OwnCell>>,
    /// What the service manager that started this process left for it.
    pub(crate) invitation: Invitation,
    /// Of a cell: what its daemon lent it.
    pub(crate) lease: Option<Lease>,
    /// The program that it is a part of, if it is; of a cell, its daemon if that is.
    pub(crate) program: Option<Program>,
}

impl Settings {
    /// Combines the configuration with the command line, and checks the result.
    pub(crate) fn new(cli: Cli, config: Config) -> Result<Self, UsageError> {
        let mut config = cli.over(config);
        config.find_plugins()?;
        let rpc = RpcSettings::new(config.rpc.clone())?;
        let cells = CellSettings::new(&config.cells)?;
        config.check_limits()?;
        config.check_runners()?;
        // Before any file is looked at.
        genom_host::languages::add(config.languages());
        config.services.check()?;
        config.web.check(&config.rpc)?;
        config.foxglove.check(&config.rpc)?;
        config.gateways.check()?;
        config.blackbox.check()?;
        if !(1..=MOST_ACTIVITIES).contains(&config.max_activities) {
            return Err(UsageError::Activities(config.max_activities));
        }
        let restart = cli.restart.unwrap_or_default();
        let of = |library| LoadRequest { library, restart, ..LoadRequest::default() };
        let mut components: Vec<_> = cli.components.into_iter().map(of).collect();
        let found = components.len();
        for (option, given) in [("--name", cli.name.is_some()), ("--gen", cli.gen_file.is_some())] {
            if given && found != 1 {
                return Err(UsageError::OneComponent { option, found });
            }
        }
        if let Some(only) = components.first_mut().filter(|_| found == 1) {
            only.name = cli.name;
            only.gen_file = cli.gen_file;
        }
        for component in &mut components {
            let own = cli.isolated.then(|| component.instance());
            component.cell = cli.cell.clone().or(own);
        }
        levels::understood(&config.log).map_err(UsageError::Log)?;
        let deployment = config.deployment(cli.daemon.as_deref());
        let mut deployment = deployment.map_err(|why| {
            let file = cli.config.clone().unwrap_or_default();
            UsageError::Daemon { file, why }
        })?;
        deployment.component.extend(components);
        config.lifecycle.check(&deployment)?;
        config.container.check()?;
        // A cell runs what its daemon put there.
        if cli.run_cell.is_none() {
            isolate_scripts(&mut deployment.component, &config.path);
        }
        let mut supervised = Supervised::from(config.clone());
        if cli.run_cell.is_some() && config.clock == ClockKind::Ros {
            // Its daemon follows the topic, and steps it.
            config.clock = ClockKind::Virtual;
            supervised.clock = config.clock;
        }
        if !config.gateways.of.is_empty() {
            let daemon = config.gateways.daemon.as_ref().unwrap_or(&rpc.socket);
            let (of, reach) = (config.gateways.of.clone(), Reach::new(daemon));
            supervised.gateways = Some(Gateways { of, reach });
        }
        let collector = config.telemetry.otlp.as_deref().map(Collector::parse).transpose();
        let collector = collector.map_err(UsageError::Collector)?;
        Ok(Self {
            file: cli.config,
            collector,
            deployment,
            name: cli.daemon,
            log: config.log.clone(),
            keep: cli.keep,
            lock_memory: config.lock_memory,
            check_memory: host(config.check_memory),
            rpc,
            cells,
            own_cell: None,
            invitation: Invitation::default(),
            lease: None,
            program: None,
            supervisor: supervised,
            config,
        })
    }
}

/// Converts the setting to the type of the host.
fn host(check: MemoryCheck) -> genom_host::MemoryCheck {
    match check {
        MemoryCheck::Off => genom_host::MemoryCheck::Off,
        MemoryCheck::Pauses => genom_host::MemoryCheck::Pauses,
        MemoryCheck::EachCodel => genom_host::MemoryCheck::EachCodel,
    }
}

#[cfg(test)]
mod tests {
    use clap::Parser as _;

    use super::*;

    fn settings(arguments: &[&str]) -> Result<Settings, String> {
        let cli = Cli::try_parse_from(std::iter::once(&"genomd").chain(arguments)).unwrap();
        Settings::new(cli, Config::default()).map_err(|error| error.to_string())
    }

    #[test]
    fn the_clock_that_is_dumped_is_the_one_that_runs() {
        let cli = Cli::try_parse_from(["genomd", "--clock", "virtual"]).unwrap();
        let text = cli.over(Config::default()).text().unwrap();
        assert!(text.contains("clock = \"virtual\""), "{text}");
        assert_eq!(settings(&["--clock", "virtual"]).unwrap().supervisor.clock, ClockKind::Virtual);
    }

    #[test]
    fn a_name_goes_with_one_component() {
        let one = settings(&["--name", "arm", "demo.so"]).unwrap();
        assert_eq!(one.deployment.component[0].name.as_deref(), Some("arm"));
        let two = settings(&["--name", "arm", "a.so", "b.so"]).unwrap_err();
        assert_eq!(two, "--name goes with exactly one component, 2 are given");
    }
}
