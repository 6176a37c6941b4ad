//! Deployment files.

mod applied;
mod configs;
mod files;
mod robot;
mod roll_back;
