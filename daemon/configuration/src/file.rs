//! The configuration file.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use genom_nearest::nearest_key;
use genom_protocol::{
    BackendNames, CallEntry, ClockKind, ConnectionEntry, Deployment, ExecutionKind, LoadRequest,
    Place,
};
use genom_registry::{BackendError, LIBRARY, Sections};
use genom_runtime::{ACTIVITY_LIMIT, STUCK_AFTER};
use serde::{Deserialize, Serialize};

use crate::blackbox::BlackBoxSection;
use crate::cells::CellsSection;
use crate::container::ContainerSection;
use crate::crashes::CrashesSection;
use crate::error::{ConfigError, UsageError, WhichDaemon, message_of};
use crate::foxglove::FoxgloveSection;
use crate::gateways::GatewaysSection;
use crate::levels;
use crate::lifecycle::LifecycleSection;
use crate::limits::CellLimits;
use crate::offers::Offers;
use crate::overrides;
use crate::plugins;
use crate::recordings::RecordingsSection;
use crate::reload::ReloadSection;
use crate::rpc::Rpc;
use crate::runners::{self, Runners};
use crate::spot;
use crate::web::WebSection;

/// A configuration file; `configs/default.toml` shows every key with its default.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct Config {
    /// Middleware of ports and services that name none.
    pub backend: String,
    /// Directories searched for components.
    pub path: Vec<PathBuf>,
    /// Directories searched for `#include` of descriptions.
    pub include: Vec<PathBuf>,
    /// Filter of the log, such as `info` or `info,genomd=debug`.
    pub log: String,
    /// Clock of the components.
    pub clock: ClockKind,
    /// Which threads execute the components.
    pub execution: ExecutionKind,
    /// Whether components are reloaded when their files change.
    pub watch: bool,
    /// Whether to lock all memory of the process in RAM (`mlockall`).
    pub lock_memory: bool,
    /// When to check whether codels wrote past their memory.
    pub check_memory: MemoryCheck,
    /// Seconds that the start codel of a task may take.
    pub start_timeout: u64,
    /// Seconds that a component may take to stop.
    pub stop_timeout: u64,
    /// Seconds after which a codel counts as stuck.
    pub stuck_after: u64,
    /// Activities that one task may run at once.
    pub max_activities: usize,
    /// The control plane.
    pub rpc: Rpc,
    /// The web console.
    pub web: WebSection,
    /// The live source for Foxglove.
    pub foxglove: FoxgloveSection,
    /// Components that ROS 2 loads and starts.
    pub lifecycle: LifecycleSection,
    /// The container into which ROS 2 loads components.
    pub container: ContainerSection,
    /// Processes of their own for components.
    pub cells: CellsSection,
    /// Programs that run codels in other languages, by the name of the language.
    pub runners: Runners,
    /// Middlewares in processes of their own.
    pub gateways: GatewaysSection,
    /// Reports of cells that crashed.
    pub crashes: CrashesSection,
    /// Trials of new libraries.
    pub reload: ReloadSection,
    /// What is kept of the last seconds.
    pub blackbox: BlackBoxSection,
    /// Recordings that the daemon makes itself.
    pub recordings: RecordingsSection,
    /// What single cells may use, by their names.
    pub cell: BTreeMap<String, CellLimits>,
    /// Which services are offered on which middlewares.
    pub services: Offers,
    /// What is sent to an OpenTelemetry collector.
    pub telemetry: Telemetry,
    /// Options of middlewares, by name of the middleware.
    pub backends: BTreeMap<String, toml::Table>,
    /// Components to load, in order, before those of the command line.
    pub component: Vec<LoadRequest>,
    /// Connections to make, and to make again whenever one side comes back.
    pub connection: Vec<ConnectionEntry>,
    /// Services to call, in order, once all connections are made.
    pub call: Vec<CallEntry>,
    /// Activities to start, in order, after the calls.
    pub activity: Vec<CallEntry>,
}

/// Section `[telemetry]`.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct Telemetry {
    /// URL `http://HOST:PORT` of an OpenTelemetry collector that receives a span for each service
    /// called.
    pub otlp: Option<String>,
}

/// When to check whether codels wrote past the memory they were given.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum MemoryCheck {
    /// Never.
    Off,
    /// When a codel yields a `pause::` state or the activity ends.
    #[default]
    Pauses,
    /// After each codel.
    EachCodel,
}

