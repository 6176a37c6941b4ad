//! The command line of genomd; `settings::Settings` is made from it and the configuration.

use std::net::SocketAddr;
use std::path::PathBuf;

use clap::{Parser, ValueHint};
use genom_configuration::{ClockKind, Config, ExecutionKind};
use genom_protocol::RestartPolicy;

/// Runs GenoM3 components: libraries of codels with their descriptions, on a middleware chosen
/// here.
///
/// Exit status: 0 stopped on request; 1 a component was refused; 2 wrong usage or configuration; 3
/// the daemon's own socket or middleware could not be opened; 4 stopped on request, and a codel
/// that does not return was left behind.
///
/// SIGINT, SIGTERM and the end of its terminal stop the daemon: activities are interrupted, and
/// `stop` codels run. Another signal, a second or more after the first, ends it at once. A SIGHUP
/// that somebody sends stops it, too; with a token file, that file is read again instead.
#[derive(Debug, Default, Parser)]
#[command(name = "genomd", max_term_width = 100, disable_version_flag = true)]
pub(crate) struct Cli {
    /// Components to run: libraries (demo.so), descriptions (demo.gen), or names on the
    /// component path (demo).
    #[arg(value_name = "LIB", value_hint = ValueHint::FilePath)]
    pub(crate) components: Vec<PathBuf>,
    /// Default middleware of ports and services: its name, or the path of a library with one
    /// [default: local].
    #[arg(long, short)]
    pub(crate) backend: Option<String>,
    /// Configuration file (TOML); configs/default.toml describes every key.
    #[arg(long, short, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) config: Option<PathBuf>,
    /// Set a key of the configuration, for instance rpc.max_streams=8; may be repeated, takes
    /// precedence over the file.
    #[arg(long, value_name = "KEY=VALUE")]
    pub(crate) set: Vec<String>,
    /// Print the configuration that results, with every default, and exit.
    #[arg(long)]
    pub(crate) dump_config: bool,
    /// Which daemon this is, if the configuration describes several: it runs the components with
    /// this `daemon`, and those without `daemon`.
    #[arg(long, value_name = "NAME")]
    pub(crate) daemon: Option<String>,
    /// Instance name, if a single component is given [default: the component's name].
    #[arg(long)]
    pub(crate) name: Option<String>,
    /// Description, if a single component is given and its description is neither in the library
    /// nor beside it.
    #[arg(long = "gen", value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) gen_file: Option<PathBuf>,
    /// Run the components given here in this cell: a process that they share, so that a fault of
    /// theirs takes nothing else down.
    #[arg(long, value_name = "CELL")]
    pub(crate) cell: Option<String>,
    /// Run each component given here in a cell of its own, of its name.
    #[arg(long, conflicts_with = "cell")]
    pub(crate) isolated: bool,
    /// Whether they are brought up again when the process of their cell has ended
    /// [default: on-failure].
    #[arg(long, value_name = "POLICY")]
    pub(crate) restart: Option<RestartPolicy>,
    /// Run as this cell of the daemon that wrote the configuration.
    #[arg(long, value_name = "CELL", hide = true, requires = "config")]
    pub(crate) run_cell: Option<String>,
    /// Run as a part of the program that has the other end of the standard input, a socket.
    #[arg(long, hide = true, conflicts_with_all = ["check", "dump_sources", "run_cell"])]
    pub(crate) embedded: bool,
    /// Directory to search for components; may be repeated, takes precedence over GENOM_PATH.
    #[arg(long, value_name = "DIRECTORY", value_hint = ValueHint::DirPath)]
    pub(crate) path: Vec<PathBuf>,
    /// Directories to search for components, separated by colons.
    #[arg(long, hide = true, env = "GENOM_PATH", value_delimiter = ':')]
    pub(crate) genom_path: Vec<PathBuf>,
    /// Directory to search for #include of descriptions; may be repeated.
    #[arg(long, short = 'I', value_name = "DIRECTORY")]
    pub(crate) include: Vec<PathBuf>,
    /// Socket to listen on [default: $XDG_RUNTIME_DIR/genomd.sock, else
    /// /tmp/genomd-UID/genomd.sock].
    #[arg(long, value_name = "PATH", env = "GENOMD_SOCKET")]
    pub(crate) socket: Option<PathBuf>,
    /// Also listen on this address, for clients with a token or a certificate. TLS is required if
    /// other machines can reach it: section [rpc.tls] of the configuration.
    #[arg(long, value_name = "ADDRESS:PORT")]
    pub(crate) listen: Option<SocketAddr>,
    /// Serve the web console at this address, by default at a free port of this machine; `genomctl
    /// web` opens it.
    #[arg(
        long, value_name = "ADDRESS:PORT", num_args = 0..=1, require_equals = true,
        default_missing_value = "127.0.0.1:0"
    )]
    pub(crate) web: Option<SocketAddr>,
    /// Serve Foxglove at this address, by default 127.0.0.1:8765, where it looks for a live source by
    /// itself.
    #[arg(
        long, value_name = "ADDRESS:PORT", num_args = 0..=1, require_equals = true,
        default_missing_value = "127.0.0.1:8765"
    )]
    pub(crate) foxglove: Option<SocketAddr>,
    /// File of tokens of clients at that address, with their rights; see configs/default.toml.
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) token_file: Option<PathBuf>,
    /// Clock of the components: that of the machine, one that `genomctl step` advances, or the one
    /// that a simulator publishes on /clock of ROS 2 [default: monotonic].
    #[arg(long, value_name = "CLOCK")]
    pub(crate) clock: Option<ClockKind>,
    /// Which threads execute the components: one for each task, or a single one for all of a
    /// process, in the order of deadlines [default: threads].
    #[arg(long, value_name = "HOW")]
    pub(crate) execution: Option<ExecutionKind>,
    /// Reload a component whenever its library or description changes on disk: save, make, running.
    #[arg(long)]
    pub(crate) watch: bool,
    /// What to log on standard error: error, warn, info, debug, trace, or a filter such as
    /// info,genomd=debug [default: info].
    #[arg(long, value_name = "FILTER")]
    pub(crate) log: Option<String>,
    /// Continue when the terminal is closed that the daemon was started on, as with `nohup`.
    #[arg(long)]
    pub(crate) keep: bool,
    /// Only check: find, read, open and compare each component without starting it, and report what
    /// is wrong. Opens no socket and no middleware.
    #[arg(long)]
    pub(crate) check: bool,
    /// Print what each component is made of, one line of JSON each, without opening its library: the
    /// texts of its description, and how its tasks are executed.
    #[arg(long, conflicts_with = "check")]
    pub(crate) dump_sources: bool,
    /// Print the completion script of genomd for a shell; in ~/.bashrc: `source <(genomd
    /// --completion bash)`.
    #[arg(long, value_name = "SHELL")]
    pub(crate) completion: Option<clap_complete::Shell>,
    /// Write the manual page of genomd into a directory, such as ~/.local/share/man/man1.
    #[arg(long, value_name = "DIRECTORY", value_hint = ValueHint::DirPath)]
    pub(crate) man: Option<PathBuf>,
    /// Print the version, and the middlewares this daemon was built with and their versions.
    #[arg(long, short = 'V')]
    pub(crate) version: bool,
}

impl Cli {
    /// Applies the options of the command line to a configuration.
    pub(crate) fn over(&self, mut config: Config) -> Config {
        config.backend = self.backend.clone().unwrap_or(config.backend);
        config.log = self.log.clone().unwrap_or(config.log);
        config.clock = self.clock.unwrap_or(config.clock);
        config.watch |= self.watch;
        config.execution = self.execution.unwrap_or(config.execution);
        config.path = [self.path.clone(), self.genom_path.clone(), config.path].concat();
        config.include = [self.include.clone(), config.include].concat();
        config.rpc.socket = self.socket.clone().or(config.rpc.socket);
        config.rpc.listen = self.listen.or(config.rpc.listen);
        config.web.listen = self.web.or(config.web.listen);
        config.foxglove.listen = self.foxglove.or(config.foxglove.listen);
        config.rpc.token_file = self.token_file.clone().or(config.rpc.token_file);
        config
    }
}
