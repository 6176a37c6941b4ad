//! The chapters of reference are made of what the programs and their sources say. With
//! `UPDATE_EXPECT=1` in the environment these tests write them.

use std::fmt::Write as _;
use std::fs;
use std::process::Command;

use genom_tests::{Daemon, Home, Running, program, repository, request};
use serde_json::Value;

use super::source;

/// Compares a chapter with what it must be, or writes it.
#[track_caller]
fn chapter(name: &str, text: &str) {
    let file = source().join(format!("reference/{name}.md"));
    if std::env::var_os("UPDATE_EXPECT").is_some() {
        fs::write(&file, text).unwrap();
    }
    let written = fs::read_to_string(&file).unwrap_or_default();
    assert!(
        written == text,
        "docs/book/src/reference/{name}.md is out of step: `UPDATE_EXPECT=1 cargo test --workspace \
         --test all -- book::generated` writes it"
    );
}

/// A table of a configuration file: how it is written, the struct that reads it, and where its
/// defaults are in what `--dump-config` prints.
struct Section {
    /// The lines before its keys.
    head: &'static str,
    file: &'static str,
    of: &'static str,
    defaults: &'static [&'static str],
}

const fn section(
    head: &'static str,
    file: &'static str,
    of: &'static str,
    defaults: &'static [&'static str],
) -> Section {
    Section { head, file, of, defaults }
}

const COMPONENT: &str = "[[component]]\nlibrary = \"demo\"\n";
const SECTIONS: &[Section] = &[
    section("", "daemon/configuration/src/file.rs", "Config", &[]),
    section("[cells]", "daemon/configuration/src/cells.rs", "CellsSection", &["cells"]),
    section("[cells.limits]", "daemon/configuration/src/limits.rs", "CellLimits", &["none"]),
    section("[cell.NAME]", "daemon/configuration/src/limits.rs", "CellLimits", &["none"]),
    section("[runners.NAME]", "daemon/configuration/src/runners.rs", "RunnerSection", &["none"]),
    section("[gateways]", "daemon/configuration/src/gateways.rs", "GatewaysSection", &["gateways"]),
    section("[crashes]", "daemon/configuration/src/crashes.rs", "CrashesSection", &["crashes"]),
    section("[reload]", "daemon/configuration/src/reload.rs", "ReloadSection", &["reload"]),
    section("[blackbox]", "daemon/configuration/src/blackbox.rs", "BlackBoxSection", &["blackbox"]),
    section(
        "[recordings]",
        "daemon/configuration/src/recordings.rs",
        "RecordingsSection",
        &["recordings"],
    ),
    section("[rpc]", "daemon/configuration/src/rpc.rs", "Rpc", &["rpc"]),
    section("[rpc.tls]", "daemon/configuration/src/rpc.rs", "Tls", &["none"]),
    section("[services]", "daemon/configuration/src/offers.rs", "Offers", &["services"]),
    section("[telemetry]", "daemon/configuration/src/file.rs", "Telemetry", &["telemetry"]),
    section("[[component]]", "daemon/protocol/src/load.rs", "LoadRequest", &["none"]),
    section("[component.tasks.NAME]", "daemon/protocol/src/load.rs", "TaskEntry", &["none"]),
    section("[component.qos]", "daemon/protocol/src/quality.rs", "QosEntry", &["none"]),
    section("[component.qos.ports.NAME]", "daemon/protocol/src/quality.rs", "PortQos", &["none"]),
    section("[[component.on_failure]]", "daemon/protocol/src/on_failure.rs", "Reaction", &["none"]),
    section(
        "[[component.supervision]]",
        "daemon/protocol/src/supervision/mod.rs",
        "SupervisionEntry",
        &["none"],
    ),
    section("[[connection]]", "daemon/protocol/src/deployment.rs", "ConnectionEntry", &["none"]),
    section("[[call]]", "daemon/protocol/src/deployment.rs", "CallEntry", &["none"]),
    section("[[activity]]", "daemon/protocol/src/deployment.rs", "CallEntry", &["none"]),
    section("[backends.shm]", "middlewares/shm/src/options.rs", "Options", &["none"]),
    section("[backends.zenoh]", "middlewares/zenoh/src/options.rs", "Options", &["none"]),
    section("[backends.zenoh.tls]", "middlewares/zenoh/src/options.rs", "Tls", &["none"]),
    section("[backends.ros2]", "middlewares/ros2/src/options.rs", "Options", &["none"]),
    section("[backends.ros2.qos]", "middlewares/ros2/src/options.rs", "Qos", &["none"]),
    section("[backends.ros2.zenoh]", "middlewares/ros2/src/options.rs", "ZenohOptions", &["none"]),
];

