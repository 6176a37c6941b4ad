//! Which crates of the workspace each crate may use.

/// Crates that hold real code, with the crates of ours that each may know (design: arrows point
/// down only). The daemon is the one place where all of them meet.
pub(super) const ARROWS: &[(&str, &[&str])] = &[
    ("genom-types", &["genom-nearest"]),
    ("genom-text", &["genom-nearest"]),
    ("genom-description", &["genom-nearest", "genom-text", "genom-types"]),
    ("genom-description-tools", &["genom-description", "genom-text", "genom-types"]),
    ("genom-lsp", &["genom-description", "genom-description-tools", "genom-formal"]),
    ("genom-headers", &[]),
    ("genom-project", PROJECT),
    ("genom-genom3", &["genom-description", "genom-description-tools", "genom-project"]),
    ("genom-drawing", &["genom-protocol"]),
    ("genom-verdicts", VERDICTS),
    ("genom-middleware", &["genom-types"]),
    ("genom-kit", MIDDLEWARE),
    ("genom-conformance", MIDDLEWARE),
    ("genom-local", BACKEND),
    ("genom-example", BACKEND),
    ("genom-shm", BACKEND),
    ("genom-zenoh", ZENOH),
    ("genom-zenoh-doctor", &["genom-middleware"]),
    ("genom-yarp", BACKEND),
    ("genomd-yarp", &["genom-plugin", "genom-yarp"]),
    ("genom-gateway", BACKEND),
    ("genom-plugin-abi", MIDDLEWARE),
    ("genom-plugin", &["genom-middleware", "genom-plugin-abi", "genom-types"]),
    ("genom-plugin-host", PLUGIN_HOST),
    ("genom-plugin-zenoh", &["genom-plugin", "genom-zenoh"]),
    ("genom-ros2", ROS2),
    ("genom-rtps-guard", &["genom-kit"]),
    ("genom-rosidl", &["genom-types"]),
    ("genom-floor", &[]),
    ("genom-bench", &["genom-floor", "genom-types"]),
    ("genom-runtime", RUNTIME),
    ("genom-monitor", &["genom-description"]),
    ("genom-temporal", &[]),
    ("genom-timing", &[]),
    ("genom-formal", &["genom-description", "genom-runtime", "genom-temporal", "genom-timing"]),
    ("genom-export", &["genom-description", "genom-formal", "genom-runtime"]),
    ("genom-rules", RULES),
    ("genom-elf", &[]),
    ("genom-host", HOST),
    ("genom-blackbox", &[]),
    ("genom-recording", &["genom-protocol"]),
    ("genom-interpreter", &["genom-description", "genom-elf", "genom-runtime"]),
    ("genom-apart", &[]),
    ("genom-comparison", &["genom-apart", "genom-drawing", "genom-protocol"]),
    ("genom-stage", &["genom-description", "genom-middleware", "genom-runtime", "genom-types"]),
    ("genom-archive", ARCHIVE),
    ("genom-lockstep", &[]),
    ("genom-embedding", EMBEDDING),
    ("genom-timekeeper", TIMEKEEPER),
    ("genom-client", &["genom-lockstep", "genom-protocol"]),
    ("genom-client-c", &["genom-client"]),
    ("genom-lua", &["genom-nearest"]),
    ("genom-doctor", &["genom-protocol"]),
    ("genom-scenario", &["genom-apart", "genom-nearest", "genom-protocol", "genom-stage"]),
    ("genom-ports", PORTS),
    ("genom-bus", &["genom-ports", "genom-protocol"]),
    ("genom-registry", BACKENDS),
    ("genom-configuration", CONFIGURATION),
    ("genom-doors", &["genom-nearest", "genom-proof", "genom-protocol"]),
    ("genom-web", &["genom-configuration", "genom-doors", "genom-proof", "genom-protocol"]),
    (
        "genom-foxglove",
        &["genom-configuration", "genom-doors", "genom-protocol", "genom-recording"],
    ),
    ("genom-finder", &["genom-description", "genom-host", "genom-protocol", "genom-runtime"]),
    ("genom-supervisor", SUPERVISOR),
    ("genom-views", VIEWS),
    ("genom-cells", CELLS),
    ("genom-launch", LAUNCH),
    ("genom-limits", &["genom-configuration"]),
    ("genom-systemd", &["genom-host"]),
    ("genom-telemetry", TELEMETRY),
    ("genom-proof", &[]),
    ("genom-nearest", &[]),
    ("genom-protocol", &["genom-nearest"]),
    ("genomctl", GENOMCTL),
    // The daemon once more, as a library.
    (
        "genom-runner",
        &["genom-description", "genom-host", "genom-runtime", "genom-types", "genomd"],
    ),
    ("genom-derive", &[]),
    ("genom", &["genom-derive"]),
    ("genom-components", &[]),
    // Components use the SDK, and the types of what they exchange.
    ("stereo", &["genom", "images"]),
    ("viewer", &["genom", "images"]),
    ("genom-allocations", &[]),
];
/// `genom`: the table that Rust component libraries export, which the host reads.
const HOST: &[&str] = &[
    "genom",
    "genom-description",
    "genom-description-tools",
    "genom-elf",
    "genom-headers",
    "genom-interpreter",
    "genom-middleware",
    "genom-runtime",
    "genom-types",
];
const RUNTIME: &[&str] = &["genom-description", "genom-middleware", "genom-monitor", "genom-types"];
const RULES: &[&str] = &["genom-description", "genom-nearest", "genom-protocol", "genom-runtime"];
const PORTS: &[&str] =
    &["genom-blackbox", "genom-middleware", "genom-protocol", "genom-runtime", "genom-types"];
