//! Daemons together with foreign programs on the same middleware.

mod cold_starts;
mod forged;
mod lifecycle;
mod plugins;
mod ros2_peers;
mod simulated_time;
mod stalled;
mod typed_iceoryx2;
