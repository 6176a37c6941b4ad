//! Watches the demo move with nothing but iceoryx2: `watch PREFIX ROOT`.

#![forbid(unsafe_code)]
#![allow(clippy::print_stdout, reason = "it shows what it sees")]

use std::time::Duration;

use iceoryx2::prelude::*;

/// The type `::demo::state` of the description, in its C layout.
#[derive(Clone, Copy, Debug, ZeroCopySend)]
#[type_name("demo::state")]
#[repr(C)]
struct State {
    position: f64,
    velocity: f64,
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let (prefix, root) =
        (arguments.next().unwrap_or_default(), arguments.next().unwrap_or_default());
    let mut config = Config::default();
    config.global.prefix = FileName::new(prefix.as_bytes())?;
    config.global.set_root_path(&Path::new(root.as_bytes())?);
    let node = NodeBuilder::new().config(&config).create::<ipc::Service>()?;

    let name = ServiceName::new("demo/position")?;
    let port = node.service_builder(&name).publish_subscribe::<State>().open()?;
    let reader = port.subscriber_builder().create()?;
    println!("watching");
    while node.wait(Duration::from_millis(1)).is_ok() {
        while let Some(state) = reader.receive()? {
            if state.position == 0.25 {
                println!("arrived at {} m/s", state.velocity);
                return Ok(());
            }
        }
    }
    Ok(())
}