impl Default for Config {
    fn default() -> Self {
        Self {
            backend: "local".to_owned(),
            path: Vec::new(),
            include: Vec::new(),
            log: "info".to_owned(),
            clock: ClockKind::Monotonic,
            execution: ExecutionKind::Threads,
            watch: false,
            lock_memory: false,
            check_memory: MemoryCheck::Pauses,
            start_timeout: 60,
            stop_timeout: 10,
            stuck_after: STUCK_AFTER.as_secs(),
            max_activities: ACTIVITY_LIMIT,
            rpc: Rpc::default(),
            web: WebSection::default(),
            foxglove: FoxgloveSection::default(),
            lifecycle: LifecycleSection::default(),
            container: ContainerSection::default(),
            cells: CellsSection::default(),
            runners: Runners::new(),
            gateways: GatewaysSection::default(),
            crashes: CrashesSection::default(),
            reload: ReloadSection::default(),
            blackbox: BlackBoxSection::default(),
            recordings: RecordingsSection::default(),
            cell: BTreeMap::new(),
            services: Offers::default(),
            telemetry: Telemetry::default(),
            backends: BTreeMap::new(),
            component: Vec::new(),
            connection: Vec::new(),
            call: Vec::new(),
            activity: Vec::new(),
        }
    }
}

impl Config {
    /// Reads the file, if one is given, and applies the `KEY=VALUE` words of `--set` to it.
    pub fn read(path: Option<&Path>, words: &[String]) -> Result<Self, ConfigError> {
        let mut text = String::new();
        if let Some(path) = path {
            text = std::fs::read_to_string(path)
                .map_err(|source| ConfigError::Read { path: path.to_owned(), source })?;
        }
        let path = path.unwrap_or(Path::new(""));
        if words.is_empty() {
            return Self::of_text(path, &text);
        }
        Self::parse(path, &text)?;
        let mut config: Self = overrides::set(&text, words)?;
        config.anchor(path);
        Ok(config)
    }

    /// The same of a file that was read.
    ///
    /// # Errors
    /// It contains a mistake.
    pub fn of_text(path: &Path, text: &str) -> Result<Self, ConfigError> {
        let mut config = Self::parse(path, text)?;
        config.check(path, text)?;
        config.anchor(path);
        Ok(config)
    }

    /// Makes relative paths relative to the directory of the file.
    pub fn anchor(&mut self, path: &Path) {
        let base = path.parent().unwrap_or(Path::new(""));
        self.path.iter_mut().chain(&mut self.include).for_each(|dir| anchor(base, dir));
        let states = self.crashes.directory.iter_mut().chain(&mut self.blackbox.directory);
        let states = states.chain(&mut self.recordings.directory);
        states.for_each(|directory| anchor(base, directory));
        let commands = self.runners.values_mut().filter_map(|one| one.command.first_mut());
        for program in commands.filter(|program| program.contains('/')) {
            *program = base.join(&program).to_string_lossy().into_owned();
        }
        for section in self.backends.values_mut() {
            *section = plugins::anchored(section, path);
        }
        self.rpc.token_file.iter_mut().for_each(|file| anchor(base, file));
        if let Some(tls) = &mut self.rpc.tls {
            let files = [&mut tls.cert, &mut tls.key].into_iter().chain(&mut tls.client_ca);
            files.for_each(|file| anchor(base, file));
        }
        let limits = std::iter::once(&mut self.cells.limits).chain(self.cell.values_mut());
        limits.flat_map(CellLimits::paths).for_each(|path| anchor(base, path));
        for component in &mut self.component {
            // A bare name is searched on the component path, not in the directory of the
            // configuration.
            if component.library.components().count() > 1 || component.library.extension().is_some()
            {
                anchor(base, &mut component.library);
            }
            component.gen_file.iter_mut().for_each(|file| anchor(base, file));
        }
    }

    /// What the cell of this name may use.
    pub fn limits_of(&self, cell: &str) -> CellLimits {
        let all = &self.cells.limits;
        self.cell.get(cell).map_or_else(|| all.clone(), |own| own.over(all))
    }

    /// Checks what cells may use.
    ///
    /// # Errors
    /// A number is out of its range.
    pub fn check_limits(&self) -> Result<(), UsageError> {
        self.cells.limits.check("cells.limits")?;
        self.cell.iter().try_for_each(|(name, limits)| limits.check(&format!("cell.{name}")))
    }

