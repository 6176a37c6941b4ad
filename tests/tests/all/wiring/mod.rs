//! Ports and services that are tied together, and moved between middlewares.

mod connect_port;
mod moves;
mod one_binary;
mod services;
mod twins;
mod two_daemons;
