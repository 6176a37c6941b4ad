//! The demo component with its codels in Rust: the `.gen` file is that of `components/demo`.
//!
//! `requests` holds the codels of the control task, `motion` those of task `main`.

#![forbid(unsafe_code)]

mod limits;
mod motion;
mod requests;
mod types;

genom::component! {
    description: "../../demo/demo.gen",
    codels: [
        motion::demo_init,
        motion::demo_begin,
        motion::demo_servo,
        motion::demo_brake,
        motion::demo_halt,
        requests::demo_check_velocity,
        requests::demo_check_goal,
        requests::demo_reset,
    ],
    exceptions: [types::OutOfRange, types::Moving, types::Halted],
}