/// The keys that genomd takes in a section: those that it names when it is given another one.
fn accepted(section: &Section) -> Vec<String> {
    let head = section.head.replace("NAME", "main");
    let within = if head.contains("component.") { COMPONENT } else { "" };
    let home = Home::new();
    let file = home.path().join("asked.toml");
    fs::write(&file, format!("{within}{head}\nno_such_key = 1\n")).unwrap();
    let mut command = Command::new(program("genomd"));
    command.arg("--dump-config").arg("--config").arg(&file);
    let refused = Running::start(&mut command).finish();
    let told = refused.err.split_once("unknown field `no_such_key`, expected ");
    let (_, keys) = told.unwrap_or_else(|| panic!("{}: {}", section.head, refused.err));
    let line = keys.lines().next().unwrap();
    let line = line.split_once(';').map_or(line, |(keys, _)| keys);
    line.split('`').skip(1).step_by(2).map(str::to_owned).collect()
}

/// What a source says of the fields of a struct: key, and its documentation in one line; names that
/// a field had before, with the one that it has.
fn documented(section: &Section) -> Vec<(String, String)> {
    let text = fs::read_to_string(repository().join(section.file)).unwrap();
    let begin = format!("pub struct {} {{\n", section.of);
    let (_, body) = text.split_once(&begin).unwrap_or_else(|| panic!("no {begin}"));
    let (body, _) = body.split_once("\n}\n").unwrap();
    let (mut fields, mut words, mut renamed) = (Vec::new(), Vec::new(), None);
    let mut before: Option<String> = None;
    for line in body.lines().map(str::trim) {
        if let Some(said) = line.strip_prefix("///") {
            words.push(said.trim().to_owned());
        } else if let Some((_, name)) = line.split_once("alias = \"") {
            before = name.split('"').next().map(str::to_owned);
        } else if let Some((_, name)) = line.split_once("rename = \"") {
            renamed = name.split('"').next().map(str::to_owned);
        } else if let Some((name, _)) = line.strip_prefix("pub ").and_then(|it| it.split_once(':'))
        {
            let key = renamed.take().unwrap_or_else(|| name.to_owned());
            let was = before.take().map(|was| (was, format!("`{key}`, as it was called before.")));
            fields.push((key, std::mem::take(&mut words).join(" ")));
            fields.extend(was);
        }
    }
    fields
}

/// A documentation comment of Rust as Markdown: no links into the source.
fn plain(words: &str) -> String {
    let mut out = String::new();
    let mut rest = words;
    while let Some((before, after)) = rest.split_once("[`") {
        let Some((name, after)) = after.split_once("`]") else { break };
        let after = match after.strip_prefix('(').and_then(|it| it.split_once(')')) {
            Some((_, after)) => after,
            None => after,
        };
        let name = name.rsplit("::").next().unwrap_or(name);
        let _ = write!(out, "{before}`{name}`");
        rest = after;
    }
    (out + rest).replace('|', "\\|")
}

#[test]
fn the_reference_of_the_configuration_is_what_genomd_accepts() {
    let mut dump = Command::new(program("genomd"));
    let dump = Running::start(dump.env_clear().arg("--dump-config")).finish();
    dump.expect_code(0);
    let defaults: toml::Table = dump.out.parse().unwrap();
    let mut text = String::from(
        "# Configuration\n\nEvery key that genomd takes in a configuration, made of its sources. \
         [configs/default.toml](default-toml.md) has the same as a file with comments.\n\n\
         `genomd --config FILE` reads one; options of the command line take precedence; \
         `--set KEY=VALUE` sets one key; `--dump-config` prints what counts. An unknown key is \
         refused with file, line, and the key that was probably meant. Deployment files have the \
         same keys.\n",
    );
    for section in SECTIONS {
        let title = match section.head {
            "" => "Top level".to_owned(),
            head => format!("`{head}`"),
        };
        let _ = write!(text, "\n## {title}\n\n| Key | Default | Meaning |\n|---|---|---|\n");
        let documented = documented(section);
        let table = section
            .defaults
            .iter()
            .try_fold(&defaults, |table, name| table.get(*name).and_then(toml::Value::as_table));
        for key in accepted(section) {
            let found = documented.iter().find(|(name, _)| *name == key);
            let (_, words) = found.unwrap_or_else(|| {
                panic!("{} {key}: no field of {} in {}", section.head, section.of, section.file)
            });
            let value = table.and_then(|table| table.get(&key));
            let value = value.filter(|value| !value.is_table());
            let value = value.map_or_else(String::new, |value| format!("`{value}`"));
            let _ = writeln!(text, "| `{key}` | {value} | {} |", plain(words));
        }
    }
    chapter("configuration", &text);
}

