//! Codels of component `stereo`: they rectify images and compare them.
//!
//! `lens` has the model of the lenses, `rectify` the images without distortion, `matching` the
//! disparities.

#![forbid(unsafe_code)]

mod engine;
mod lens;
mod matching;
mod rectify;
mod types;

use engine::{Engine, Pair};
use genom::{Context, Event, Exception, InPort, Native, OutPort, Thrown, event};
use images::{Frame, Rig};
use types::{BadBlock, BadEncoding, BadSize, Ids};

const ETHER: Event = event!("::stereo::ether");
const MAIN: Event = event!("::stereo::main");
const PAUSE_MAIN: Event = event!("::stereo::pause::main");

genom::component! {
    description: "../stereo.gen",
    codels: [
        stereo_init,
        stereo_close,
        stereo_check_block,
        stereo_begin,
        stereo_compare,
        stereo_rest,
    ],
    exceptions: [BadSize, BadEncoding, BadBlock],
}

/// Permanent activity of task `main`, state `start`.
#[genom::codel]
fn stereo_init(ids: &mut Ids) -> Event {
    ids.block = 9;
    ETHER
}

/// Permanent activity of task `main`, state `stop`.
#[genom::codel]
fn stereo_close(engine: &mut Native<Engine>) -> Event {
    engine.take();
    ETHER
}

/// Validation codel of attribute `set_block`.
#[genom::codel]
fn stereo_check_block(block: u32, context: &Context) -> Result<(), Thrown> {
    if matching::SIDES.contains(&block) {
        return Ok(());
    }
    Err(BadBlock { side: block }.raise(context))
}

/// Activity `correlate`, state `start`. Images of dates that were seen before count as new.
#[genom::codel]
fn stereo_begin(engine: &mut Native<Engine>, done: &mut u32) -> Event {
    engine.take();
    *done = 0;
    MAIN
}

/// Activity `correlate`, state `main`: compares two images once there are two of the same date.
#[genom::codel]
#[allow(clippy::too_many_arguments, reason = "the arguments of the .gen file")]
fn stereo_compare(
    images: u32,
    block: u32,
    left: &mut InPort<Frame>,
    right: &mut InPort<Frame>,
    calibration: &mut InPort<Rig>,
    engine: &mut Native<Engine>,
    done: &mut u32,
    rectified: &mut OutPort<Frame>,
    disparity: &mut OutPort<Frame>,
    context: &Context,
) -> Result<Event, Thrown> {
    let (Some(rig), Some(left), Some(right)) =
        (calibration.latest(context), left.latest(context), right.latest(context))
    else {
        return Ok(PAUSE_MAIN);
    };
    let before = engine.get().and_then(Engine::last);
    // One image of a pair may arrive before the other.
    if left.stamp != right.stamp || before == Some(left.stamp) {
        return Ok(PAUSE_MAIN);
    }
    let pair = Pair {
        left: checked("left", left, rig, context)?,
        right: checked("right", right, rig, context)?,
    };
    let size = (rig.width, rig.height);
    if engine.get().is_none_or(|engine| engine.rig() != rig) {
        engine.set(Engine::new(rig));
    }
    let Some(engine) = engine.get_mut() else { return Ok(PAUSE_MAIN) };
    let stamp = left.stamp;
    let seen = engine.compare(stamp, &pair, block);
    for (port, pixels) in [(rectified, seen.rectified), (disparity, seen.disparity)] {
        if let Some(Err(bytes)) =
            port.data(context).map(|image| image.set(stamp, "left", size, pixels))
        {
            return Err(BadSize::new("calibration", size, bytes, size).raise(context));
        }
        port.write(context)?;
    }
    *done = done.saturating_add(1);
    Ok(if *done == images { ETHER } else { PAUSE_MAIN })
}

/// Activity `correlate`, state `stop`.
#[genom::codel]
fn stereo_rest() -> Event {
    ETHER
}

/// The pixels of an image that fits the calibration.
fn checked<'f>(
    port: &str,
    image: &'f Frame,
    rig: &Rig,
    context: &Context,
) -> Result<&'f [u8], Thrown> {
    if !image.is_mono8() {
        return Err(BadEncoding::new(port, image.encoding).raise(context));
    }
    let (size, expected) = ((image.width, image.height), (rig.width, rig.height));
    match image.pixels() {
        Some(pixels) if size == expected && !pixels.is_empty() => Ok(pixels),
        _ => Err(BadSize::new(port, size, image.data.len(), expected).raise(context)),
    }
}
