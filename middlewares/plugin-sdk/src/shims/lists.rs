//! What is visible, and how it is called there.

use genom_middleware::{Endpoint, EndpointKind, Obstacle, Refused, Stranger};
use genom_plugin_abi::table::{Opaque, endpoint};
use genom_plugin_abi::{Address, Code, ErrorText, Failure, Str};

use super::base::{Opened, at, guarded, logged};
use crate::given::List;
use crate::types;

fn tell(ends: Vec<Endpoint>, list: &List) {
    for end in ends {
        let kind = match end.kind {
            EndpointKind::Publisher => endpoint::OUT_PORT,
            EndpointKind::Subscription => endpoint::IN_PORT,
            EndpointKind::Service => endpoint::SERVICE,
        };
        list.endpoint(kind, &end.address, &end.ty);
    }
}

fn tell_obstacles(obstacles: &[Obstacle], list: &List) {
    obstacles.iter().for_each(|obstacle| list.text(&obstacle.what, &obstacle.fix));
}

pub(super) unsafe extern "C" fn discover(
    backend: Opaque,
    list: Opaque,
    error: *mut ErrorText,
) -> Code {
    // SAFETY: an open backend.
    let opened = unsafe { at::<Opened>(backend) };
    let work = || {
        let ends = opened.middleware.discover();
        let ends = ends.map_err(|error| Failure::new(Code::FAILED, error.why))?;
        tell(ends, &opened.host.list(list));
        Ok(())
    };
    // SAFETY: the host lent the error.
    unsafe { guarded(error, work) }
}

pub(super) unsafe extern "C" fn ends_at(
    backend: Opaque,
    place: Address,
    list: Opaque,
    error: *mut ErrorText,
) -> Code {
    // SAFETY: an open backend, and an address that is lent.
    let (opened, address) = unsafe { (at::<Opened>(backend), types::address(place)) };
    let work = || {
        let ends = opened.middleware.ends_at(&address);
        let ends = ends.map_err(|error| Failure::new(Code::FAILED, error.why))?;
        tell(ends, &opened.host.list(list));
        Ok(())
    };
    // SAFETY: the host lent the error.
    unsafe { guarded(error, work) }
}

pub(super) unsafe extern "C" fn spelled(backend: Opaque, place: Address, list: Opaque) {
    // SAFETY: an open backend, and an address that is lent.
    let (opened, address) = unsafe { (at::<Opened>(backend), types::address(place)) };
    logged(Some(opened.host), || {
        opened.host.list(list).text(&opened.middleware.spelled(&address), "");
    });
}

pub(super) unsafe extern "C" fn strangers(backend: Opaque, list: Opaque) {
    // SAFETY: an open backend.
    let opened = unsafe { at::<Opened>(backend) };
    logged(Some(opened.host), || {
        let list = opened.host.list(list);
        for stranger in opened.middleware.strangers() {
            match stranger {
                Stranger::Reader { address } => list.text(&address, ""),
                Stranger::Session { name, role } => list.text(&name, &role),
            }
        }
    });
}

pub(super) unsafe extern "C" fn obstacles(backend: Opaque, place: Address, list: Opaque) {
    // SAFETY: an open backend, and an address that is lent.
    let (opened, address) = unsafe { (at::<Opened>(backend), types::address(place)) };
    logged(Some(opened.host), || {
        tell_obstacles(&opened.middleware.obstacles(&address), &opened.host.list(list));
    });
}

pub(super) unsafe extern "C" fn masquerade(
    backend: Opaque,
    ours: Str,
    foreign: Str,
    error: *mut ErrorText,
) -> Code {
    // SAFETY: an open backend, and strings that are lent.
    let (opened, ours, foreign) = unsafe { (at::<Opened>(backend), ours.read(), foreign.read()) };
    let work = || {
        let shown = opened.middleware.masquerade(&ours, &foreign);
        shown.map_err(|error| Failure::new(Code::UNSUPPORTED, error.form))
    };
    // SAFETY: the host lent the error.
    unsafe { guarded(error, work) }
}

pub(super) unsafe extern "C" fn unmask(backend: Opaque, ours: Str) {
    // SAFETY: an open backend, and a string that is lent.
    let (opened, ours) = unsafe { (at::<Opened>(backend), ours.read()) };
    logged(Some(opened.host), || opened.middleware.unmask(&ours));
}

pub(super) unsafe extern "C" fn meeting_point(backend: Opaque, list: Opaque) {
    // SAFETY: an open backend.
    let opened = unsafe { at::<Opened>(backend) };
    logged(Some(opened.host), || {
        let list = opened.host.list(list);
        opened.middleware.meeting_point().iter().for_each(|(name, value)| list.text(name, value));
    });
}

pub(super) unsafe extern "C" fn refused(backend: Opaque, list: Opaque) {
    // SAFETY: an open backend.
    let opened = unsafe { at::<Opened>(backend) };
    logged(Some(opened.host), || {
        let list = opened.host.list(list);
        for Refused { why, count, peer } in opened.middleware.refused() {
            let peer = peer.map_or_else(String::new, |peer| peer.to_string());
            list.refusal(&why, count, &peer);
        }
    });
}

pub(super) unsafe extern "C" fn trouble(backend: Opaque, list: Opaque) {
    // SAFETY: an open backend.
    let opened = unsafe { at::<Opened>(backend) };
    logged(Some(opened.host), || {
        tell_obstacles(&opened.middleware.trouble(), &opened.host.list(list));
    });
}
