//! Codels of component `viewer`: they write images to files, and count what arrives.

#![forbid(unsafe_code)]

mod album;
mod ids;
mod picture;
mod types;

use std::ffi::CStr;
use std::path::{Path, PathBuf};

use album::Album;
use genom::{Context, Event, Exception, InPort, Native, OutPort, Thrown, event};
use ids::Ids;
use images::Frame;
use types::{CannotWrite, Dates, Summary};

const ETHER: Event = event!("::viewer::ether");
const MAIN: Event = event!("::viewer::main");
const PAUSE_MAIN: Event = event!("::viewer::pause::main");
const PAUSE_START: Event = event!("::viewer::pause::start");

genom::component! {
    description: "../viewer.gen",
    codels: [
        viewer_init,
        viewer_close,
        viewer_open,
        viewer_look,
        viewer_rest,
        viewer_sheet,
    ],
    exceptions: [CannotWrite],
}

/// Permanent activity of task `main`, state `start`.
#[genom::codel]
fn viewer_init(ids: &mut Ids) -> Event {
    ids.seen = Summary::default();
    ETHER
}

/// Permanent activity of task `main`, state `stop`.
#[genom::codel]
fn viewer_close(album: &mut Native<Album>) -> Event {
    album.take();
    ETHER
}

/// Activity `watch`, state `start`: makes the directory.
#[genom::codel]
fn viewer_open(
    directory: &CStr,
    album: &mut Native<Album>,
    seen: &mut Summary,
    context: &Context,
) -> Result<Event, Thrown> {
    let directory = path(directory);
    if let Err(error) = std::fs::create_dir_all(&directory) {
        return Err(CannotWrite::new(&directory, &error).raise(context));
    }
    album.set(Album::default());
    *seen = Summary::default();
    Ok(MAIN)
}

/// Activity `watch`, state `main`: writes every n-th image of each port, and reports each new
/// disparity image.
#[genom::codel]
#[allow(clippy::too_many_arguments, reason = "the arguments of the .gen file")]
fn viewer_look(
    directory: &CStr,
    every: u32,
    images: u32,
    left: &mut InPort<Frame>,
    rectified: &mut InPort<Frame>,
    disparity: &mut InPort<Frame>,
    album: &mut Native<Album>,
    seen: &mut Summary,
    report: &mut OutPort<Summary>,
    context: &Context,
) -> Result<Event, Thrown> {
    // After `genomctl thaw` there is none: it is known to codels only.
    if album.get().is_none() {
        album.set(Album::default());
    }
    let Some(album) = album.get_mut() else { return Ok(PAUSE_MAIN) };
    let directory = path(directory);
    let disparity = disparity.latest(context);
    let ports = [
        ("left.png", left.latest(context), &mut album.left),
        ("rectified.png", rectified.latest(context), &mut album.rectified),
        ("disparity.png", disparity, &mut album.disparity),
    ];
    for (name, frame, page) in ports {
        let Some(frame) = frame else { continue };
        if page.turn(frame.stamp) && page.is_due(every) {
            let file = directory.join(name);
            picture::write(frame, &file)
                .map_err(|error| CannotWrite::new(&file, &error).raise(context))?;
        }
    }
    seen.last = Dates {
        left: album.left.last(),
        rectified: album.rectified.last(),
        disparity: album.disparity.last(),
    };
    if let Some(disparity) = disparity
        && album.disparity.count() != seen.images
    {
        album.report(disparity, seen);
        report.publish(*seen, context)?;
    }
    Ok(if images > 0 && seen.images >= images { ETHER } else { PAUSE_MAIN })
}

/// Activities `watch` and `sheet`, state `stop`.
#[genom::codel]
fn viewer_rest() -> Event {
    ETHER
}

/// Activity `sheet`: writes what the ports hold, once all of them hold something.
#[genom::codel]
fn viewer_sheet(
    file: &CStr,
    left: &mut InPort<Frame>,
    rectified: &mut InPort<Frame>,
    disparity: &mut InPort<Frame>,
    context: &Context,
) -> Result<Event, Thrown> {
    let (Some(left), Some(rectified), Some(disparity)) =
        (left.latest(context), rectified.latest(context), disparity.latest(context))
    else {
        return Ok(PAUSE_START);
    };
    let file = path(file);
    match picture::write_sheet([left, rectified], disparity, &file) {
        Ok(()) => Ok(ETHER),
        Err(error) => Err(CannotWrite::new(&file, &error).raise(context)),
    }
}

fn path(text: &CStr) -> PathBuf {
    Path::new(&*text.to_string_lossy()).to_owned()
}