#[test]
fn the_reference_of_the_control_plane_is_what_the_daemon_says_of_it() {
    let daemon = Daemon::start(&[]);
    let document = request(&daemon.home().socket(), "GET", "/openapi.json", "").body;
    let mut text = String::from(
        "# The control plane\n\nHTTP/1.1 and JSON, on a Unix socket and, where configured, on TCP. \
         The daemon serves this as an OpenAPI document with all types at `/openapi.json`, and a \
         page to browse and try it at `/docs`. A route needs the right that stands beside it; the \
         Unix socket has all rights ([Who may do what](../security.md)).\n\n\
         | Route | Right | What it does |\n|---|---|---|\n",
    );
    let mut routes = 0;
    for (path, item) in document["paths"].as_object().unwrap() {
        for (method, operation) in item.as_object().unwrap() {
            let Some(summary) = operation["summary"].as_str() else { continue };
            let right = operation["security"][0]["token"][0].as_str();
            let right = right.map_or_else(String::new, |right| format!("`{right}`"));
            let (method, summary) = (method.to_uppercase(), summary.replace('\n', " "));
            let _ = writeln!(text, "| `{method} {path}` | {right} | {summary} |");
            routes += 1;
        }
    }
    assert!(routes > 30, "{routes} routes");
    text.push_str(
        "\n## Errors\n\nEach error is `{\"error\": {\"code\", \"message\", \"where\", \"help\"}}`. \
         Codes never change between versions, but later versions may add some.\n\n\
         | Code | Meaning |\n|---|---|\n",
    );
    for (code, words) in codes() {
        let _ = writeln!(text, "| `{code}` | {} |", plain(&words));
    }
    chapter("rpc", &text);
}

/// The codes of refusals with their documentation.
fn codes() -> Vec<(String, String)> {
    let text = fs::read_to_string(repository().join("daemon/protocol/src/code.rs")).unwrap();
    let (_, body) = text.split_once("pub enum Code {\n").unwrap();
    let (body, _) = body.split_once("\n}\n").unwrap();
    let (mut codes, mut words) = (Vec::new(), Vec::new());
    for line in body.lines().map(str::trim) {
        match line.strip_prefix("///") {
            Some(said) => words.push(said.trim().to_owned()),
            None => {
                let variant = line.trim_end_matches(',');
                let mut name = String::new();
                for letter in variant.chars() {
                    if letter.is_uppercase() && !name.is_empty() {
                        name.push('_');
                    }
                    name.extend(letter.to_lowercase());
                }
                codes.push((name, std::mem::take(&mut words).join(" ")));
            }
        }
    }
    assert!(codes.len() > 20 && codes.iter().all(|(_, words)| !words.is_empty()), "{codes:?}");
    codes
}

#[test]
fn the_reference_of_diagnostics_is_what_genomctl_explains() {
    let mut command = Command::new(program("genomctl"));
    command.env_clear().args(["--json", "explain"]);
    let told = Running::start(&mut command).finish();
    told.expect_code(0);
    let told: Value = serde_json::from_str(&told.out).unwrap();
    let mut text = String::from(
        "# Diagnostics of descriptions\n\nWhat `genomctl check` says of a `.gen` file, by code; \
         `genomctl explain CODE` prints one. E is an error, W a warning. Codes never change their \
         meaning. `K1` and the like are the rules of [the GenoM3 language](genom3.md).\n",
    );
    let codes = told["codes"].as_array().unwrap();
    assert!(codes.len() > 100, "{} codes", codes.len());
    for code in codes {
        let part = |name: &str| code[name].as_str().unwrap().trim();
        let rule = match part("rule") {
            "" => String::new(),
            rule => format!(" *(rule {rule})*"),
        };
        let _ = write!(
            text,
            "\n## {}\n\n**{}**{rule}\n\n{}\n\n```text\n{}\n```\n",
            part("code"),
            escaped(part("title")),
            escaped(part("text")),
            part("example"),
        );
    }
    chapter("diagnostics", &text);
}

/// Text that is no HTML: `<` and `>` outside of code are written as entities.
fn escaped(text: &str) -> String {
    let mut out = String::new();
    for (number, piece) in text.split('`').enumerate() {
        if number > 0 {
            out.push('`');
        }
        if number % 2 == 0 {
            out.push_str(&piece.replace('<', "&lt;").replace('>', "&gt;"));
        } else {
            out.push_str(piece);
        }
    }
    out
}
