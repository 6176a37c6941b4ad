//! Rules of genom3.md 7 and dialects.md as recorded sessions: see `scenarios/README.md`.

#![allow(clippy::unwrap_used, clippy::panic)]

mod support;

use std::path::PathBuf;
use std::sync::Arc;

use genom_runtime::{Execution, Executor};

fn directory() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/scenarios")
}

#[track_caller]
fn check(name: &str) {
    let path = directory().join(format!("{name}.txt"));
    let expected = std::fs::read_to_string(&path).unwrap();
    let found = support::transcript::replay(&expected, &Execution::Threads);
    if std::env::var_os("UPDATE_EXPECT").is_some() {
        std::fs::write(&path, &found).unwrap();
    } else if expected != found {
        let first = expected.lines().zip(found.lines()).position(|(a, b)| a != b);
        let line = first.unwrap_or_else(|| expected.lines().count().min(found.lines().count())) + 1;
        panic!("{}:{line} differs. Found:\n{found}", path.display());
    }
    // The same sequence, and no thread, whatever executes components in real time.
    let single = Execution::Single(Arc::new(Executor::new("scenario")));
    assert_eq!(support::transcript::replay(&expected, &single), found, "{name} in one thread");
}

macro_rules! scenarios {
    ($($name:ident)*) => {
        $(#[test] fn $name() { check(stringify!($name)); })*
        const ALL: &[&str] = &[$(stringify!($name)),*];
    };
}

scenarios! {
    a_codel_may_serve_several_states_with_one_list_of_yields
    a_component_without_task_serves_attributes_and_functions
    a_function_interrupts_after_its_codels_and_does_not_wait
    a_function_runs_its_codels_in_order_until_one_fails
    a_held_component_runs_nothing_before_it_goes_on
    a_pause_in_a_periodic_task_lasts_until_the_next_tick
    a_pause_in_an_aperiodic_task_lasts_until_something_happens
    a_permanent_activity_that_fails_takes_the_component_with_it
    a_request_that_fails_validation_frees_its_slot_and_interrupts_nothing
    a_request_that_fails_wakes_the_tasks_as_well
    a_sleeping_place_waits_for_an_external_event_or_stop
    a_start_codel_that_fails_undoes_the_start
    a_stop_cannot_be_stopped_again
    a_stop_without_stop_codel_ends_as_interrupted
    a_task_runs_as_many_activities_as_it_has_slots
    a_thawed_activity_goes_on_in_the_state_where_it_was
    abort_activity_knows_running_activities_only
    activities_end_by_what_their_codels_return
    activities_of_a_task_interleave_one_codel_at_a_time
    activities_of_several_tasks_run_on_their_own
    after_and_before_look_at_what_ran_successfully
    an_activity_stopped_before_it_started_never_starts
    an_activity_waits_for_those_it_interrupts_in_other_tasks
    an_attribute_interrupts_without_waiting_and_counts_as_run
    an_attribute_validates_then_stores_then_fetches
    an_external_event_adds_a_place_while_others_stay_active
    an_interrupting_activity_waits_until_the_interrupted_one_has_ended
    an_interruption_also_stops_what_comes_later
    codels_of_an_attribute_run_after_the_transfer
    delay_shifts_the_ticks_of_a_task
    inputs_that_are_missing_take_the_defaults_of_the_gen
    nothing_is_served_after_a_shutdown
    of_two_pending_that_interrupt_each_other_the_newest_wins
    order_is_checked_when_a_request_comes_and_not_again
    pauses_and_continuations_mix_within_a_tick
    permanent_activities_are_not_interrupted_and_leave_their_task_when_they_end
    permanent_activities_start_in_order_before_requests
    several_instances_of_one_activity_run_at_once
    shutdown_stops_activities_then_tasks_in_reverse_order
    standard_services_ask_the_supervisor
    stop_takes_all_places
    thawed_activities_do_not_interrupt_each_other
    the_2010_paper_stops_on_an_emergency
    the_2010_paper_takes_one_transition_a_period
    the_2011_paper_runs_as_the_2010_one_does
    the_newest_of_several_waiting_for_a_stop_wins
    two_places_that_meet_become_one
    what_a_port_returns_is_an_exception_its_service_must_declare
    what_cannot_be_resumed_is_told_with_the_reason
    what_ran_and_what_ended_before_a_freeze_stays_so
}

#[test]
fn every_scenario_file_is_played() {
    for entry in std::fs::read_dir(directory()).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|extension| extension == "txt") {
            let name = path.file_stem().unwrap().to_str().unwrap();
            assert!(ALL.contains(&name), "{name}.txt is not in the list");
        }
    }
}
