//! Every verb of genomctl as a user types it, with its exact output and its main errors:
//! tests/transcripts/*.txt.

use std::collections::BTreeSet;

use genom_tests::{repository, transcript};

/// One test per transcript, named as a sentence.
macro_rules! transcripts {
    ($($file:literal: $name:ident,)*) => {
        $(
            #[test]
            fn $name() {
                transcript(&repository().join(concat!("tests/transcripts/", $file, ".txt")));
            }
        )*
        const PLAYED: &[&str] = &[$($file),*];
    };
}

transcripts! {
    "cells": components_run_in_processes_of_their_own,
    "choice": what_fits_is_offered_and_values_are_shown_as_wanted,
    "completion": live_names_are_completed,
    "monitor": rules_of_supervision_are_shown_and_verified,
    "manual": manual_pages_are_made_from_the_definitions_of_the_help,
    "dead": every_verb_says_how_to_start_a_daemon,
    "deploy": a_deployment_file_is_applied_and_dumped,
    "describe": descriptions_are_checked_and_shown_without_a_daemon,
    "doctor": what_is_wrong_with_a_machine_is_told_with_its_fix,
    "reach": daemons_are_named_and_reached_elsewhere,
    "look": what_runs_is_listed_and_described,
    "drive": services_are_called_and_activities_driven,
    "traffic": ports_are_read_measured_fed_and_wired,
    "verify": tasks_are_checked_by_files_and_as_they_run,
    "web": a_link_to_the_console_is_printed,
    "why": each_reason_why_no_data_flows_is_told_with_its_fix,
}

#[test]
fn every_transcript_is_played() {
    let files = std::fs::read_dir(repository().join("tests/transcripts")).unwrap();
    let found: BTreeSet<String> = files
        .map(|file| file.unwrap().path().file_stem().unwrap().to_string_lossy().into_owned())
        .collect();
    assert_eq!(found, PLAYED.iter().map(|&name| name.to_owned()).collect());
}
