//! Compiles the guard that stops C++ exceptions between a codel and Rust, the shim that makes C++
//! objects, and the functions that replace some of the C library.

fn main() {
    let include = "../../plugin-api/include";
    println!("cargo:rerun-if-changed=src/ffi/guard.cc");
    println!("cargo:rerun-if-changed=src/cxx/shim.cc");
    println!("cargo:rerun-if-changed=src/process/stand_ins.cc");
    println!("cargo:rerun-if-changed=src/process/left.h");
    println!("cargo:rerun-if-changed={include}/genom3/c++");
    cc::Build::new()
        .cpp(true)
        .std("c++17")
        .include(include)
        .file("src/ffi/guard.cc")
        .file("src/cxx/shim.cc")
        .file("src/process/stand_ins.cc")
        .opt_level(2)
        .warnings(true)
        .flag("-Wno-cast-function-type")
        .compile("genom_host_guard");
}
