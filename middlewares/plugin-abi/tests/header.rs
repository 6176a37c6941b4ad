//! The structures are those of `genom3/middleware.h`, and the header is plain C and C++.

#![allow(clippy::unwrap_used, reason = "test code")]

use std::fs;
use std::mem::{align_of, offset_of};
use std::path::PathBuf;
use std::process::Command;

use genom_plugin_abi::codes::Code;
use genom_plugin_abi::table::{can, endpoint, health, level, part, policy, service, what};
use genom_plugin_abi::{
    Address, Answer, Bytes, Diagnosis, Entry, ErrorText, Host, MAJOR, MINOR, Pair, Plugin, Port,
    Service, Str, Type, table::FIXED_SIZE,
};

/// Compiles a text that includes the header, without warnings.
fn compiles(compiler: &str, arguments: &[&str], text: &str) {
    let place = tempfile::tempdir().unwrap();
    let include = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../plugin-api/include");
    let file = place.path().join(if compiler == "c++" { "t.cc" } else { "t.c" });
    fs::write(&file, format!("#include \"genom3/middleware.h\"\n{text}\n")).unwrap();
    let told = Command::new(compiler)
        .args(["-Wall", "-Wextra", "-pedantic", "-Werror", "-fsyntax-only", "-I"])
        .arg(include)
        .args(arguments)
        .arg(file)
        .output()
        .unwrap();
    assert!(told.status.success(), "{}", String::from_utf8_lossy(&told.stderr));
}

macro_rules! layout {
    ($out:ident, $rust:ty, $c:literal: $($field:ident $(as $name:literal)?),+) => {
        $out.push(format!("sizeof({}) == {}", $c, size_of::<$rust>()));
        $out.push(format!("_Alignof({}) == {}", $c, align_of::<$rust>()));
        $(
            let name = [stringify!($field), $($name)?].last().copied().unwrap();
            $out.push(format!("offsetof({}, {name}) == {}", $c, offset_of!($rust, $field)));
        )+
    };
}

#[test]
fn every_structure_has_the_layout_of_the_header() {
    let mut holds: Vec<String> = Vec::new();
    layout!(holds, Str, "genom_mw_str": ptr, len);
    layout!(holds, Bytes, "genom_mw_bytes": ptr, len);
    layout!(holds, Address, "genom_mw_address": instance, name);
    layout!(holds, ErrorText, "genom_mw_error": size, text, room, len, value);
    layout!(holds, Type, "genom_mw_type": size, name, digest, definition, bytes, align, flags);
    layout!(holds, Port, "genom_mw_port":
        size, at, ty as "type", reliable, transient_local, depth, policy, keep);
    layout!(holds, Service, "genom_mw_service": size, kind, input, output, digest, described);
    layout!(holds, Answer, "genom_mw_answer": size, what, code, run, value, name, data);
    layout!(holds, Entry, "genom_mw_entry":
        size, instance, time, level, line, place, file, message);
    layout!(holds, Pair, "genom_mw_pair": name, value);
    layout!(holds, Diagnosis, "genom_mw_diagnosis":
        size, instance, part, health, name, message, values, count);
    layout!(holds, Host, "genom_mw_host":
        size, major, minor, flags, host, log, release, sample, request, cancel, answer, endpoint,
        text, refusal, relayed, replied);
    layout!(holds, Plugin, "genom_mw_plugin":
        size, major, minor, reserved, name, version, capabilities, open, close, publisher, publish,
        close_publisher, subscription, close_subscription, capabilities_of, lost_by_publisher,
        lost_by_subscription, serve, close_served, reply, close_call, client, request, cancel,
        close_run, close_client, discover, ends_at, spelled, strangers, obstacles, masquerade,
        unmask, meeting_point, refused, trouble, announce, close_announced, reply_relayed,
        close_relayed, daemons, own, ask_all, ask, log, diagnose, simulated_time);
    let text: Vec<String> =
        holds.iter().map(|what| format!("_Static_assert({what}, \"{what}\");")).collect();
    compiles("cc", &["-std=c11"], &text.join("\n"));
}

