//! `genomctl step`: advances the virtual clock of a daemon.

use genom_protocol::{Clock, StepRequest, routes};

use crate::failure::Failure;
use crate::session::Session;

/// Advance the virtual clock (`genomd --clock virtual`), and run everything that is due in that
/// time.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// How far: 10ms, 2s, 500us, 100ns. 0s runs what is due now.
    #[arg(value_parser = nanoseconds)]
    duration: u64,
}

pub(super) async fn run(args: Args, session: &Session) -> Result<(), Failure> {
    let reply = session.send(routes::step(), &StepRequest { nanoseconds: args.duration }).await?;
    session.show(&reply, |Clock { now, .. }| {
        format!("{}.{:09} s\n", now / 1_000_000_000, now % 1_000_000_000)
    })
}

/// A whole number with a unit.
fn nanoseconds(text: &str) -> Result<u64, String> {
    let digits = text.find(|c: char| !c.is_ascii_digit()).unwrap_or(text.len());
    let (number, unit) = text.split_at(digits);
    let scale = match unit {
        "ns" => 1,
        "us" => 1_000,
        "ms" => 1_000_000,
        "s" => 1_000_000_000,
        "" => return Err("a unit is missing: s, ms, us or ns".to_owned()),
        other => return Err(format!("unknown unit `{other}`: s, ms, us or ns")),
    };
    let number = number.parse::<u64>().map_err(|_| "a whole number is wanted".to_owned())?;
    number.checked_mul(scale).ok_or_else(|| "too long".to_owned())
}

#[cfg(test)]
mod tests {
    use super::nanoseconds;

    #[test]
    fn durations_have_units() {
        assert_eq!(nanoseconds("10ms"), Ok(10_000_000));
        assert_eq!(nanoseconds("0s"), Ok(0));
        for wrong in ["10", "ms", "1.5s", "3h", "99999999999999999999s", "18446744073709551615s"] {
            assert!(nanoseconds(wrong).is_err(), "{wrong}");
        }
    }
}
