//! The papers' pipeline as `configs/pipeline.toml` deploys it: camera, stereo and viewer, with a
//! scene of which everything is known.

use std::fs;

use genom_tests::{Daemon, Home, component, path, repository, until};
use image::GrayImage;
use serde_json::{Value, json};

/// Text of a file with one piece of it replaced, which must be there once.
#[track_caller]
fn with(text: &str, from: &str, to: &str) -> String {
    assert_eq!(text.matches(from).count(), 1, "{from} in {text}");
    text.replacen(from, to, 1)
}

/// The deployment as it is, with its components where the tests have them, so many images, and
/// each of them written.
fn deployment(images: u32) -> String {
    let file = repository().join("configs/pipeline.toml");
    let text = fs::read_to_string(file).unwrap().replace(
        "\"../target/components/",
        &format!("\"{}/", path(component("camera").library.parent().unwrap().parent().unwrap())),
    );
    for name in ["stereo", "viewer"] {
        let _ = component(name);
    }
    let text = with(&text, "every = 10", "every = 1");
    let (start, capture) = text.split_once("component = \"camera\"").expect("it is started");
    format!(
        "{start}component = \"camera\"{}",
        with(capture, "images = 0", &format!("images = {images}"))
    )
}

/// The pictures that the viewer wrote, and what it reported of the last one.
struct Seen {
    files: [Vec<u8>; 3],
    report: Value,
}

impl Seen {
    /// Waits for the last of this many images, at 10 Hz.
    fn from(daemon: &Daemon, images: u32) -> Self {
        let nanosec = (images - 1) * 100_000_000;
        let last = json!({"sec": nanosec / 1_000_000_000, "nanosec": nanosec % 1_000_000_000});
        let dates = json!({"left": last, "rectified": last, "disparity": last});
        let mut report = Value::Null;
        until("the last image arrives", || {
            // While the viewer writes files it may be held up, which refuses the request.
            let reply = daemon.ctl(&["--json", "call", "viewer", "get_report"]);
            let reply: Value = serde_json::from_str(&reply.out).unwrap_or_default();
            report = reply["result"]["seen"].clone();
            report["last"] == dates
        });
        let files = ["left", "rectified", "disparity"].map(|name| {
            let file = daemon.home().path().join("pictures").join(name).with_extension("png");
            fs::read(file).expect("it is written")
        });
        Self { files, report }
    }

    fn image(&self, at: usize) -> GrayImage {
        image::load_from_memory(&self.files[at]).expect("it is a PNG file").into_luma8()
    }
}

/// Only the line with the middleware of the file is different.
#[test]
fn the_same_images_come_out_on_every_middleware() {
    let mut all = Vec::new();
    for backend in ["local", "shm", "zenoh", "ros2"] {
        let text = with(&deployment(5), "backend = \"shm\"", &format!("backend = {backend:?}"));
        let daemon = Home::new().configured(&text).start(&[]);
        all.push((backend, Seen::from(&daemon, 5)));
        daemon.stop("TERM").0.expect_code(0);
    }
    let (_, first) = &all[0];
    for (backend, seen) in &all {
        assert!(seen.files == first.files, "{backend}: the pictures differ");
        for key in ["disparity", "known", "last"] {
            assert_eq!(seen.report[key], first.report[key], "{backend}: {key}");
        }
    }
}

/// Runs the pipeline on a stepped clock for 2 s, in which it takes ten images: the last at 0.9 s.
fn stepped(change: impl Fn(&str) -> String) -> (Daemon, Seen) {
    let text = with(&deployment(10), "backend = \"shm\"", "backend = \"local\"");
    let daemon = Home::new().configured(&change(&text)).start(&["--clock", "virtual"]);
    let deployed = daemon.process().error_line_where(|line| line.contains("deployed:"));
    assert!(deployed.is_some(), "the daemon ended");
    daemon.ctl(&["step", "2s"]).expect_code(0);
    let seen = Seen::from(&daemon, 10);
    (daemon, seen)
}