/// Tables of libraries and hosts that were built then are read by these offsets.
#[cfg(target_pointer_width = "64")]
#[test]
fn the_tables_of_earlier_versions_end_where_they_ended_and_what_came_later_follows() {
    assert_eq!((offset_of!(Plugin, open), offset_of!(Plugin, discover)), (56, 56 + 19 * 8));
    assert_eq!((offset_of!(Plugin, meeting_point), offset_of!(Plugin, refused)), (264, 272));
    assert_eq!((offset_of!(Host, log), offset_of!(Host, endpoint)), (24, 72));
    assert_eq!((offset_of!(Host, text), offset_of!(Host, refusal)), (80, 88));
    // 1.2
    assert_eq!((offset_of!(Plugin, trouble), offset_of!(Plugin, announce)), (280, 288));
    assert_eq!((offset_of!(Plugin, simulated_time), size_of::<Plugin>()), (368, 376));
    assert_eq!((offset_of!(Host, relayed), offset_of!(Host, replied)), (96, 104));
    assert_eq!(size_of::<Host>(), 112);
}

#[test]
fn every_constant_is_that_of_the_header() {
    let constants = [
        ("MAJOR", u64::from(MAJOR)),
        ("MINOR", u64::from(MINOR)),
        ("VARIABLE", can::VARIABLE),
        ("CROSS_PROCESS", can::CROSS_PROCESS),
        ("CROSS_HOST", can::CROSS_HOST),
        ("SERVICES", can::SERVICES),
        ("NATIVE_SERVICES", can::NATIVE_SERVICES),
        ("DISCOVERY", can::DISCOVERY),
        ("RT_PUBLISH", can::RT_PUBLISH),
        ("LAYOUT", can::LAYOUT),
        ("NO_GATEWAY", can::NO_GATEWAY),
        ("RELAY", can::RELAY),
        ("REPORTS", can::REPORTS),
        ("FIXED_SIZE", FIXED_SIZE.into()),
        ("LATEST", policy::LATEST.into()),
        ("QUEUE", policy::QUEUE.into()),
        ("RING", policy::RING.into()),
        ("ATTRIBUTE", service::ATTRIBUTE.into()),
        ("FUNCTION", service::FUNCTION.into()),
        ("ACTIVITY", service::ACTIVITY.into()),
        ("ACCEPTED", what::ACCEPTED.into()),
        ("STATE", what::STATE.into()),
        ("RESULT", what::RESULT.into()),
        ("EXCEPTION", what::EXCEPTION.into()),
        ("LOST", what::LOST.into()),
        ("LOG_ERROR", level::ERROR.into()),
        ("LOG_WARN", level::WARN.into()),
        ("LOG_INFO", level::INFO.into()),
        ("LOG_DEBUG", level::DEBUG.into()),
        ("OUT_PORT", endpoint::OUT_PORT.into()),
        ("IN_PORT", endpoint::IN_PORT.into()),
        ("SERVICE", endpoint::SERVICE.into()),
        ("TASK", part::TASK.into()),
        ("CELL", part::CELL.into()),
        ("GOOD", health::GOOD.into()),
        ("LATE", health::LATE.into()),
        ("STUCK", health::STUCK.into()),
        ("ENDED", health::ENDED.into()),
    ];
    let codes = [
        ("OK", Code::OK),
        ("FAILED", Code::FAILED),
        ("TYPE_MISMATCH", Code::TYPE_MISMATCH),
        ("TAKEN", Code::TAKEN),
        ("UNSUPPORTED", Code::UNSUPPORTED),
        ("NOBODY", Code::NOBODY),
        ("TIMEOUT", Code::TIMEOUT),
        ("GONE", Code::GONE),
        ("BAD_DATA", Code::BAD_DATA),
    ];
    let codes = codes.map(|(name, code)| (name, u64::try_from(code.0).unwrap()));
    let text: Vec<String> = constants
        .iter()
        .chain(&codes)
        .map(|(name, value)| format!("_Static_assert(GENOM_MW_{name} == {value}, \"{name}\");"))
        .collect();
    compiles("cc", &["-std=c11"], &text.join("\n"));
}

#[test]
fn the_header_is_c99_and_c_plus_plus_11_without_warnings() {
    let use_it = "static const genom_mw_str name = GENOM_MW_STR(\"mine\");\n\
                  const genom_mw_str *it(void);\n\
                  const genom_mw_str *it(void) { return &name; }\n";
    compiles("cc", &["-std=c99"], use_it);
    compiles("c++", &["-std=c++11"], use_it);
}
