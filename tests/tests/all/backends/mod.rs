//! Daemons together with foreign programs on the same middleware.

mod cdr;
mod cold_starts;
mod container;
mod forged;
mod hiroz;
mod lifecycle;
mod over_zenoh;
mod plugins;
mod remapped;
mod ros2_peers;
mod simulated_time;
mod stalled;
mod typed_iceoryx2;
mod zenoh_doctor;
mod zenoh_node;
