//! The structures of `genom3/middleware.h`, whose comments say what each means. A test compares
//! their layout with the header.

#![allow(missing_docs, reason = "the header documents them, under the same names")]

use std::ffi::c_void;

use crate::codes::Code;
use crate::lent::{Bytes, ErrorText, Str};

/// What a middleware can do.
pub mod can {
    pub const VARIABLE: u64 = 1;
    pub const CROSS_PROCESS: u64 = 2;
    pub const CROSS_HOST: u64 = 4;
    pub const SERVICES: u64 = 8;
    pub const NATIVE_SERVICES: u64 = 16;
    pub const DISCOVERY: u64 = 32;
    pub const RT_PUBLISH: u64 = 64;
    pub const LAYOUT: u64 = 128;
    pub const NO_GATEWAY: u64 = 256;
    pub const RELAY: u64 = 512;
    pub const REPORTS: u64 = 1024;
}

/// A flag of [`Type`].
pub const FIXED_SIZE: u32 = 1;

/// Policies of a [`Port`].
pub mod policy {
    pub const LATEST: u32 = 0;
    pub const QUEUE: u32 = 1;
    pub const RING: u32 = 2;
}

/// Kinds of a [`Service`].
pub mod service {
    pub const ATTRIBUTE: u32 = 0;
    pub const FUNCTION: u32 = 1;
    pub const ACTIVITY: u32 = 2;
}

/// What an [`Answer`] is.
pub mod what {
    pub const ACCEPTED: u32 = 1;
    pub const STATE: u32 = 2;
    pub const RESULT: u32 = 3;
    pub const EXCEPTION: u32 = 4;
    pub const LOST: u32 = 5;
}

/// Levels of a line in the log.
pub mod level {
    pub const ERROR: u32 = 1;
    pub const WARN: u32 = 2;
    pub const INFO: u32 = 3;
    pub const DEBUG: u32 = 4;
}

/// Kinds of an endpoint.
pub mod endpoint {
    pub const OUT_PORT: u32 = 1;
    pub const IN_PORT: u32 = 2;
    pub const SERVICE: u32 = 3;
}

/// What of a component a [`Diagnosis`] is about.
pub mod part {
    pub const TASK: u32 = 1;
    pub const CELL: u32 = 2;
}

/// How it fares.
pub mod health {
    pub const GOOD: u32 = 1;
    pub const LATE: u32 = 2;
    pub const STUCK: u32 = 3;
    pub const ENDED: u32 = 4;
}

/// A handle or what was given: opaque to the other side.
pub type Opaque = *mut c_void;

#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Address {
    pub instance: Str,
    pub name: Str,
}

#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Type {
    pub size: usize,
    pub name: Str,
    pub digest: Str,
    pub definition: Str,
    pub bytes: u64,
    pub align: u32,
    pub flags: u32,
}

#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Port {
    pub size: usize,
    pub at: Address,
    pub ty: *const Type,
    pub reliable: i32,
    pub transient_local: i32,
    pub depth: i64,
    pub policy: u32,
    pub keep: u32,
}

#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Service {
    pub size: usize,
    pub kind: u32,
    pub input: *const Type,
    pub output: *const Type,
    pub digest: Str,
    pub described: Str,
}

#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Answer {
    pub size: usize,
    pub what: u32,
    pub code: Code,
    pub run: u64,
    pub value: u64,
    pub name: Str,
    pub data: Bytes,
}

#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Entry {
    pub size: usize,
    pub instance: Str,
    pub time: i64,
    pub level: u32,
    pub line: u32,
    pub place: Str,
    pub file: Str,
    pub message: Str,
}

#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Pair {
    pub name: Str,
    pub value: Str,
}

#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Diagnosis {
    pub size: usize,
    pub instance: Str,
    pub part: u32,
    pub health: u32,
    pub name: Str,
    pub message: Str,
    pub values: *const Pair,
    pub count: usize,
}

/// What the host gives. A function is missing if the host is older.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Host {
    pub size: usize,
    pub major: u16,
    pub minor: u16,
    pub flags: u32,
    pub host: Opaque,
    pub log: Option<unsafe extern "C" fn(Opaque, u32, Str)>,
    pub release: Option<unsafe extern "C" fn(Opaque)>,
    pub sample: Option<unsafe extern "C" fn(Opaque, Bytes)>,
    pub request: Option<unsafe extern "C" fn(Opaque, Opaque, Bytes)>,
    pub cancel: Option<unsafe extern "C" fn(Opaque, u64)>,
    pub answer: Option<unsafe extern "C" fn(Opaque, *const Answer)>,
    pub endpoint: Option<unsafe extern "C" fn(Opaque, u32, Str, Str)>,
    pub text: Option<unsafe extern "C" fn(Opaque, Str, Str)>,
    pub refusal: Option<unsafe extern "C" fn(Opaque, Str, u64, Str)>,
    pub relayed: Option<unsafe extern "C" fn(Opaque, Opaque, Bytes)>,
    pub replied: Option<unsafe extern "C" fn(Opaque, Str, Bytes)>,
}

