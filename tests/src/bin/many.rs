//! Writes the configuration of a daemon with many components, for measurements by hand.
//!
//! `many COUNT BACKEND DIRECTORY [chained]`

#![forbid(unsafe_code)]
#![allow(clippy::print_stdout, clippy::unwrap_used, reason = "a program of the tests")]

use std::path::Path;

use genom_tests::Many;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [count, backend, directory, rest @ ..] = arguments.as_slice() else {
        println!("usage: COUNT BACKEND DIRECTORY [chained]");
        return;
    };
    let directory = Path::new(directory);
    std::fs::create_dir_all(directory).unwrap();
    let many = Many { components: count.parse().unwrap(), chained: !rest.is_empty(), cells: 0 };
    let file = directory.join("genomd.toml");
    std::fs::write(&file, many.configuration(backend, directory)).unwrap();
    println!("genomd --config {}", file.display());
}
