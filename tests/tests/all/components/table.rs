//! Each row of the table of faults (`genom_tests::faults`): the effect on the service, whether the
//! demo in the same daemon continues or the next daemon starts, and what is left behind.

use std::path::PathBuf;
use std::process::Command;

use genom_tests::faults::{Fault, Outcome};
use genom_tests::{Daemon, Home, component, path, signal};

/// Whether a daemon has mapped its private copy of a component's library.
fn has_mapped(daemon: &Daemon, component: &str) -> bool {
    let maps = std::fs::read_to_string(format!("/proc/{}/maps", daemon.process().id())).unwrap();
    let name = format!("{component}.so");
    maps.lines().any(|line| line.contains("/genomd-library-") && line.contains(&name))
}

fn demo_moves(daemon: &Daemon) {
    daemon.ctl(&["call", "demo", "goto", "goal=0.01"]).expect_code(0);
}

/// Checks that another daemon can start in the same home.
#[track_caller]
fn next_starts(home: Home) {
    let next = home.start(&[path(&component("demo").library)]);
    demo_moves(&next);
    next.stop("TERM").0.expect_code(0);
}

/// Ends a child process that a codel forked.
fn end_child(said: &str) {
    if let Some(pid) = said.trim().strip_prefix("pid = ") {
        signal(pid, "KILL");
    }
}

#[track_caller]
fn holds(component: &str, service: &str) {
    let fault = Fault::of(component, service);
    let daemon = Daemon::demo("local");
    let seen = fault.provoke(&daemon);
    match fault.outcome {
        Outcome::GoesOn => assert_eq!(seen.code, Some(0), "{seen:?}"),
        Outcome::Exception(name) => {
            assert_eq!(seen.code, Some(1), "{seen:?}");
            assert!(seen.said.contains(name), "{seen:?}");
        }
        Outcome::Stops(code) | Outcome::Ends(Some(code)) => {
            let (ended, home) = daemon.finish();
            ended.expect_code(code).expect_err(fault.told);
            return next_starts(home);
        }
        Outcome::Ends(None) => {
            let (ended, home) = daemon.finish();
            assert_eq!(ended.code, None, "{ended:?}");
            ended.expect_err(fault.told);
            return next_starts(home);
        }
    }
    demo_moves(&daemon);
    assert!(has_mapped(&daemon, component));
    daemon.ctl(&["unload", component]).expect_code(0);
    if !fault.told.is_empty() {
        let told = |line: &str| line.contains(fault.told);
        assert!(daemon.process().error_line_where(told).is_some(), "nothing says {}", fault.told);
    }
    let stays = has_mapped(&daemon, component);
    // Compilers build some C++ libraries so that they are never unmapped.
    if component == "remains" {
        assert_eq!(stays, fault.stays, "whether the library stays mapped");
    }
    demo_moves(&daemon);
    let (stopped, home) = daemon.stop("TERM");
    stopped.expect_code(0);
    next_starts(home);
    end_child(&seen.said);
}

macro_rules! rows {
    ($($name:ident: $component:ident $service:ident;)*) => {
        $(#[test]
        fn $name() {
            holds(stringify!($component), stringify!($service));
        })*

        #[test]
        fn every_row_of_these_components_has_its_test() {
            let tested = [$((stringify!($component), stringify!($service))),*];
            for row in genom_tests::faults::FAULTS {
                let found = tested.contains(&(row.component, row.service));
                assert!(found, "{} {} has no test here", row.component, row.service);
            }
        }
    };
}

