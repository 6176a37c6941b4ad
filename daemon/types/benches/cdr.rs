//! Compares the CDR codec of this crate, driven by a plan made at run time, with one that serde
//! derives at compile time, on the same values in the same run.
//!
//! Prints the median of each in nanoseconds and the ratio; below 1.00 ours is the faster one.

#![allow(missing_docs, clippy::unwrap_used, clippy::print_stdout)]

use std::hint::black_box;
use std::sync::Arc;
use std::time::Instant;

use byteorder::LittleEndian;
use genom_types::{DataType, Kind, Member, Record, ScopedName, TypeId, TypeTable};
use serde::{Deserialize, Serialize};

#[derive(Serialize, Deserialize)]
struct Vector {
    x: f64,
    y: f64,
    z: f64,
}

#[derive(Serialize, Deserialize)]
struct Pose {
    position: Vector,
    orientation: (f64, f64, f64, f64),
}

#[derive(Serialize, Deserialize)]
struct Part {
    name: String,
    rank: i32,
    pose: Pose,
    frame: String,
}

#[derive(Serialize, Deserialize)]
struct Robot {
    name: String,
    stamp: i64,
    parts: Vec<Part>,
}

#[derive(Serialize, Deserialize)]
struct Blob {
    data: Vec<u8>,
}

fn strukt(t: &mut TypeTable, name: &str, members: &[(&str, TypeId)]) -> TypeId {
    let members = members.iter().map(|&(name, ty)| Member { name: name.to_owned(), ty }).collect();
    t.add(Kind::Struct { name: ScopedName::new([name]), members })
}

/// Types `Pose`, `Blob` and `Robot`.
fn types() -> [DataType; 3] {
    let mut t = TypeTable::default();
    let double = t.add(Kind::Double);
    let octet = t.add(Kind::Octet);
    let long = t.add(Kind::Long);
    let string = t.add(Kind::String { bound: None });
    let stamp = t.add(Kind::LongLong);
    let vector = strukt(&mut t, "vector", &[("x", double), ("y", double), ("z", double)]);
    let four = t.add(Kind::Array { element: double, length: 4 });
    let pose = strukt(&mut t, "pose", &[("position", vector), ("orientation", four)]);
    let octets = t.add(Kind::Sequence { element: octet, bound: None });
    let blob = strukt(&mut t, "blob", &[("data", octets)]);
    let members = [("name", string), ("rank", long), ("pose", pose), ("frame", string)];
    let part = strukt(&mut t, "part", &members);
    let parts = t.add(Kind::Sequence { element: part, bound: None });
    let robot = strukt(&mut t, "robot", &[("name", string), ("stamp", stamp), ("parts", parts)]);
    let table = Arc::new(t);
    [pose, blob, robot].map(|id| DataType::new(&table, id).unwrap())
}

fn vector(x: f64) -> Vector {
    Vector { x, y: x + 1.0, z: x + 2.0 }
}

fn pose() -> Pose {
    Pose { position: vector(0.5), orientation: (0.0, 0.0, 0.0, 1.0) }
}

/// Median nanoseconds of one call of each, taken in turns so that both meet the same machine.
fn compare(name: &str, calls: u32, mut ours: impl FnMut(), mut theirs: impl FnMut()) {
    let time = |work: &mut dyn FnMut()| {
        let start = Instant::now();
        (0..calls).for_each(|_| work());
        start.elapsed().as_nanos() as f64 / f64::from(calls)
    };
    let (mut a, mut b) = (Vec::new(), Vec::new());
    for _ in 0..41 {
        a.push(time(&mut ours));
        b.push(time(&mut theirs));
    }
    a.sort_by(f64::total_cmp);
    b.sort_by(f64::total_cmp);
    let (a, b) = (a[20], b[20]);
    println!("{name:<28} ours {a:>12.1} ns   serde {b:>12.1} ns   ratio {:.2}", a / b);
}

fn bench<T: Serialize + for<'a> Deserialize<'a>>(name: &str, calls: u32, ty: &DataType, value: &T) {
    let bytes = cdr_encoding::to_vec::<_, LittleEndian>(value).unwrap();
    let mut record = Record::new(ty);
    record.decode_cdr(&bytes).unwrap();
    let (mut mine, mut serdes) = (Vec::new(), Vec::new());
    compare(
        &format!("{name}, encode"),
        calls,
        || {
            mine.clear();
            record.encode_cdr(black_box(&mut mine)).unwrap();
        },
        || {
            serdes.clear();
            let out = black_box(&mut serdes);
            cdr_encoding::to_writer::<_, LittleEndian, _>(out, black_box(value)).unwrap();
        },
    );
    assert_eq!(mine, bytes);
    let mut target = Record::new(ty);
    compare(
        &format!("{name}, decode"),
        calls,
        || target.decode_cdr(black_box(&bytes)).unwrap(),
        || {
            let read = cdr_encoding::from_bytes::<T, LittleEndian>(black_box(&bytes)).unwrap();
            black_box(read);
        },
    );
}

fn main() {
    let [pose_type, blob_type, robot_type] = types();
    bench("pose (7 doubles)", 20_000, &pose_type, &pose());
    let data = (0..1 << 20).map(|i| i as u8).collect();
    bench("1 MiB of octets", 5, &blob_type, &Blob { data });
    let parts = (0..10)
        .map(|rank| Part {
            name: format!("joint_{rank}"),
            rank,
            pose: pose(),
            frame: "base_link".to_owned(),
        })
        .collect();
    let robot = Robot { name: "mana".to_owned(), stamp: 1, parts };
    bench("10 nested structs, strings", 1_000, &robot_type, &robot);
}
