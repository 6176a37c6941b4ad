//! Sections `[runners.NAME]`: programs that run codels in the language NAME (docs/runners.md). The one
//! for Python is an interpreter, which `cells.python` names.

use std::collections::BTreeMap;

use genom_elf::languages::KNOWN;
use serde::{Deserialize, Serialize};

use crate::error::UsageError;

/// Section `[runners.NAME]`.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct RunnerSection {
    /// Extension of the scripts, without the dot; only of a language that genomd does not know.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub extension: Option<String>,
    /// The program, and its first arguments.
    pub command: Vec<String>,
}

/// All of them, by the name of the language.
pub type Runners = BTreeMap<String, RunnerSection>;

/// The language whose interpreter has a key of its own.
const PYTHON: &str = "python";

/// What runs its scripts: the arguments before those of genomd.
const PYTHON_RUNNER: [&str; 2] = ["-m", "genom.runner"];

/// What runs codels in Lua, unless the configuration says otherwise.
const LUA_RUNNER: (&str, &str) = ("lua", "genom-lua");

/// Extensions that files beside a description have for another reason.
const TAKEN: [&str; 7] = ["so", "gen", "idl", "h", "c", "cc", "toml"];

/// Most languages, most words of a command, most bytes of a word.
const MOST: (usize, usize, usize) = (16, 32, 4096);

/// The command that runs scripts of a language; `python` is the interpreter of Python.
pub(crate) fn command(runners: &Runners, language: &str, python: &str) -> Option<Vec<String>> {
    if language == PYTHON {
        let words = [python].into_iter().chain(PYTHON_RUNNER);
        return Some(words.map(str::to_owned).collect());
    }
    let configured = runners.get(language).map(|runner| runner.command.clone());
    configured.or_else(|| (language == LUA_RUNNER.0).then(|| vec![LUA_RUNNER.1.to_owned()]))
}

/// The key that names the program.
pub(crate) fn key(language: &str) -> String {
    if language == PYTHON {
        "cells.python".to_owned()
    } else {
        format!("runners.{language}.command")
    }
}

/// The languages that genomd does not know, with their extensions.
pub(crate) fn added(runners: &Runners) -> Vec<(String, String)> {
    let extension =
        |(name, runner): (&String, &RunnerSection)| Some((name.clone(), runner.extension.clone()?));
    runners.iter().filter_map(extension).collect()
}

/// Checks them all.
pub(crate) fn check(runners: &Runners) -> Result<(), UsageError> {
    let refuse = |name: &str, what: String| Err(UsageError::Runner { name: name.to_owned(), what });
    let (languages, words, bytes) = MOST;
    let mut extensions: Vec<&str> = TAKEN.into_iter().chain(KNOWN.map(|(_, one)| one)).collect();
    for (rank, (name, runner)) in runners.iter().enumerate() {
        let plain = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_';
        if rank == languages {
            return refuse(name, format!("there are more than {languages} runners"));
        }
        if !(1..=32).contains(&name.len()) || !name.chars().all(plain) {
            return refuse(name, "a language is named by 1 to 32 of a-z, 0-9 and _".to_owned());
        }
        if name == PYTHON || name == "c" {
            let what =
                if name == "c" { "codels in C are libraries" } else { "cells.python names it" };
            return refuse(name, what.to_owned());
        }
        let command = &runner.command;
        let sound = |word: &String| word.len() <= bytes && !word.contains('\0');
        if command.first().is_none_or(String::is_empty)
            || command.len() > words
            || !command.iter().all(sound)
        {
            let what = format!("command: a program and at most {} arguments", words - 1);
            return refuse(name, what);
        }
        let known = KNOWN.iter().find(|(known, _)| known == name).map(|(_, extension)| *extension);
        match (runner.extension.as_deref(), known) {
            (None, Some(_)) => {}
            (Some(given), Some(known)) if given == known => {}
            (_, Some(known)) => return refuse(name, format!("its scripts are files .{known}")),
            (Some(given), None)
                if (1..=8).contains(&given.len())
                    && given.chars().all(|c| c.is_ascii_alphanumeric())
                    && !extensions.contains(&given) =>
            {
                extensions.push(given);
            }
            (given, None) => {
                let given = given.unwrap_or_default();
                let what = format!(
                    "extension = {given:?}: give that of its scripts, 1 to 8 letters and digits, \
                     none of {}",
                    extensions.join(", ")
                );
                return refuse(name, what);
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn runners(text: &str) -> Runners {
        toml::from_str(text).unwrap()
    }

    #[test]
    fn each_language_has_its_command() {
        let all = runners("[julia]\nextension = \"jl\"\ncommand = [\"julia\", \"runner.jl\"]\n");
        check(&all).unwrap();
        assert_eq!(added(&all), [("julia".to_owned(), "jl".to_owned())]);
        let command = |language| command(&all, language, "python3").map(|words| words.join(" "));
        assert_eq!(command("julia").as_deref(), Some("julia runner.jl"));
        assert_eq!(command("python").as_deref(), Some("python3 -m genom.runner"));
        assert_eq!(command("lua").as_deref(), Some("genom-lua"));
        assert_eq!(command("perl"), None);
    }

    #[test]
    fn what_is_no_runner_is_refused_by_its_name() {
        let long = format!("[x]\nextension = \"x\"\ncommand = [{:?}]", "x".repeat(4097));
        let many: String =
            (0..17).map(|n| format!("[l{n}]\nextension = \"e{n}\"\ncommand = [\"x\"]\n")).collect();
        for (text, told) in [
            ("[julia]\ncommand = [\"julia\"]", "runners.julia: extension = \"\""),
            ("[julia]\nextension = \"so\"\ncommand = [\"julia\"]", "none of so"),
            ("[julia]\nextension = \"../x\"\ncommand = [\"julia\"]", "1 to 8 letters"),
            ("[julia]\nextension = \"jl\"\ncommand = []", "command: a program"),
            ("[lua]\ncommand = [\"\"]", "command: a program"),
            ("[lua]\ncommand = [\"a\\u0000b\"]", "command: a program"),
            ("[lua]\nextension = \"py\"\ncommand = [\"lua\"]", "files .lua"),
            ("[python]\ncommand = [\"python3\"]", "cells.python names it"),
            ("[\"a/../b\"]\nextension = \"x\"\ncommand = [\"x\"]", "a language is named by"),
            (&long, "command: a program"),
            (&many, "more than 16 runners"),
        ] {
            let refused = check(&runners(text)).unwrap_err().to_string();
            assert!(refused.contains(told), "{refused}");
        }
        let two =
            "[a]\nextension = \"x\"\ncommand = [\"x\"]\n[b]\nextension = \"x\"\ncommand = [\"x\"]";
        assert!(check(&runners(two)).unwrap_err().to_string().contains("runners.b: extension"));
    }
}
