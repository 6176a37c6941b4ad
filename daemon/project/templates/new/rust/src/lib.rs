//! Component %NAME%: what genomd loads.

mod codels;
mod types;

genom::component! {
    description: "../%NAME%.gen",
    codels: [
        codels::%NAME%_check_speed,
        codels::%NAME%_begin,
        codels::%NAME%_show,
        codels::%NAME%_step,
        codels::%NAME%_halt,
    ],
    exceptions: [types::OutOfRange],
}
