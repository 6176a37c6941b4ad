//! Compiles the guard that stops C++ exceptions between a codel and Rust.

fn main() {
    println!("cargo:rerun-if-changed=src/ffi/guard.cc");
    cc::Build::new()
        .cpp(true)
        .file("src/ffi/guard.cc")
        .opt_level(2)
        .warnings(true)
        .flag("-Wno-cast-function-type")
        .compile("genom_host_guard");
}