/// Opens something at an address; what it makes goes into the argument before the last.
pub type Serve = unsafe extern "C" fn(
    Opaque,
    Address,
    *const Service,
    Opaque,
    *mut Opaque,
    *mut ErrorText,
) -> Code;

/// Sends a request to one end of a daemon; the reply goes into the argument before the last.
pub type Ask = unsafe extern "C" fn(Opaque, Str, Str, Bytes, u64, Opaque, *mut ErrorText) -> Code;

/// What the plugin gives.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Plugin {
    pub size: usize,
    pub major: u16,
    pub minor: u16,
    pub reserved: u32,
    pub name: Str,
    pub version: Str,
    pub capabilities: u64,
    pub open: Option<unsafe extern "C" fn(*const Host, Str, *mut Opaque, *mut ErrorText) -> Code>,
    pub close: Option<unsafe extern "C" fn(Opaque)>,
    pub publisher:
        Option<unsafe extern "C" fn(Opaque, *const Port, *mut Opaque, *mut ErrorText) -> Code>,
    pub publish: Option<unsafe extern "C" fn(Opaque, Bytes) -> Code>,
    pub close_publisher: Option<unsafe extern "C" fn(Opaque)>,
    pub subscription: Option<
        unsafe extern "C" fn(Opaque, *const Port, Opaque, *mut Opaque, *mut ErrorText) -> Code,
    >,
    pub close_subscription: Option<unsafe extern "C" fn(Opaque)>,
    pub capabilities_of: Option<unsafe extern "C" fn(Opaque) -> u64>,
    pub lost_by_publisher: Option<unsafe extern "C" fn(Opaque) -> u64>,
    pub lost_by_subscription: Option<unsafe extern "C" fn(Opaque) -> u64>,
    pub serve: Option<Serve>,
    pub close_served: Option<unsafe extern "C" fn(Opaque)>,
    pub reply: Option<unsafe extern "C" fn(Opaque, *const Answer)>,
    pub close_call: Option<unsafe extern "C" fn(Opaque)>,
    pub client: Option<
        unsafe extern "C" fn(Opaque, Address, *const Service, *mut Opaque, *mut ErrorText) -> Code,
    >,
    pub request:
        Option<unsafe extern "C" fn(Opaque, Bytes, Opaque, *mut Opaque, *mut ErrorText) -> Code>,
    pub cancel: Option<unsafe extern "C" fn(Opaque)>,
    pub close_run: Option<unsafe extern "C" fn(Opaque)>,
    pub close_client: Option<unsafe extern "C" fn(Opaque)>,
    pub discover: Option<unsafe extern "C" fn(Opaque, Opaque, *mut ErrorText) -> Code>,
    pub ends_at: Option<unsafe extern "C" fn(Opaque, Address, Opaque, *mut ErrorText) -> Code>,
    pub spelled: Option<unsafe extern "C" fn(Opaque, Address, Opaque)>,
    pub strangers: Option<unsafe extern "C" fn(Opaque, Opaque)>,
    pub obstacles: Option<unsafe extern "C" fn(Opaque, Address, Opaque)>,
    pub masquerade: Option<unsafe extern "C" fn(Opaque, Str, Str, *mut ErrorText) -> Code>,
    pub unmask: Option<unsafe extern "C" fn(Opaque, Str)>,
    pub meeting_point: Option<unsafe extern "C" fn(Opaque, Opaque)>,
    pub refused: Option<unsafe extern "C" fn(Opaque, Opaque)>,
    pub trouble: Option<unsafe extern "C" fn(Opaque, Opaque)>,
    pub announce:
        Option<unsafe extern "C" fn(Opaque, Str, Opaque, *mut Opaque, *mut ErrorText) -> Code>,
    pub close_announced: Option<unsafe extern "C" fn(Opaque)>,
    pub reply_relayed: Option<unsafe extern "C" fn(Opaque, Bytes)>,
    pub close_relayed: Option<unsafe extern "C" fn(Opaque)>,
    pub daemons: Option<unsafe extern "C" fn(Opaque, Opaque, *mut ErrorText) -> Code>,
    pub own: Option<unsafe extern "C" fn(Opaque, Opaque)>,
    pub ask_all:
        Option<unsafe extern "C" fn(Opaque, Str, Bytes, u64, Opaque, *mut ErrorText) -> Code>,
    pub ask: Option<Ask>,
    pub log: Option<unsafe extern "C" fn(Opaque, *const Entry)>,
    pub diagnose: Option<unsafe extern "C" fn(Opaque, *const *const Diagnosis, usize)>,
    pub simulated_time: Option<unsafe extern "C" fn(Opaque)>,
}

// SAFETY: the strings of a table are constants of its library, which is never unloaded; the rest
// are numbers and functions.
unsafe impl Send for Plugin {}
// SAFETY: as above; nothing changes a table.
unsafe impl Sync for Plugin {}
