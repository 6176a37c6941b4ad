//! The command line that measures one bare middleware: `genomctl bench` starts it.
//!
//! `genomd --floor MIDDLEWARE DIRECTORY BYTES PERIOD_NS VALUES` prints one line of JSON. It ends
//! early when its standard input does, so that it outlives nobody who started it.

use std::ffi::OsString;
use std::hint::black_box;
use std::io::{self, Read as _, Write as _};
use std::path::Path;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;

use serde_json::json;

use crate::bare;
use crate::clock;
use crate::error::FloorError;
use crate::figures::Figures;
use crate::pair::{Hops, Reader, serve};

/// The argument that makes the program do this.
const WORD: &str = "--floor";
/// The same, for the reading process.
const READER: &str = "--floor-reader";

/// Measures a bare middleware if the command line says so, and returns the exit status; `None` if
/// it does not.
pub fn asked() -> Option<ExitCode> {
    let words: Vec<OsString> = std::env::args_os().skip(1).take(6).collect();
    let words: Vec<&str> = words.iter().map(|word| word.to_str().unwrap_or_default()).collect();
    let done = match words[..] {
        [WORD, name, place, bytes, period, values] => {
            let numbers = [bytes, period, values].map(str::parse);
            match numbers {
                [Ok(bytes), Ok(period), Ok(values)] => {
                    write(name, Path::new(place), bytes, period, values)
                }
                _ => Err(FloorError::Usage),
            }
        }
        [READER, name, place] => read(name, Path::new(place)),
        [WORD | READER, ..] => Err(FloorError::Usage),
        _ => return None,
    };
    Some(match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            // A closed pipe is not a failure.
            let _ = writeln!(io::stderr().lock(), "{error}");
            ExitCode::FAILURE
        }
    })
}

fn read(name: &str, place: &Path) -> Result<(), FloorError> {
    let bare = bare::open(name, place, true)?.ok_or(FloorError::Usage)?;
    serve(|bytes| Ok(vec![bare.reader(bytes)?]))
}

fn write(name: &str, place: &Path, bytes: u64, period: u64, values: u64) -> Result<(), FloorError> {
    let number = |number| usize::try_from(number).map_err(|_| FloorError::Usage);
    let (bytes, values) = (number(bytes)?, number(values)?);
    let goes_on = until_input_ends()?;
    let hops = if name == "local" {
        copies(bytes, period, values, goes_on)?
    } else {
        let bare = bare::open(name, place, false)?.ok_or(FloorError::Usage)?;
        let mut ends = [bare.writer(bytes)?];
        let mut reader = Reader::start(&[READER, name, &place.to_string_lossy()])?;
        reader.open(bytes)?;
        let measured = reader.measure(&mut ends, values, period, goes_on);
        let finished = reader.finish();
        let hops = measured?.pop().unwrap_or_default();
        finished?;
        hops
    };
    let figures = Figures::of(hops.durations.clone());
    let told = json!({
        "p50_ns": figures.map(|figures| figures.p50), "p99_ns": figures.map(|figures| figures.p99),
        "values": hops.durations.len(), "lost": hops.lost,
    });
    Ok(writeln!(io::stdout().lock(), "{told}")?)
}

/// The floor within a process: what a function call with a value costs that is copied in and out.
fn copies(
    bytes: usize,
    period: u64,
    values: usize,
    goes_on: impl Fn() -> bool,
) -> Result<Hops, FloorError> {
    let (sent, mut between, mut last) = (vec![1; bytes], vec![0_u8; bytes], vec![0; bytes]);
    let mut hops = Hops::default();
    let mut date = clock::now();
    for _ in 0..values {
        if !goes_on() {
            return Err(FloorError::Interrupted);
        }
        date = date.max(clock::now().saturating_sub(period)).saturating_add(period);
        clock::sleep_until(date);
        let begun = clock::now();
        between.copy_from_slice(black_box(&sent));
        last.copy_from_slice(black_box(&between));
        black_box(&mut last);
        hops.durations.push(clock::now().saturating_sub(begun) as f64);
    }
    Ok(hops)
}

/// True until standard input ends.
fn until_input_ends() -> io::Result<impl Fn() -> bool> {
    let open = Arc::new(AtomicBool::new(true));
    let told = Arc::clone(&open);
    thread::Builder::new().name("input".to_owned()).spawn(move || {
        // What comes is of no interest.
        let _ = io::stdin().lock().read_to_end(&mut Vec::new());
        told.store(false, Ordering::Relaxed);
    })?;
    Ok(move || open.load(Ordering::Relaxed))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_within_a_process_are_all_counted_until_it_is_to_end() {
        let hops = copies(4096, 1000, 50, || true).unwrap();
        assert_eq!((hops.durations.len(), hops.lost), (50, 0));
        assert!(matches!(copies(8, 1000, 50, || false), Err(FloorError::Interrupted)));
    }
}