const VIEWS: &[&str] = &[
    "genom-description",
    "genom-doctor",
    "genom-doors",
    "genom-middleware",
    "genom-ports",
    "genom-protocol",
    "genom-runtime",
    "genom-supervisor",
    "genom-types",
];
const ARCHIVE: &[&str] =
    &["genom-cells", "genom-doors", "genom-protocol", "genom-recording", "genom-supervisor"];
const LAUNCH: &[&str] = &[
    "genom-description",
    "genom-doors",
    "genom-finder",
    "genom-middleware",
    "genom-nearest",
    "genom-protocol",
    "genom-registry",
    "genom-types",
];
const EMBEDDING: &[&str] = &[
    "genom-cells",
    "genom-description",
    "genom-doors",
    "genom-host",
    "genom-lockstep",
    "genom-ports",
    "genom-protocol",
    "genom-supervisor",
    "genom-types",
    "genom-views",
];
const TIMEKEEPER: &[&str] = &[
    "genom-cells",
    "genom-middleware",
    "genom-protocol",
    "genom-registry",
    "genom-runtime",
    "genom-supervisor",
    "genom-types",
];
const CELLS: &[&str] = &[
    "genom-blackbox",
    "genom-configuration",
    "genom-gateway",
    "genom-host",
    "genom-kit",
    "genom-limits",
    "genom-middleware",
    "genom-nearest",
    "genom-ports",
    "genom-protocol",
    "genom-recording",
    "genom-registry",
    "genom-runtime",
    "genom-supervisor",
];
/// `genom`: its sources, which are installed for components in Rust.
const PROJECT: &[&str] =
    &["genom", "genom-description", "genom-description-tools", "genom-headers", "genom-types"];
const GENOMCTL: &[&str] = &[
    "genom-apart",
    "genom-comparison",
    "genom-conformance",
    "genom-description",
    "genom-description-tools",
    "genom-doctor",
    "genom-drawing",
    "genom-export",
    "genom-formal",
    "genom-genom3",
    "genom-lsp",
    "genom-middleware",
    "genom-plugin-host",
    "genom-project",
    "genom-proof",
    "genom-protocol",
    "genom-recording",
    "genom-rosidl",
    "genom-runtime",
    "genom-scenario",
    "genom-stage",
    "genom-types",
    "genom-verdicts",
];
const VERDICTS: &[&str] = &[
    "genom-description",
    "genom-drawing",
    "genom-formal",
    "genom-protocol",
    "genom-recording",
    "genom-rules",
    "genom-runtime",
    "genom-scenario",
];
/// The only crate that knows which middlewares exist.
const BACKENDS: &[&str] = &[
    "genom-gateway",
    "genom-local",
    "genom-middleware",
    "genom-nearest",
    "genom-plugin-host",
    "genom-ros2",
    "genom-shm",
    "genom-zenoh",
];
const CONFIGURATION: &[&str] = &[
    "genom-elf",
    "genom-middleware",
    "genom-nearest",
    "genom-protocol",
    "genom-registry",
    "genom-runtime",
];
const SUPERVISOR: &[&str] = &[
    "genom-blackbox",
    "genom-bus",
    "genom-configuration",
    "genom-description",
    "genom-finder",
    "genom-host",
    "genom-middleware",
    "genom-nearest",
    "genom-ports",
    "genom-protocol",
    "genom-registry",
    "genom-rules",
    "genom-runtime",
    "genom-types",
];
const TELEMETRY: &[&str] = &[
    "genom-configuration",
    "genom-host",
    "genom-middleware",
    "genom-nearest",
    "genom-ports",
    "genom-protocol",
    "genom-runtime",
    "genom-supervisor",
];
const MIDDLEWARE: &[&str] = &["genom-middleware", "genom-types"];
const PLUGIN_HOST: &[&str] = &["genom-kit", "genom-middleware", "genom-plugin-abi", "genom-types"];
const BACKEND: &[&str] = &["genom-kit", "genom-middleware", "genom-types"];
const ZENOH: &[&str] = &["genom-kit", "genom-middleware", "genom-types", "genom-zenoh-doctor"];
const ROS2: &[&str] = &[
    "genom-kit",
    "genom-middleware",
    "genom-rosidl",
    "genom-rtps-guard",
    "genom-types",
    "genom-zenoh-doctor",
];
/// Crates at the top: they may use any other.
pub(super) const TOP: &[&str] = &["genomd", "genom-runner", "genom-tests"];