rows! {
    a_library_with_a_thread_that_spins_stays_mapped: remains spin;
    a_library_with_a_thread_that_cannot_be_looked_at_stays_mapped: remains spin_masked;
    a_library_with_a_timer_that_calls_it_stays_mapped: remains tick_by_thread;
    a_library_with_a_destructor_for_threads_stays_mapped: remains keep_value;
    what_a_library_does_on_a_signal_ends_with_it: remains handle_signal;
    a_timer_that_signals_outlives_its_library_without_effect: remains tick_by_signal;
    a_child_keeps_neither_lock_nor_socket: remains child;
    a_child_that_returns_from_its_codel_ends: remains child_returns;
    pthread_exit_ends_the_activity_and_not_the_task: leaves exit_thread;
    the_system_call_exit_ends_the_activity_and_not_the_task: leaves exit_thread_by_call;
    a_codel_that_cancels_its_thread_ends_its_activity: leaves cancel_thread;
    pthread_exit_in_a_function_ends_the_function: leaves exit_thread_of_control;
    a_codel_that_calls_underscore_exit_is_named_and_is_no_success: leaves exit_process;
    a_codel_that_ends_the_process_by_a_system_call_is_named: leaves exit_process_by_call;
    a_codel_that_calls_exit_is_named: crashes leave;
    exit_in_a_thread_of_a_library_is_no_success: leaves exit_later;
    a_codel_that_raises_sigterm_is_named_and_is_no_success: leaves terminate;
    a_codel_that_raises_sighup_is_named_and_is_no_success: leaves hang_up;
    a_codel_that_crashes_is_named: crashes segfault;
    a_codel_that_aborts_is_named: crashes abort;
    a_jump_within_a_codel_is_no_fault: leaves jump_within;
    a_pointer_to_nothing_is_no_event: leaves wild;
    a_small_number_is_no_event: leaves small;
    codels_do_not_lower_the_number_of_files: grabs limit_files;
    codels_do_not_lower_the_memory_of_the_process: grabs limit_memory;
    codels_do_not_lower_the_size_of_files: grabs limit_file_size;
    codels_do_not_close_standard_descriptors: grabs close_standard;
    standard_streams_that_codels_close_are_opened_again: grabs close_streams;
    an_alarm_that_nobody_handles_has_no_effect: grabs alarm;
    a_user_signal_that_nobody_handles_has_no_effect: grabs user_signal;
    a_signal_put_back_to_its_default_stays_harmless: grabs default_signal;
    bytes_past_the_ids_end_the_activity: overwrites past_ids;
    bytes_before_the_ids_end_the_activity: overwrites before_ids;
    bytes_past_an_output_end_the_activity: overwrites past_output;
    bytes_past_the_data_of_a_port_end_the_activity: overwrites past_port;
    bytes_past_an_argument_end_the_function: overwrites past_argument;
    what_a_codel_may_write_is_no_fault: overwrites within;
    bytes_past_the_ids_are_found_at_the_end: overwrites past_ids_and_on;
    an_event_that_does_not_exist_ends_its_activity: strays unknown;
    a_cpp_exception_ends_its_function: escapes fail;
}

#[test]
fn a_daemon_that_was_killed_has_a_successor_while_a_child_of_its_codels_lives() {
    let daemon = Daemon::demo("local");
    let said = Fault::of("remains", "child").provoke(&daemon).said;
    let (killed, home) = daemon.stop("KILL");
    assert_eq!(killed.code, None);
    // Nobody answers, and clients notice at once.
    let mut command = Command::new(genom_tests::program("genomctl"));
    command.arg("--socket").arg(home.socket()).arg("list");
    genom_tests::Running::start(&mut command).finish().expect_code(3);
    next_starts(home);
    end_child(&said);
}

/// Descriptors that programs started by this process inherit, except the standard ones.
fn inherited_from(process: &str) -> Vec<PathBuf> {
    let mut inherited = Vec::new();
    for entry in std::fs::read_dir(format!("/proc/{process}/fdinfo")).unwrap().flatten() {
        let number: u32 = entry.file_name().to_str().unwrap().parse().unwrap();
        // A descriptor that is closed meanwhile is not inherited.
        let Ok(told) = std::fs::read_to_string(entry.path()) else { continue };
        let flags = told.lines().find_map(|line| line.strip_prefix("flags:")).unwrap();
        let flags = u32::from_str_radix(flags.trim(), 8).unwrap();
        if number > 2 && flags & 0o2_000_000 == 0 {
            inherited.extend(std::fs::read_link(format!("/proc/{process}/fd/{number}")).ok());
        }
    }
    inherited
}

