//! Unsafe code stays in the crates that need it.

use std::fs;

use genom_tests::repository;

/// Crates that may contain unsafe code.
const UNSAFE: &[&str] = &[
    "genom-blackbox",
    "genom-types",
    "genom-host",
    "genom-local",
    "genom-kit",
    "genom-rtps-guard",
    "genom-shm",
    // Middlewares in libraries of their own: the table, and its two sides.
    "genom-plugin-abi",
    "genom-plugin-host",
    "genom-plugin",
    // Exporting the table needs an unsafe attribute.
    "genom-plugin-zenoh",
    "genomd-yarp",
    "genom",
    "genom-allocations",
    // What runners call, and what that for Lua does with it, in one module each.
    "genom-runner",
    "genom-lua",
    // Memory that a daemon has with its program, or with a cell, in one module each; and what C calls.
    "genom-lockstep",
    "genom-client",
    "genom-client-c",
    // It traces daemons, in one module.
    "genom-tests",
];

#[test]
fn unsafe_code_stays_where_it_belongs() {
    let metadata = cargo_metadata::MetadataCommand::new()
        .manifest_path(repository().join("Cargo.toml"))
        .no_deps()
        .exec()
        .unwrap();
    let components = repository().join("components");
    let mut wrong = Vec::new();
    for package in &metadata.packages {
        let component = package.manifest_path.starts_with(&components);
        let exempt = UNSAFE.contains(&package.name.as_str())
            // Rust codels are C functions: exporting them needs an unsafe attribute.
            || component && package.name.as_str() != "genom-components";
        for target in &package.targets {
            let root = fs::read_to_string(&target.src_path).unwrap();
            // Tests and benchmarks may do what the product may not.
            if target.is_test() || target.is_bench() {
                continue;
            }
            if !exempt && !target.is_custom_build() && !root.contains("#![forbid(unsafe_code)]") {
                wrong.push(target.src_path.clone());
            }
        }
    }
    assert!(wrong.is_empty(), "roots without #![forbid(unsafe_code)]: {wrong:#?}");
}
