//! Findings that need the live machine: whether multicast works, the daemon, versions.

use std::path::Path;
use std::process::Command;

use genom_doctor::multicast;
use genom_protocol::{Diagnosis, DoctorParameters, routes};

use crate::failure::Failure;
use crate::session::Session;

/// Inspects this machine and the daemon.
pub(crate) async fn live(session: &Session, config: Option<&Path>) -> Vec<Diagnosis> {
    let mut found = vec![multicast()];
    found.extend(daemon(session).await);
    found.extend(config.map(configuration));
    found
}

/// Findings on the daemon: whether it answers, its version, and what it finds itself.
async fn daemon(session: &Session) -> Vec<Diagnosis> {
    const ABOUT: &str = "daemon";
    let about = match session.ask(routes::about()).await {
        Ok(about) => about.content,
        Err(Failure::Unreachable { target, chosen, source }) => {
            let what = match source.kind() {
                std::io::ErrorKind::ConnectionRefused => {
                    format!("{target} is there and nobody answers: its genomd was killed")
                }
                _ => format!("none runs on {target}"),
            };
            let start = "`genomd LIBRARY...` starts one, and takes the socket over".to_owned();
            let fix = chosen.map_or(start, |chosen| chosen.help());
            return vec![Diagnosis::note(ABOUT, what, fix)];
        }
        Err(failure) => {
            return vec![Diagnosis::problem(ABOUT, failure.to_string(), "restart it")];
        }
    };
    let version = about.genomd;
    let own = env!("CARGO_PKG_VERSION");
    let mut found = vec![if version == own {
        Diagnosis::ok(ABOUT, format!("genomd {version} runs"))
    } else {
        let what = format!("genomd is {version}, genomctl is {own}");
        Diagnosis::problem(ABOUT, what, "install both of one version")
    }];
    // Of the machine, this program has seen what is to be seen.
    let route = routes::doctor().with(&DoctorParameters { daemon_only: true });
    match session.ask(route).await {
        Ok(examined) => found.extend(examined.content.daemon),
        Err(failure) => {
            let what = format!("it does not examine itself: {failure}");
            found.push(Diagnosis::problem(ABOUT, what, "install both of one version"));
        }
    }
    found
}

/// Checks the configuration by running genomd.
fn configuration(config: &Path) -> Diagnosis {
    const ABOUT: &str = "configuration";
    let beside = std::env::current_exe().ok().map(|own| own.with_file_name("genomd"));
    let genomd = beside.filter(|path| path.is_file()).unwrap_or_else(|| "genomd".into());
    let read = Command::new(genomd).arg("--config").arg(config).arg("--dump-config").output();
    match read {
        Ok(read) if read.status.success() => {
            Diagnosis::ok(ABOUT, format!("{} is understood", config.display()))
        }
        Ok(read) => {
            let told = String::from_utf8_lossy(&read.stderr);
            let told = told.trim().trim_start_matches("error: ").to_owned();
            Diagnosis::problem(ABOUT, told, "configs/default.toml shows every key")
        }
        Err(error) => {
            Diagnosis::problem(ABOUT, format!("genomd: {error}"), "put genomd beside genomctl")
        }
    }
}
