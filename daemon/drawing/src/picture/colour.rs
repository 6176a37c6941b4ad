//! One colour for each middleware: readable on white and on black, and also without red and green.

/// The colour of a middleware, as `#RRGGBB`.
pub(crate) fn of(backend: Option<&str>) -> &'static str {
    match backend {
        None => "#6e7781",
        Some("local") => "#57606a",
        Some("shm") => "#1a7f37",
        Some("zenoh") => "#0969da",
        Some("ros2") => "#bc4c00",
        Some(_) => "#8250df",
    }
}
