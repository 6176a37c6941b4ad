//! Deployment files.

mod applied;
mod cameras;
mod compared;
mod configs;
mod files;
mod pipeline;
mod quadrotor;
mod robot;
mod roll_back;
mod simulated;
