//! `cargo faults`: tries what misbehaving codels do to their process, and ends daemons while they
//! use shared memory; prints a table of the effects on the daemon and on others.
//!
//! `faults --peer ROLE...` is a peer that these and other tests run as another process.

#![forbid(unsafe_code)]
#![allow(clippy::print_stdout, reason = "standard output is the table")]

use std::io::IsTerminal as _;
use std::process::ExitCode;
use std::time::Duration;

use genom_tests::bare;
use genom_tests::crash::{Phase, Points, Stage, Toll};
use genom_tests::faults::{FAULTS, Fault};
use genom_tests::siege::Siege;
use genom_tests::trial::{Place, Trial};

const HELP: &str = "\
Try what codels can do to the process they share, in the process of their daemon and in a cell, and
end daemons with SIGKILL before calls that touch shared memory. Print what became of it, the periods
that tasks of 1 kHz missed beside it and in another process, when all was back, by how much the
daemon grew, and what was left behind. Exit status 1: something became of one that is not what is to
become of it.

Usage: cargo faults [--short] [--json] [--release] [--place NAME] [--times N] [--every N]
                    [--backend NAME]... [WORD]...
       cargo faults --network SECONDS [--kills N] [--seed N] [--json] [--release]

  --short         A few of them, in seconds
  --release       Programs as users build them [default: those of the tests]
  --place NAME    Only where it is `own`, the process of the daemon, or `cell`
  --times N       Each fault that ends a cell so often, for percentiles [default: 1]
  --every N       End daemons before every Nth call on shared memory; 1: all, in ten minutes
                  [default: 4]
  --backend NAME  On this middleware: local, shm, zenoh, ros2 [default: each fault on local, those
                  that end the daemon on all, and in cells on shm]
  --network SECONDS  Instead: send hostile bytes to the gateways of a daemon, the three datagrams
                  that end RustDDS and then RTPS and zenoh by chance for so long, and print how long
                  ports did not flow (exit status 1: more than a second), and the periods missed
  --kills N       Then end gateways with SIGKILL so often
  --seed N        Other bytes [default: 1]
  --json          A list of objects instead of the table
  WORD            Only faults that say this word, or have it in the name of component or service;
                  `SIGKILL` are the ends of daemons
";

const BACKENDS: [&str; 4] = ["local", "shm", "zenoh", "ros2"];

/// The short form: the phases in which an ended daemon leaves most, and one fault of each other
/// kind.
const SHORT: [(&str, &str, Place, &str); 5] = [
    ("crashes", "segfault", Place::Own, "shm"),
    ("crashes", "segfault", Place::Cell, "shm"),
    ("crashes", "leave", Place::Own, "local"),
    ("escapes", "fail", Place::Own, "local"),
    ("strays", "unknown", Place::Own, "local"),
];

struct Asked {
    short: bool,
    release: bool,
    json: bool,
    places: Vec<Place>,
    times: usize,
    every: usize,
    siege: Option<Duration>,
    kills: usize,
    seed: usize,
    backends: Vec<String>,
    words: Vec<String>,
}

/// A row of the table.
#[derive(Clone, Copy)]
enum Chosen<'a> {
    Fault(&'static Fault, Place, &'a str),
    Killed(Phase, Points),
}

fn asked(mut arguments: impl Iterator<Item = String>) -> Result<Option<Asked>, String> {
    let mut asked = Asked {
        short: false,
        release: false,
        json: false,
        places: Place::ALL.to_vec(),
        times: 1,
        every: 4,
        siege: None,
        kills: 0,
        seed: 1,
        backends: Vec::new(),
        words: Vec::new(),
    };
    let number = |word: Option<String>| word?.parse().ok().filter(|&number: &usize| number > 0);
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "-h" | "--help" => return Ok(None),
            "--short" => asked.short = true,
            "--release" => asked.release = true,
            "--json" => asked.json = true,
            "--every" => match number(arguments.next()) {
                Some(every) => asked.every = every,
                None => return Err("--every takes a number from 1".to_owned()),
            },
            "--network" => match number(arguments.next()) {
                Some(seconds) => asked.siege = Some(Duration::from_secs(seconds as u64)),
                None => return Err("--network takes seconds from 1".to_owned()),
            },
            "--kills" => match number(arguments.next()) {
                Some(kills) => asked.kills = kills,
                None => return Err("--kills takes a number from 1".to_owned()),
            },
            "--seed" => match number(arguments.next()) {
                Some(seed) => asked.seed = seed,
                None => return Err("--seed takes a number from 1".to_owned()),
            },
            "--times" => match number(arguments.next()) {
                Some(times) => asked.times = times,
                None => return Err("--times takes a number from 1".to_owned()),
            },
            "--place" => {
                let named = arguments.next().unwrap_or_default();
                match Place::ALL.into_iter().find(|place| place.to_string() == named) {
                    Some(place) => asked.places = vec![place],
                    None => return Err("--place takes own or cell".to_owned()),
                }
            }
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

/// The faults with the middlewares to try them on, and the ends of daemons on shared memory.
fn chosen(asked: &Asked) -> Vec<Chosen<'_>> {
    let says = |text: String| {
        let text = text.to_lowercase();
        asked.words.iter().all(|word| text.contains(word))
    };
    let faults = FAULTS
        .iter()
        .filter(|fault| says(format!("{} {}/{}", fault.what, fault.component, fault.service)));
    let pairs = faults.flat_map(|fault| {
        let given = asked.backends.iter().map(String::as_str);
        let given: Vec<&str> = given.collect();
        asked.places.iter().flat_map(move |&place| {
            let all = match place {
                Place::Own if fault.outcome.goes_on() => &BACKENDS[..1],
                Place::Own => &BACKENDS[..],
                Place::Cell => &BACKENDS[1..2],
            };
            let on = if given.is_empty() { all.to_vec() } else { given.clone() };
            on.into_iter().map(move |backend| (fault, place, backend))
        })
    });
    let short = |(fault, place, backend): &(&Fault, Place, &str)| {
        SHORT.contains(&(fault.component, fault.service, *place, *backend))
    };
    let faults = pairs.filter(|pair| !asked.short || short(pair));
    let points = if asked.short { Points::Few(3) } else { Points::Every(asked.every) };
    let on_shm = asked.backends.is_empty() || asked.backends.iter().any(|name| name == "shm");
    let whole = asked.places.contains(&Place::Own);
    let killed =
        Phase::ALL.into_iter().filter(|phase| whole && on_shm && says(Trial::killed_in(*phase)));
    faults
        .map(|(fault, place, backend)| Chosen::Fault(fault, place, backend))
        .chain(killed.map(|phase| Chosen::Killed(phase, points)))
        .collect()
}

