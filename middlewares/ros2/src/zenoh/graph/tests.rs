//! What the graph of nodes on zenoh makes of tokens.

use super::*;
use crate::rmw::Named;

fn wanted(kind: EndpointKind, digest: &str) -> Wanted {
    let ty = TypeName::new("demo", "msg", "State");
    Wanted {
        kind,
        address: "demo/position".into(),
        types: format!("::demo::state of {digest}"),
        digest: digest.into(),
        of: Named { name: "demo/position".into(), ty, hash: Some("RIHS01_1".into()) },
        node: "demo".into(),
    }
}

fn end(session: &str, kind: &str, ty: &str) -> End {
    let token = format!(
        "@ros2_lv/0/{session}/0/1/{kind}/%/%/n/%demo%position/demo::msg::dds_::{ty}_/RIHS01_2/\
         ::,7:,:,:,,"
    );
    End::parse(&token).unwrap()
}

fn told(kind: EndpointKind, digest: &str) -> Told {
    Told {
        kind,
        address: "demo/position".into(),
        digest: digest.into(),
        types: format!("their {digest}"),
    }
}

#[test]
fn a_daemons_end_is_listed_once_and_nothing_of_it_stays() {
    let graph = Arc::new(Graph::new(8));
    let found = end("aa", "MP", "State");
    let id = found.id();
    graph.told(id.clone(), told(EndpointKind::Publisher, "d")).unwrap();
    graph.found(found, [1; 16]).unwrap();
    assert_eq!(graph.list().len(), 1);
    assert!(matches!(
        graph.register(&Address::new("demo", "position"), wanted(EndpointKind::Publisher, "d")),
        Err(OpenError::Taken { .. })
    ));
    // A killed daemon's tokens vanish in any order.
    graph.untold(&id);
    assert_eq!(graph.list(), []);
    graph.lost(&id);
    assert!(graph.lock().sessions.is_empty() && graph.lock().found.is_empty());
}

#[test]
fn a_node_of_another_type_is_refused_and_one_of_another_structure_is_not() {
    let graph = Arc::new(Graph::new(8));
    let at = Address::new("demo", "position");
    graph.found(end("aa", "MP", "Pose"), [1; 16]).unwrap();
    let refused = graph.register(&at, wanted(EndpointKind::Subscription, "d"));
    assert!(matches!(refused, Err(OpenError::TypeMismatch { theirs, .. })
        if theirs == "demo/msg/Pose"));
    graph.lost(&("aa".into(), 1));
    graph.found(end("aa", "MP", "State"), [1; 16]).unwrap();
    assert!(graph.register(&at, wanted(EndpointKind::Subscription, "d")).is_ok());
    assert_eq!(graph.list().len(), 1);
}

#[test]
fn types_of_equal_members_are_read_under_each_of_their_names() {
    let graph = Arc::new(Graph::new(8));
    let found = end("aa", "MP", "Pose");
    graph.told(found.id(), told(EndpointKind::Publisher, "d")).unwrap();
    graph.found(found, [1; 16]).unwrap();
    let at = Address::new("demo", "position");
    let _own = graph.register(&at, wanted(EndpointKind::Subscription, "d")).unwrap();
    let pose = ("demo::msg::dds_::Pose_".to_owned(), "RIHS01_2".to_owned());
    assert_eq!(graph.equals("demo/position", "d"), [pose].into());
    assert!(graph.equals("demo/position", "e").is_empty());
    assert!(graph.equals("demo/speed", "d").is_empty());
}

#[test]
fn a_service_of_another_hash_is_no_service_that_can_be_called() {
    let graph = Arc::new(Graph::new(8));
    let wanted = wanted(EndpointKind::Service, "d");
    let now = Instant::now();
    assert_eq!(graph.service(&wanted, now), Service::Nobody);
    graph.found(end("aa", "SS", "State"), [1; 16]).unwrap();
    assert_eq!(graph.service(&wanted, now), Service::Differs("demo/msg/State (RIHS01_2)".into()));
}

#[test]
fn a_session_has_room_for_so_many_ends_and_leaves_that_of_others() {
    let graph = Graph::new(8);
    let of = |session: &str, number| {
        let end = end(session, "MP", "State");
        End { number, ..end }
    };
    let number = u64::try_from(ENDS).unwrap();
    for n in 0..number {
        graph.found(of("aa", n), [1; 16]).unwrap();
    }
    assert_eq!(graph.found(of("aa", number), [1; 16]), Err(Reason::Ends));
    let told = || told(EndpointKind::Publisher, "d");
    assert_eq!(graph.told(("aa".into(), number), told()), Err(Reason::Ends));
    // What is known already may be told again, and what is gone makes room.
    assert!(graph.found(of("aa", 7), [1; 16]).is_ok());
    graph.lost(&("aa".into(), number));
    assert_eq!(graph.found(of("aa", number), [1; 16]), Err(Reason::Ends));
    graph.lost(&("aa".into(), 7));
    assert!(graph.found(of("aa", number), [1; 16]).is_ok());
    assert!(graph.told(("bb".into(), 1), told()).is_ok());
    for session in ["cc", "dd", "ee"] {
        for n in 0..number {
            assert!(graph.found(of(session, n), [1; 16]).is_ok() || session == "ee");
        }
    }
    assert_eq!(graph.found(of("ff", 1), [1; 16]), Err(Reason::Ends), "all of them");
}

#[test]
fn so_many_sessions_are_known_and_those_that_are_gone_make_room() {
    let graph = Graph::new(2);
    let tell = |session: &str| graph.found(end(session, "MP", "State"), [1; 16]);
    assert!(tell("aa").is_ok() && tell("bb").is_ok());
    assert_eq!(tell("cc"), Err(Reason::Sessions));
    assert!(tell("aa").is_ok());
    graph.lost(&("aa".into(), 1));
    graph.lost(&("aa".into(), 1));
    assert!(tell("cc").is_ok());
    assert_eq!(tell("aa"), Err(Reason::Sessions));
}
