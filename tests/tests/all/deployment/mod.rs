//! Files that say what is to run.

mod applied;
mod configs;
mod files;
mod robot;
mod roll_back;
