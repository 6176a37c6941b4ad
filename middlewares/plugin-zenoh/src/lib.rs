//! The zenoh backend in a library of its own, `libgenomd_zenoh_plugin.so`. It is part of genomd
//! anyway; here it proves that the table carries services, discovery and types of variable size.

genom_plugin::export!(genom_zenoh::Zenoh, "zenoh_plugin");
