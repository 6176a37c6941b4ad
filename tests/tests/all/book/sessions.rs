//! The sessions of each chapter are run from its top to its end, and must print what is shown.
//! With `UPDATE_EXPECT=1` in the environment the chapters are rewritten with what came.

use std::collections::BTreeSet;
use std::fs;

use super::console::{Part, parts};
use super::place::Place;
use super::{chapters, source};

#[track_caller]
fn play(chapter: &str) {
    let file = source().join(format!("{chapter}.md"));
    let text = fs::read_to_string(&file).unwrap();
    let place = Place::new();
    let (mut page, mut wrong) = (String::new(), Vec::new());
    for part in parts(&text) {
        match part {
            Part::Text(text) => page.push_str(&text),
            Part::File(name, text) => {
                if !text.starts_with("{{#include") {
                    place.write(&name, &text);
                }
            }
            Part::Session(steps) => {
                page.push_str("```console\n");
                for step in steps {
                    let came = place.run(&step);
                    if !step.allows(&came) {
                        wrong.push(format!("$ {}\n{}", step.command, came.join("\n")));
                    }
                    page.push_str(&step.with(&came).text());
                }
                page.push_str("```\n");
            }
        }
    }
    place.stop(None);
    if wrong.is_empty() {
        return;
    }
    if std::env::var_os("UPDATE_EXPECT").is_some() {
        fs::write(&file, page).unwrap();
        return;
    }
    panic!(
        "{chapter}.md shows another output; UPDATE_EXPECT=1 takes this over:\n{}",
        wrong.join("\n")
    );
}

/// One test per chapter, named as a sentence.
macro_rules! sessions {
    ($($chapter:literal: $name:ident,)*) => {
        $(
            #[test]
            fn $name() {
                play($chapter);
            }
        )*
        const PLAYED: &[&str] = &[$($chapter),*];
    };
}

sessions! {
    "first-minutes": a_reader_moves_the_demo_within_minutes,
    "own": a_component_of_ones_own_is_made_built_and_run,
    "types": types_are_looked_at_and_changed,
    "services": services_are_called_interrupted_and_refused,
    "ports": ports_are_read_fed_and_connected,
    "deployment": a_robot_is_deployed_from_a_file,
    "debugging": what_is_wrong_is_found,
    "python": python_drives_the_demo,
    "realtime": the_time_of_tasks_is_told,
    "timing": tasks_are_found_to_be_late_before_while_and_after_they_run,
    "isolation": a_component_in_a_cell_comes_back,
}

#[test]
fn every_chapter_with_a_session_is_played() {
    let has_session =
        |file: &std::path::PathBuf| fs::read_to_string(file).unwrap().contains("\n```console\n");
    let found: BTreeSet<String> = chapters()
        .iter()
        .filter(|file| has_session(file))
        .map(|file| file.strip_prefix(source()).unwrap().with_extension("").display().to_string())
        .collect();
    assert_eq!(found, PLAYED.iter().map(|&name| name.to_owned()).collect());
}
