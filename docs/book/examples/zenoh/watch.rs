//! Watches the demo move with nothing but zenoh: `watch ENDPOINT`.

#![forbid(unsafe_code)]
#![allow(clippy::print_stdout, reason = "it shows what it sees")]

use zenoh::Wait as _;

/// Position in a sample of `::demo::state` in CDR: a header of 4 bytes, then two doubles.
fn position(message: &[u8]) -> Option<f64> {
    Some(f64::from_le_bytes(message.get(4..12)?.try_into().ok()?))
}

fn main() -> zenoh::Result<()> {
    let endpoint = std::env::args().nth(1).unwrap_or_default();
    let mut config = zenoh::Config::default();
    config.insert_json5("mode", "\"client\"")?;
    config.insert_json5("connect/endpoints", &format!("[{endpoint:?}]"))?;
    config.insert_json5("scouting/multicast/enabled", "false")?;
    let session = zenoh::open(config).wait()?;

    let samples = session.declare_subscriber("demo/position").wait()?;
    for reply in session.get("demo/position").wait()? {
        if let Ok(last) = reply.result() {
            println!("at {:?}", position(&last.payload().to_bytes()));
        }
    }
    loop {
        let sample = samples.recv()?;
        if position(&sample.payload().to_bytes()) == Some(0.25) {
            println!("arrived");
            return Ok(());
        }
    }
}
