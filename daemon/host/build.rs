//! Compiles the guard that stops C++ exceptions between a codel and Rust, the shim that makes C++
//! objects, and the functions that replace some of the C library.

use std::path::PathBuf;

use genom_headers::HEADERS;

fn main() -> std::io::Result<()> {
    let include = PathBuf::from(std::env::var_os("OUT_DIR").unwrap_or_default()).join("include");
    for (path, text) in HEADERS {
        let file = include.join(path);
        std::fs::create_dir_all(file.parent().unwrap_or(&include))?;
        std::fs::write(file, text)?;
    }
    println!("cargo:rerun-if-changed=src/ffi/guard.cc");
    println!("cargo:rerun-if-changed=src/cxx/shim.cc");
    println!("cargo:rerun-if-changed=src/process/stand_ins.cc");
    println!("cargo:rerun-if-changed=src/process/left.h");
    cc::Build::new()
        .cpp(true)
        .std("c++17")
        .include(&include)
        .file("src/ffi/guard.cc")
        .file("src/cxx/shim.cc")
        .file("src/process/stand_ins.cc")
        .opt_level(2)
        .warnings(true)
        .flag("-Wno-cast-function-type")
        .compile("genom_host_guard");
    Ok(())
}