    /// The command that runs scripts of a language, and the key that names its program; `None` of a
    /// language that has none.
    #[must_use]
    pub fn runner(&self, language: &str) -> Option<(Vec<String>, String)> {
        let command = runners::command(&self.runners, language, &self.cells.python)?;
        Some((command, runners::key(language)))
    }

    /// The section of a runner as an argument of `--set`, if there is one.
    #[must_use]
    pub fn runner_setting(&self, language: &str) -> Option<String> {
        let value = toml::Value::try_from(self.runners.get(language)?).ok()?;
        Some(format!("runners.{language}={value}"))
    }

    /// The languages that only this configuration knows, with the extensions of their scripts.
    #[must_use]
    pub fn languages(&self) -> Vec<(String, String)> {
        runners::added(&self.runners)
    }

    /// Checks the sections of runners.
    ///
    /// # Errors
    /// One has no command, or the extension of something else.
    pub fn check_runners(&self) -> Result<(), UsageError> {
        runners::check(&self.runners)
    }

    /// The configuration as TOML.
    pub fn text(&self) -> Result<String, toml::ser::Error> {
        toml::to_string(self)
    }

    /// The part of the file for the daemon of this name. If the file names daemons, the name has to
    /// be one of them.
    pub fn deployment(&self, daemon: Option<&str>) -> Result<Deployment, WhichDaemon> {
        let mut names: Vec<String> =
            self.component.iter().filter_map(|one| one.daemon.clone()).collect();
        names.sort();
        names.dedup();
        if !names.is_empty() && !names.iter().any(|name| Some(name.as_str()) == daemon) {
            return Err(WhichDaemon { given: daemon.map(str::to_owned), names });
        }
        let mine = |component: &&LoadRequest| {
            component.daemon.is_none() || component.daemon.as_deref() == daemon
        };
        let elsewhere: Vec<String> =
            self.component.iter().filter(|one| !mine(one)).map(LoadRequest::instance).collect();
        let here = |instance: &str| !elsewhere.iter().any(|other| other == instance);
        let calls = |entries: &[CallEntry]| {
            entries.iter().filter(|entry| here(&entry.component)).cloned().collect()
        };
        Ok(Deployment {
            component: self.component.iter().filter(mine).cloned().collect(),
            connection: {
                let all = self.connection.iter();
                all.filter(|connection| here(connection.reader())).cloned().collect()
            },
            call: calls(&self.call),
            activity: calls(&self.activity),
        })
    }

    /// The same for a daemon that runs with another file: the default middleware of this one, if it
    /// names one, becomes that of its components.
    pub fn deployment_elsewhere(&self, daemon: Option<&str>) -> Result<Deployment, WhichDaemon> {
        let mut deployment = self.deployment(daemon)?;
        if self.backend != Self::default().backend {
            let default = BackendNames::one(self.backend.as_str());
            for component in &mut deployment.component {
                component.backend.get_or_insert_with(|| default.clone());
            }
        }
        Ok(deployment)
    }

    /// Parses a text; `path` is used in error messages only.
    pub fn parse(path: &Path, text: &str) -> Result<Self, ConfigError> {
        toml::from_str(text).map_err(|error| mistake(path, text, &error))
    }

    /// The names of middlewares in it.
    fn backend_names(&self) -> Vec<String> {
        let of_components = self.component.iter().flat_map(|component| {
            let named = component.backend.iter().chain(component.ports.values());
            named.flat_map(BackendNames::names)
        });
        let of_connections = self.connection.iter().flat_map(|one| {
            let place: Option<Place> = one.outport.parse().ok();
            one.over.clone().into_iter().chain(place.and_then(|place| place.backend))
        });
        let all = std::iter::once(&self.backend).chain(self.backends.keys());
        all.chain(of_components).cloned().chain(of_connections).collect()
    }

    /// Finds the libraries of middlewares that it names, also the one whose path is `backend`. Only
    /// the start of a daemon does so: requests name what is known by then.
    ///
    /// # Errors
    /// A middleware is unknown, or its library is none.
    pub fn find_plugins(&mut self) -> Result<(), BackendError> {
        if self.backend.contains('/') {
            self.backend = genom_registry::of_path(Path::new(&self.backend))?.name.to_owned();
        }
        let used = self.backend_names();
        plugins::find(&used, &mut self.backends, &mut self.gateways, &mut self.services)
    }

    /// Where libraries of middlewares are.
    pub fn plugin_libraries(&self) -> impl Iterator<Item = PathBuf> {
        let libraries = self.backends.values().filter_map(|section| section.get(LIBRARY));
        libraries.filter_map(toml::Value::as_str).map(PathBuf::from)
    }