#[test]
fn programs_that_codels_run_inherit_no_descriptor_of_the_daemon() {
    for backend in ["local", "shm", "zenoh", "ros2"] {
        let daemon = Daemon::demo(backend);
        let mut inherited = inherited_from(&daemon.process().id().to_string());
        // This process itself inherited some from whoever runs the tests.
        let given = inherited_from("self");
        inherited.retain(|file| !given.contains(file));
        assert!(inherited.is_empty(), "{backend}: {inherited:?}");
        daemon.stop("TERM").0.expect_code(0);
    }
}

#[test]
fn no_log_line_comes_to_a_client_after_codels_closed_standard_error() {
    let daemon = Daemon::demo("local");
    daemon.ctl(&["load", path(&component("grabs").library)]).expect_code(0);
    let socket = daemon.home().socket();
    let call = r#"{"inputs":{}}"#;
    for _ in 0..3 {
        let path = "/components/grabs/services/close_streams";
        let _ = genom_tests::request(&socket, "POST", path, call);
        for _ in 0..10 {
            // Each of them is logged.
            let missing =
                genom_tests::request(&socket, "POST", "/components", r#"{"library":"x"}"#);
            assert!(missing.status >= 400);
            let reply = genom_tests::request(&socket, "GET", "/components", "");
            assert_eq!(reply.status, 200);
            assert_eq!(reply.body["components"].as_array().unwrap().len(), 2);
        }
    }
    daemon.stop("TERM").0.expect_code(0);
}

#[test]
fn a_component_whose_codels_wrote_past_their_memory_is_told_and_the_codel_is_found() {
    let damaged = |mode: &str, codel: &str| {
        let home = Home::new().configured(&format!("check_memory = \"{mode}\""));
        let daemon = home.start(&[path(&component("overwrites").library)]);
        let state = || daemon.json(&["list"])["components"][0]["state"].clone();
        assert_eq!(state(), "running");
        let ended = daemon.ctl(&["call", "overwrites", "past_ids_and_on"]);
        ended.expect_code(1).expect_err(&format!("codel {codel} wrote past the end of the ids"));
        ended.expect_err("next to `gains`");
        assert_eq!(state(), "damaged");
        let why = daemon.ctl(&["why", "overwrites/samples"]);
        assert!(why.out.contains("is damaged"), "{why:?}");
        let doctor = daemon.ctl(&["doctor"]);
        assert!(doctor.out.contains("codels of overwrites wrote past"), "{doctor:?}");
        // Nothing else was damaged.
        daemon.ctl(&["call", "overwrites", "within"]).expect_code(0);
        daemon.ctl(&["unload", "overwrites"]).expect_code(0);
        daemon.stop("TERM").0.expect_code(0);
    };
    // The first codel does it and yields without a pause; the second ends the activity.
    damaged("pauses", "overwrites_rest");
    damaged("each-codel", "overwrites_past_ids_and_on");
}

#[test]
fn memory_that_nobody_looks_at_still_harms_nothing_when_it_is_released() {
    let home = Home::new().configured("check_memory = \"off\"");
    let daemon = home.start(&[path(&component("overwrites").library)]);
    for service in ["past_ids", "before_ids", "past_output", "past_port", "past_argument"] {
        daemon.ctl(&["call", "overwrites", service]).expect_code(0);
    }
    daemon.ctl(&["unload", "overwrites"]).expect_code(0);
    let (stopped, _) = daemon.stop("TERM");
    stopped.expect_code(0).expect_err("found when it was unloaded");
}
