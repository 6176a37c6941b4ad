//! Codels of picker.

use genom::{Context, Event, Thrown, event};

genom::remote! {
    /// Service `grasp` of interface `hand`.
    struct Grasp(width: &mut f64);
}

/// Task `work` begins.
#[genom::codel]
fn picker_begin(picked: &mut u32) -> Event {
    *picked = 0;
    event!("::picker::ether")
}

/// Activity `pick`: the call lasts until the gripper holds something. What the gripper throws ends
/// the activity.
#[genom::codel]
fn picker_grasp(grasp: &mut Grasp, width: &mut f64, context: &Context) -> Result<Event, Thrown> {
    grasp.call(width, context)?;
    Ok(event!("::picker::count"))
}

/// Activity `pick`, when the gripper holds something.
#[genom::codel]
fn picker_count(picked: &mut u32) -> Event {
    *picked += 1;
    event!("::picker::ether")
}

/// Activity `pick`, asked to stop.
#[genom::codel]
fn picker_stop() -> Event {
    event!("::picker::ether")
}

genom::component! {
    description: "picker.gen",
    codels: [picker_begin, picker_grasp, picker_count, picker_stop],
}