/// Shows progress: on a terminal in one changing line, otherwise one line each.
fn tell(progress: &str) {
    if std::io::stderr().is_terminal() {
        eprint!("\r\x1b[K{progress}");
    } else {
        eprintln!("{progress}");
    }
}

fn try_all(chosen: &[Chosen<'_>], times: usize) -> Result<Vec<Trial>, std::io::Error> {
    let program = std::env::current_exe()?;
    let mut stage = None;
    let mut trials = Vec::with_capacity(chosen.len());
    for (at, chosen_one) in chosen.iter().enumerate() {
        let number = format!("{}/{}", at + 1, chosen.len());
        trials.push(match *chosen_one {
            Chosen::Fault(fault, place, backend) => {
                tell(&format!("{number}: a codel {} on {backend} ({place})", fault.what));
                // Failures are shown in the table instead.
                std::panic::set_hook(Box::new(|_| {}));
                let trial = Trial::of(fault, place, backend, times);
                drop(std::panic::take_hook());
                trial
            }
            Chosen::Killed(phase, points) => {
                let stage = stage.get_or_insert_with(|| Stage::new(&program));
                let told = &mut |outcome: &_| tell(&format!("{number}: SIGKILL in {outcome}"));
                Trial::of_killed(&Toll::of(stage, phase, points, told))
            }
        });
    }
    if let (Some(stage), Some(last)) = (stage, trials.last_mut()) {
        let left = stage.end();
        if !left.is_empty() {
            last.wrong.get_or_insert_with(|| format!("left when all had ended: {left:?}"));
        }
    }
    if std::io::stderr().is_terminal() {
        eprint!("\r\x1b[K");
    }
    Ok(trials)
}

fn print(trials: &[Trial]) {
    const HEAD: [&str; 8] =
        ["FAULT", "PLACE", "BACKEND", "WHAT HAPPENED", "PERIODS MISSED", "BACK", "MEMORY", "LEFT"];
    let rows: Vec<[&str; 8]> = trials
        .iter()
        .map(|one| -> [&str; 8] {
            let Trial { fault, place, backend, happened, neighbours, back, memory, left, .. } = one;
            [fault, place, backend, happened, neighbours, back, memory, left]
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
            println!("\n{} on {} ({}): {wrong}", one.fault, one.backend, one.place);
        }
    }
}

fn besiege(asked: &Asked) -> ExitCode {
    if asked.release {
        let _ = genom_tests::release();
    }
    let (bytes, seed) = (asked.siege.unwrap_or_default(), asked.seed as u64);
    let outcome = Siege { bytes, kills: asked.kills, seed }.lay();
    if asked.json {
        println!("{}", outcome.json());
    } else {
        print!("{}", outcome.told());
    }
    match outcome.wrong() {
        None => ExitCode::SUCCESS,
        Some(wrong) => {
            eprint!("{wrong}");
            ExitCode::FAILURE
        }
    }
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    if let ["--peer", role @ ..] = words.as_slice() {
        return if bare::play(role) { ExitCode::SUCCESS } else { ExitCode::from(2) };
    }
    let asked = match asked(arguments.into_iter()) {
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
    if asked.siege.is_some() {
        return besiege(&asked);
    }
    let chosen = chosen(&asked);
    if chosen.is_empty() {
        eprintln!("no fault is called so");
        return ExitCode::from(2);
    }
    if asked.release {
        let _ = genom_tests::release();
    }
    let trials = match try_all(&chosen, asked.times) {
        Ok(trials) => trials,
        Err(why) => {
            eprintln!("this program cannot be started again: {why}");
            return ExitCode::FAILURE;
        }
    };
    if asked.json {
        let all: Vec<_> = trials.iter().map(Trial::json).collect();
        println!("{}", serde_json::Value::from(all));
    } else {
        print(&trials);
    }
    let well = trials.iter().all(|trial| trial.wrong.is_none());
    if well { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