/// How far the point that is seen at a pixel of the rectified left image moves, px; none where two
/// surfaces meet within a block, and where a lens does not see it. The numbers are those of
/// `components/camera`.
fn disparity(u: f64, v: f64, date: f64) -> Option<f64> {
    let moved = |depth: f64| 500.0 * 0.12 / depth;
    let board = 319.5 + 500.0 / 1.5 * 0.35 * (std::f64::consts::TAU * date / 8.0).sin();
    let half = 500.0 / 1.5 * 0.25;
    let outside = (u - board).abs().max((v - 239.5).abs()) - half;
    if outside < -12.0 {
        return Some(moved(1.5));
    }
    // To the left of the board is what the right lens does not see.
    let hidden = u < board && outside < 40.0;
    let edge = u < 70.0 || !(8.0..632.0).contains(&u) || !(8.0..472.0).contains(&v);
    if outside < 12.0 || hidden || edge {
        return None;
    }
    match v - 239.5 {
        // The floor is 0.6 m below, the wall 3 m away: they meet 100 px below the middle.
        below if below > 108.0 => Some(moved(500.0 * 0.6 / below)),
        below if below < 92.0 => Some(moved(3.0)),
        _ => None,
    }
}

#[test]
fn disparities_are_those_of_the_scene_and_nothing_is_lost_on_a_stepped_clock() {
    let (daemon, seen) = stepped(str::to_owned);
    assert_eq!((&seen.report["images"], &seen.report["rate"]), (&json!(10), &json!(10.0)));
    let (mut all, mut known, mut right) = (0, 0, 0);
    for (u, v, pixel) in seen.image(2).enumerate_pixels() {
        let Some(wanted) = disparity(u.into(), v.into(), 0.9) else { continue };
        let found = f64::from(pixel.0[0]) / 4.0;
        all += 1;
        known += u32::from(found > 0.0);
        right += u32::from((found - wanted).abs() <= 0.5);
    }
    println!("{all} pixels: {known} known, {right} within half a pixel");
    assert!(known * 100 > all * 95, "{known} of {all} pixels are known");
    assert!(right * 100 > known * 97, "{right} of {known} pixels are within half a pixel");
    // The same again, byte by byte.
    drop(daemon);
    assert!(stepped(str::to_owned).1.files == seen.files);
}

/// Mean difference of two images, without a margin.
fn difference(one: &GrayImage, other: &GrayImage) -> f64 {
    let (width, height) = one.dimensions();
    let inside = (20..height - 20).flat_map(|v| (20..width - 20).map(move |u| (u, v)));
    let differences =
        inside.map(|(u, v)| one.get_pixel(u, v).0[0].abs_diff(other.get_pixel(u, v).0[0]));
    let (sum, count) = differences
        .fold((0.0, 0), |(sum, count), difference| (sum + f64::from(difference), count + 1));
    sum / f64::from(count)
}

#[test]
fn the_rectified_image_is_what_a_pinhole_camera_takes() {
    let (_, seen) = stepped(str::to_owned);
    let pinhole = "{ k1 = 0.0, k2 = 0.0 }";
    let rate = "set_rate = { rate = 10.0 }";
    let lenses =
        format!("{rate}\nset_distortion = {{ left_lens = {pinhole}, right_lens = {pinhole} }}\n#");
    let (_, ideal) = stepped(|text| with(text, rate, &lenses));
    let rectified = difference(&seen.image(1), &ideal.image(0));
    let distorted = difference(&seen.image(0), &ideal.image(0));
    println!("{rectified:.2} grey values, {distorted:.2} without rectification");
    assert!(rectified * 5.0 < distorted, "{rectified} is not much less than {distorted}");
    // With a pinhole there is nothing to rectify.
    assert_eq!(difference(&ideal.image(1), &ideal.image(0)), 0.0);
}

/// `UPDATE_EXPECT=1` writes the picture.
#[test]
fn the_picture_of_the_page_is_what_the_viewer_writes() {
    let (daemon, _) = stepped(str::to_owned);
    let sheet = daemon.json(&["start", "viewer", "sheet", "file=sheet.png"]);
    daemon.ctl(&["step", "100ms"]).expect_code(0);
    daemon.ctl(&["wait", "viewer", &sheet["activity"].to_string()]).expect_code(0);
    let made = fs::read(daemon.home().path().join("sheet.png")).unwrap();
    let page = repository().join("docs/pipeline.png");
    if std::env::var_os("UPDATE_EXPECT").is_some() {
        fs::write(&page, &made).unwrap();
    }
    let [made, shown] = [made, fs::read(page).unwrap()]
        .map(|file| image::load_from_memory(&file).expect("it is a PNG file").into_luma8());
    assert_eq!(made.dimensions(), shown.dimensions());
    // Other processors may round otherwise.
    let differs = difference(&made, &shown);
    assert!(differs < 0.5, "{differs} grey values");
}
