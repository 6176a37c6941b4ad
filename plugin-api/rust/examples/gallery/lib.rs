//! A component that uses every kind of parameter that codels in Rust can have.

#![forbid(unsafe_code)]

use std::ffi::CStr;

use genom::{
    Bool, BoundedSequence, BoundedString, Context, Data, Enum, Event, Exception, InPort,
    MultipleInPort, MultipleOutPort, Native, NativeType, Optional, OutPort, Sequence, Text, Thrown,
    event,
};

const ETHER: Event = event!("::gallery::ether");

#[derive(Clone, Copy, Data)]
#[genom(name = "::planner::point")]
#[repr(C)]
struct Point {
    x: f64,
    y: f64,
}

#[derive(Clone, Copy, Debug, Data)]
#[genom(name = "::gallery::colour")]
#[allow(clippy::upper_case_acronyms, reason = "the names of the .gen file")]
enum Colour {
    RED,
    GREEN,
}

#[derive(Clone, Data)]
#[genom(name = "::gallery::sample")]
#[repr(C)]
struct Sample {
    valid: Bool,
    raw: [u8; 4],
    colour: Enum<Colour>,
    name: Text,
    tag: BoundedString<16>,
    points: Sequence<Point>,
    recent: BoundedSequence<i32, 8>,
    weight: Optional<f32>,
    grid: [[i16; 3]; 2],
}

/// Known to codels only.
#[derive(NativeType)]
#[genom(name = "::gallery::engine")]
struct Engine {
    origin: Point,
}

#[derive(Clone, Copy, Exception)]
#[genom(name = "::gallery::FULL")]
struct Full;

#[derive(Clone, Copy, Exception)]
#[genom(name = "::planner::NO_PATH")]
#[repr(C)]
struct NoPath {
    why: BoundedString<64>,
}

genom::remote! {
    /// Service `plan` of interface `planner`.
    struct Plan(range: f64, name: &CStr, from: &Point, path: &mut Sequence<Point>);
}

#[genom::codel]
fn gallery_start(engine: &mut Native<Engine>) -> Event {
    engine.set(Engine { origin: Point { x: 0.5, y: -0.5 } });
    ETHER
}

#[genom::codel]
fn gallery_stop(engine: &mut Native<Engine>) -> Event {
    engine.take();
    ETHER
}

#[genom::codel]
fn gallery_describe(
    name: &CStr,
    colour: Enum<Colour>,
    valid: bool,
    numbers: &Sequence<i32>,
    weight: &Optional<f32>,
    text: &mut Text,
) {
    let name = name.to_string_lossy();
    text.set(&format!("{name} {colour:?} {valid} {numbers:?} {weight:?}"));
}

#[genom::codel]
fn gallery_remember(
    number: i32,
    recent: &mut BoundedSequence<i32, 8>,
    context: &Context,
) -> Result<(), Thrown> {
    recent.push(number).map_err(|_| Full.raise(context))
}

#[genom::codel]
fn gallery_find(
    range: f64,
    engine: &Native<Engine>,
    plan: &mut Plan,
    sample: &mut Sample,
    output: &mut OutPort<Sample>,
    context: &Context,
) -> Result<Event, Thrown> {
    let Some(engine) = engine.get() else {
        return Err(NoPath { why: BoundedString::new("there is no engine") }.raise(context));
    };
    sample.name.set("path");
    plan.call(range, c"path", &engine.origin, &mut sample.points, context)?;
    sample.valid.set(true);
    output.publish(sample.clone(), context)?;
    Ok(ETHER)
}

#[genom::codel]
fn gallery_relay(
    input: &mut InPort<Sample>,
    output: &mut OutPort<Sample>,
    inputs: &mut MultipleInPort<Sample>,
    outputs: &mut MultipleOutPort<Sample>,
    count: &mut u32,
    context: &Context,
) -> Result<Event, Thrown> {
    if let Some(sample) = input.latest(context) {
        output.publish(sample.clone(), context)?;
        *count += 1;
    }
    for side in [c"left", c"right"] {
        if inputs.read(side, context).is_err() {
            continue;
        }
        let Some(sample) = inputs.data(side, context) else { continue };
        outputs.open(side, context)?;
        if let Some(copy) = outputs.data(side, context) {
            copy.clone_from(sample);
        }
        outputs.write(side, context)?;
        *count += 1;
    }
    Ok(ETHER)
}

genom::component! {
    description: "gallery.gen",
    codels: [
        gallery_start,
        gallery_stop,
        gallery_describe,
        gallery_remember,
        gallery_find,
        gallery_relay,
    ],
    exceptions: [Full, NoPath],
}
