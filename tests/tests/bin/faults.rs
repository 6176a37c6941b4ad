//! Tries what codels can do to the process they share, and prints what became of it and of all
//! around it: `cargo faults`.

#![forbid(unsafe_code)]
#![allow(clippy::print_stdout, reason = "standard output is the table")]

use std::io::IsTerminal as _;
use std::process::ExitCode;

use genom_tests::faults::{FAULTS, Fault};
use genom_tests::trial::Trial;

const HELP: &str = "\
Try what codels can do to the process they share, and print what became of it, of a component in
the same daemon and one in another, and of the next start. Exit status 1: something became of one
that is not what is to become of it.

Usage: cargo faults [--short] [--json] [--backend NAME]... [WORD]...

  --short         A few of them, in seconds
  --backend NAME  On this middleware: local, shm, zenoh, ros2 [default: each fault on local, and
                  those that end the daemon on all]
  --json          A list of objects instead of the table
  WORD            Only faults that say this word, or have it in the name of component or service
";

const BACKENDS: [&str; 4] = ["local", "shm", "zenoh", "ros2"];

/// What is tried in short: ends of the daemon where it leaves most, and one of each other kind.
const SHORT: [(&str, &str, &str); 4] = [
    ("crashes", "segfault", "shm"),
    ("crashes", "leave", "local"),
    ("escapes", "fail", "local"),
    ("strays", "unknown", "local"),
];

#[derive(Default)]
struct Asked {
    short: bool,
    json: bool,
    backends: Vec<String>,
    words: Vec<String>,
}

fn asked(mut arguments: impl Iterator<Item = String>) -> Result<Option<Asked>, String> {
    let mut asked = Asked::default();
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "-h" | "--help" => return Ok(None),
            "--short" => asked.short = true,
            "--json" => asked.json = true,
            "--backend" => match arguments.next() {
                Some(name) if BACKENDS.contains(&name.as_str()) => asked.backends.push(name),
                _ => return Err(format!("--backend takes one of {}", BACKENDS.join(", "))),
            },
            option if option.starts_with('-') => return Err(format!("no option {option}")),
            word => asked.words.push(word.to_lowercase()),
        }
    }
    Ok(Some(asked))
}

/// Faults with the middlewares to try them on.
fn chosen(asked: &Asked) -> Vec<(&'static Fault, &str)> {
    let says = |fault: &Fault| {
        let text = format!("{} {}/{}", fault.what, fault.component, fault.service).to_lowercase();
        asked.words.iter().all(|word| text.contains(word))
    };
    let pairs = FAULTS.iter().filter(|fault| says(fault)).flat_map(|fault| {
        let given = asked.backends.iter().map(String::as_str);
        let all = if fault.outcome.goes_on() { &BACKENDS[..1] } else { &BACKENDS[..] };
        let on: Vec<&str> = if asked.backends.is_empty() { all.to_vec() } else { given.collect() };
        on.into_iter().map(move |backend| (fault, backend))
    });
    let short = |(fault, backend): &(&Fault, &str)| {
        SHORT.contains(&(fault.component, fault.service, *backend))
    };
    pairs.filter(|pair| !asked.short || short(pair)).collect()
}

fn print(trials: &[Trial]) {
    const HEAD: [&str; 6] =
        ["FAULT", "BACKEND", "WHAT HAPPENED", "PERIODS MISSED", "NEXT START", "LEFT BEHIND"];
    let rows: Vec<[&str; 6]> = trials
        .iter()
        .map(|one| -> [&str; 6] {
            [&one.fault, &one.backend, &one.happened, &one.neighbours, &one.next, &one.left]
        })
        .collect();
    let widths: Vec<usize> = (0..HEAD.len())
        .map(|at| rows.iter().map(|row| row[at].len()).chain([HEAD[at].len()]).max().unwrap_or(0))
        .collect();
    for row in [HEAD].iter().chain(&rows) {
        let cells = row.iter().zip(&widths).map(|(cell, width)| format!("{cell:width$}"));
        println!("{}", cells.collect::<Vec<_>>().join("  ").trim_end());
    }
    for one in trials {
        if let Some(wrong) = &one.wrong {
            println!("\n{} on {}: {wrong}", one.fault, one.backend);
        }
    }
}

fn main() -> ExitCode {
    let asked = match asked(std::env::args().skip(1)) {
        Ok(Some(asked)) => asked,
        Ok(None) => {
            print!("{HELP}");
            return ExitCode::SUCCESS;
        }
        Err(why) => {
            eprintln!("{why}\n\n{HELP}");
            return ExitCode::from(2);
        }
    };
    // What fails is told in the table.
    std::panic::set_hook(Box::new(|_| {}));
    let chosen = chosen(&asked);
    if chosen.is_empty() {
        eprintln!("no fault is called so");
        return ExitCode::from(2);
    }
    let (all, lives) = (chosen.len(), std::io::stderr().is_terminal());
    let mut trials = Vec::with_capacity(all);
    for (at, (fault, backend)) in chosen.into_iter().enumerate() {
        let progress = format!("{}/{all}: a codel {} on {backend}", at + 1, fault.what);
        // One line that changes for people, a line each for logs.
        if lives {
            eprint!("\r\x1b[K{progress}")
        } else {
            eprintln!("{progress}")
        }
        trials.push(Trial::of(fault, backend));
    }
    if lives {
        eprint!("\r\x1b[K");
    }
    if asked.json {
        let all: Vec<_> = trials.iter().map(Trial::json).collect();
        println!("{}", serde_json::Value::from(all));
    } else {
        print(&trials);
    }
    let well = trials.iter().all(|trial| trial.wrong.is_none());
    if well { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