    /// Checks the log filter, the names of middlewares, their options, and that no in port is
    /// connected twice. Errors carry the line.
    pub fn check(&self, path: &Path, text: &str) -> Result<(), ConfigError> {
        if let Err(error) = levels::understood(&self.log) {
            let line = text.lines().position(|line| line.trim_start().starts_with("log"));
            let (path, line) = (path.to_owned(), line.map_or(1, |at| at + 1));
            let message = error.to_string();
            return Err(ConfigError::Mistake { path, line, message, nearest: None });
        }
        if let Some((line, inport)) = spot::connected_twice(text) {
            let message = format!(
                "a second connection into {inport}, which takes one: leave one of them out"
            );
            let path = path.to_owned();
            return Err(ConfigError::Mistake { path, line, message, nearest: None });
        }
        for name in self.backend_names() {
            if let Err(error) = genom_registry::has(&name, self.backends.get(&name)) {
                let line =
                    text.lines().position(|line| holds_word(line, &name)).map_or(1, |at| at + 1);
                let (path, message) = (path.to_owned(), error.to_string());
                return Err(ConfigError::Mistake { path, line, message, nearest: None });
            }
        }
        toml::from_str::<Sections>(text).map_err(|error| mistake(path, text, &error)).map(drop)
    }
}

fn mistake(path: &Path, text: &str, error: &toml::de::Error) -> ConfigError {
    let start = error.span().map_or(0, |span| span.start).min(text.len());
    let line = text.as_bytes()[..start].iter().filter(|byte| **byte == b'\n').count() + 1;
    let message = message_of(error);
    let nearest = nearest_key(&message);
    ConfigError::Mistake { path: path.to_owned(), line, message, nearest }
}

/// Whether a line holds this word outside a comment.
fn holds_word(line: &str, word: &str) -> bool {
    let code = line.split('#').next().unwrap_or_default();
    code.split(|c: char| !c.is_alphanumeric() && c != '_').any(|found| found == word)
}

fn anchor(base: &Path, path: &mut PathBuf) {
    if path.is_relative() {
        *path = base.join(&*path);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mistake(text: &str) -> String {
        Config::parse(Path::new("robot.toml"), text).unwrap_err().to_string()
    }

    #[test]
    fn an_unknown_key_names_file_line_and_the_nearest() {
        let told = mistake("log = \"info\"\n[rpc]\nmax_bdy = 3\n");
        assert!(told.starts_with("robot.toml:3: unknown field `max_bdy`"), "{told}");
        assert!(told.ends_with("did you mean `max_body`?"), "{told}");
        let told = mistake("[[component]]\nlibrary = \"demo\"\nbackedn = \"shm\"\n");
        assert!(told.contains(":3:") && told.ends_with("did you mean `backend`?"), "{told}");
    }

    #[test]
    fn a_wrong_type_names_file_and_line() {
        let told = mistake("\nbackend = 3\n");
        assert!(told.starts_with("robot.toml:2: invalid type: integer `3`"), "{told}");
    }

    #[test]
    fn options_of_middlewares_and_quality_of_ports_are_checked_where_they_stand() {
        let refused = |text: &str| {
            let path = Path::new("robot.toml");
            Config::parse(path, text).and_then(|config| config.check(path, text)).unwrap_err()
        };
        let told = refused("\n[backends.ros2]\ndomian = 7\n").to_string();
        assert!(told.starts_with("robot.toml:3: unknown field `domian`"), "{told}");
        assert!(told.ends_with("did you mean `domain`?"), "{told}");
        let entry = "[[component]]\nlibrary = \"demo\"\n[component.qos.ports.pose]\n";
        let told = refused(&format!("{entry}depth = 3\nreliable = \"best-effort\"\n")).to_string();
        assert!(told.starts_with("robot.toml:5: `reliable` is true or false"), "{told}");
        assert!(told.ends_with("did you mean `reliable = false`?"), "{told}");
    }

    #[test]
    fn every_example_can_be_used() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../configs");
        let mut read = 0;
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.extension().is_some_and(|extension| extension == "toml") {
                Config::read(Some(&path), &[]).unwrap();
                read += 1;
            }
        }
        assert!(read >= 3);
    }

    #[test]
    fn the_default_file_says_the_defaults() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../configs/default.toml");
        assert_eq!(Config::read(Some(&path), &[]).unwrap(), Config::default());
    }
}
