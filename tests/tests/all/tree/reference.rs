//! docs/cli.md matches the help texts of genomctl, and every verb has a test.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::process::Command;

use genom_tests::{Running, program, repository};

/// Verbs that cannot be in a transcript, with the tests that use them.
const ELSEWHERE: &[(&str, &str, &str)] = &[
    (
        "lsp",
        "tests/tests/all/editors/server.rs",
        "mistakes_are_told_when_a_text_is_opened_and_go_when_they_are_corrected",
    ),
    (
        "freeze",
        "tests/tests/all/freezing/refused.rs",
        "a_component_whose_codels_never_rest_is_not_frozen_and_the_codel_is_named",
    ),
    (
        "thaw",
        "tests/tests/all/freezing/thawed.rs",
        "a_motion_goes_on_in_another_daemon_step_by_step_as_it_would_have",
    ),
    (
        "reload",
        "tests/tests/all/reload/kept.rs",
        "while_time_goes_on_the_new_code_goes_on_in_the_state_of_the_old",
    ),
    (
        "record",
        "tests/tests/all/control_plane/recording.rs",
        "a_recording_is_read_back_by_others_with_calls_activities_and_exceptions",
    ),
    (
        "replay",
        "tests/tests/all/control_plane/recording.rs",
        "a_replay_on_the_stepped_clock_gives_the_same_motion",
    ),
    (
        "recover",
        "tests/tests/all/control_plane/recording.rs",
        "of_a_recorder_that_was_killed_all_that_is_whole_is_replayed_and_recovered",
    ),
    (
        "bag",
        "tests/tests/all/control_plane/bags.rs",
        "a_bag_has_the_samples_of_a_recording_and_nothing_that_ros_does_not_know",
    ),
    (
        "bench",
        "tests/tests/all/deployment/compared.rs",
        "a_way_that_cannot_run_is_listed_with_its_reason_and_the_others_run",
    ),
    (
        "conformance",
        "tests/tests/all/backends/plugins.rs",
        "the_conformance_suite_runs_on_a_library_and_tells_what_does_not_hold",
    ),
    ("new", "tests/tests/all/projects/new.rs", "a_new_component_builds_runs_and_passes_its_test"),
    (
        "add",
        "tests/tests/all/projects/add.rs",
        "what_is_added_to_a_component_builds_and_runs_and_what_was_written_stays",
    ),
    (
        "build",
        "tests/tests/all/projects/bare.rs",
        "a_description_and_its_codels_become_a_library_that_runs",
    ),
    ("test", "tests/tests/all/scenarios/failures.rs", "programs_read_failures_as_junit"),
    (
        "sdk",
        "tests/tests/all/projects/genom3.rs",
        "an_sdk_does_not_replace_genom3_of_another_package",
    ),
    (
        "ros2-package",
        "daemon/genomctl/tests/ros2_package/main.rs",
        "packages_are_written_for_colcon",
    ),
    ("events", "tests/tests/all/cli/terminal.rs", "events_are_told_as_they_happen"),
    (
        "logs",
        "tests/tests/all/control_plane/streams.rs",
        "logs_are_kept_and_followed_by_component_and_level",
    ),
    (
        "start",
        "tests/tests/all/cli/terminal.rs",
        "ctrl_c_aborts_what_was_started_and_a_second_one_leaves_it",
    ),
    ("call", "tests/tests/all/cli/terminal.rs", "inputs_are_asked_for_when_none_were_given"),
    (
        "top",
        "tests/tests/all/cli/terminal.rs",
        "the_live_table_shows_ports_and_gives_the_terminal_back",
    ),
];

/// Transcripts and the tests that play them: `"look": what_runs_is_listed,`.
fn played() -> Vec<(String, String)> {
    let source =
        fs::read_to_string(repository().join("tests/tests/all/cli/transcripts.rs")).unwrap();
    let entry = |line: &str| {
        let (file, test) = line.trim().strip_suffix(',')?.split_once(": ")?;
        let file = file.strip_prefix('"')?.strip_suffix('"')?;
        let path = repository().join(format!("tests/transcripts/{file}.txt"));
        Some((fs::read_to_string(path).ok()?, test.to_owned()))
    };
    let found: Vec<_> = source.lines().filter_map(entry).collect();
    assert!(!found.is_empty(), "the list of transcripts has another form");
    found
}

/// Whether a transcript uses a verb, and whether it shows a refusal.
fn uses(text: &str, verb: &str) -> (bool, bool) {
    let (mut used, mut refused, mut current) = (false, false, false);
    for line in text.lines() {
        if let Some(command) = line.strip_prefix("$ ") {
            let words: Vec<&str> = command.split_whitespace().collect();
            let verb_of = |at: usize| words[at + 1..].iter().find(|word| !word.starts_with('-'));
            current = words.iter().enumerate().any(|(at, word)| {
                word.ends_with("genomctl") && verb_of(at).is_some_and(|found| *found == verb)
            });
            used |= current;
        } else if current && line.starts_with("? ") {
            refused = true;
        }
    }
    (used, refused)
}

/// The table of verbs and tests.
fn table(verbs: &[&str]) -> String {
    let mut tests: BTreeMap<&str, Vec<String>> = BTreeMap::new();
    let mut unrefused = verbs.to_vec();
    for (text, test) in played() {
        for verb in verbs {
            let (used, refused) = uses(&text, verb);
            if used {
                tests.entry(verb).or_default().push(format!("`{test}`"));
            }
            if refused {
                unrefused.retain(|other| other != verb);
            }
        }
    }
    for (verb, file, test) in ELSEWHERE {
        let source = fs::read_to_string(repository().join(file)).unwrap();
        assert!(source.contains(&format!("fn {test}(")), "{file} has no {test}");
        tests.entry(verb).or_default().push(format!("`{test}`"));
        unrefused.retain(|other| other != verb);
    }
    let mut out = String::from("\n## Tests\n\nWhere each verb is shown at work.\n\n");
    out.push_str("| Verb | Tests |\n|---|---|\n");
    let mut untested = Vec::new();
    for verb in verbs {
        match tests.get(verb) {
            Some(tests) => writeln!(out, "| `{verb}` | {} |", tests.join(", ")).unwrap(),
            None => untested.push(verb),
        }
    }
    let way = "show it in tests/transcripts, or name its test in ELSEWHERE";
    assert!(untested.is_empty(), "verbs without a test: {untested:?}; {way}");
    // Every verb that needs a daemon is refused at least when there is none.
    assert!(unrefused.is_empty(), "verbs never seen refused: {unrefused:?}; {way}");
    out
}

#[test]
fn the_reference_is_what_genomctl_says_of_itself() {
    let mut command = Command::new(program("genomctl"));
    command.env_clear().arg("reference");
    let told = Running::start(&mut command).finish();
    told.expect_code(0);
    let verbs: Vec<&str> = told.out.lines().filter_map(|line| line.strip_prefix("## ")).collect();
    assert!(verbs.len() > 30, "{verbs:?}");
    let wanted = format!("{}{}", told.out, table(&verbs));
    let path = repository().join("docs/cli.md");
    if std::env::var_os("UPDATE_EXPECT").is_some() {
        fs::write(&path, &wanted).unwrap();
    }
    let written = fs::read_to_string(&path).unwrap_or_default();
    assert!(
        written == wanted,
        "docs/cli.md is out of step: `UPDATE_EXPECT=1 cargo test --workspace --test all -- tree::reference` \
         writes it"
    );
}
