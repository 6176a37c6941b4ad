//! The demo in C and the demo in Rust behave the same, codel by codel.

#![allow(clippy::unwrap_used, missing_docs, unreachable_pub, reason = "it is a test")]

mod demo;

use demo::{Demo, State};
use genom_components::{Paths, Purpose, build};

/// Runs a scenario on both demos, and compares the results bit by bit.
fn both<R: PartialEq + std::fmt::Debug>(scenario: impl Fn(Demo) -> R) -> R {
    let paths = Paths::of_workspace().unwrap();
    let [c, rust] = ["demo", "demo-rs"].map(|name| {
        let (demo, event) = Demo::start(&build(&paths, name, Purpose::Test).unwrap().library);
        assert_eq!(event, "::demo::ether", "{name}");
        scenario(demo)
    });
    assert_eq!(c, rust);
    c
}

/// Calls the servo until it yields something other than `pause::main`.
fn drive(demo: &mut Demo, goal: f64) -> (Vec<State>, &'static str) {
    let mut path = Vec::new();
    loop {
        let event = demo.servo(goal);
        path.push(Demo::published().0);
        if event != "::demo::pause::main" {
            return (path, event);
        }
        assert!(path.len() < 100_000, "the servo never arrives");
    }
}

#[test]
fn the_servo_ends_exactly_at_the_goal_within_its_limits() {
    for goal in [1.0, -2.5, 1e-9, 0.0] {
        let (path, event) = both(|mut demo| {
            assert_eq!(demo.begin(), "::demo::main");
            drive(&mut demo, goal)
        });
        assert_eq!(event, "::demo::ether");
        assert_eq!(path.last(), Some(&State { position: goal, velocity: 0.0 }));
        let mut before = State::default();
        for state in path {
            assert!(state.velocity.abs() <= 0.5, "{state:?}");
            assert!(state.velocity.abs() - before.velocity.abs() <= 2.0 * 0.005 + 1e-12);
            assert!((goal - state.position).abs() <= (goal - before.position).abs());
            before = state;
        }
    }
}

#[test]
fn the_gain_scales_the_speed_and_zero_stands_still() {
    let fastest = |gain| {
        let (path, _) = both(|mut demo| {
            Demo::set_gain(gain);
            demo.begin();
            drive(&mut demo, 3.0)
        });
        path.iter().map(|state| state.velocity).fold(0.0, f64::max)
    };
    assert_eq!(fastest(None), 0.5);
    assert_eq!(fastest(Some(0.5)), 0.25);
    assert_eq!(fastest(Some(100.0)), 2.0, "the axis has a limit of its own");

    for gain in [0.0, -3.0, f64::NAN] {
        let still = both(|mut demo| {
            Demo::set_gain(Some(gain));
            (demo.servo(1.0), demo.servo(1.0), demo.ids.current)
        });
        let pause = "::demo::pause::main";
        assert_eq!(still, (pause, pause, State::default()), "gain {gain}");
    }
}

#[test]
fn braking_takes_several_periods_and_ends_at_rest() {
    let (path, event) = both(|mut demo| {
        (0..100).for_each(|_| assert_eq!(demo.servo(-5.0), "::demo::pause::main"));
        let mut path = vec![demo.ids.current];
        loop {
            let event = demo.brake();
            path.push(Demo::published().0);
            if event != "::demo::pause::stop" {
                return (path, event);
            }
        }
    });
    assert_eq!(event, "::demo::ether");
    assert!(path.len() > 40, "from 0.5 m/s at 2 m/s^2 takes 50 periods, not {}", path.len());
    assert!(path.windows(2).all(|pair| pair[1].velocity.abs() < pair[0].velocity.abs()));
    assert_eq!(path.last().unwrap().velocity, 0.0);
}

#[test]
fn an_emergency_halts_at_once_and_the_motion_ends_with_an_exception() {
    let (event, rest, end, again) = both(|mut demo| {
        (0..100).for_each(|_| assert_eq!(demo.servo(5.0), "::demo::pause::main"));
        let event = demo.halt();
        let rest = demo.ids.current;
        let end = demo.servo(5.0);
        assert_eq!(demo.ids.current, rest, "nothing moves after the halt");
        demo.begin();
        (event, rest, end, demo.servo(5.0))
    });
    assert_eq!((event, rest.velocity), ("::demo::ether", 0.0));
    assert_eq!((end, again), ("::demo::HALTED", "::demo::pause::main"));
}

#[test]
fn requests_out_of_range_are_refused_with_their_limits() {
    let seen = both(|demo| {
        assert_eq!(demo.check_velocity(0.0), "");
        assert_eq!(demo.check_velocity(2.0), "");
        assert_eq!(demo.check_goal(-10.0), "");
        let fast = (demo.check_velocity(2.1), Demo::detail());
        let far = (demo.check_goal(11.0), Demo::detail());
        (fast, far, demo.check_goal(f64::NAN), demo.check_velocity(f64::NAN))
    });
    let refused = "::demo::OUT_OF_RANGE";
    let limits = ((refused, [2.1, 0.0, 2.0]), (refused, [11.0, -10.0, 10.0]), refused, refused);
    assert_eq!(seen, limits);
}

#[test]
fn reset_moves_the_origin_only_at_rest() {
    let seen = both(|mut demo| {
        demo.servo(1.0);
        let moving = (demo.reset(), demo.ids.current.position > 0.0);
        while demo.brake() != "::demo::ether" {}
        (moving, demo.reset(), demo.ids.current)
    });
    assert_eq!(seen, (("::demo::MOVING", true), "", State::default()));
}

#[test]
fn each_step_publishes_once() {
    let count = both(|mut demo| {
        let before = Demo::published().1;
        demo.servo(1.0);
        demo.brake();
        demo.halt();
        Demo::published().1 - before
    });
    assert_eq!(count, 3);
}
