//! Deployment files.

mod applied;
mod compared;
mod configs;
mod files;
mod pipeline;
mod robot;
mod roll_back;
mod simulated;
