//! Ports and services that are connected, and that move between middlewares.

mod connect_port;
mod moves;
mod one_binary;
mod over;
mod services;
mod twins;
mod two_daemons;
