//! A port that moves to another middleware while others read it.

use genom_configuration::BackendNames;
use genom_supervisor::components::Hosted;
use genom_supervisor::connections::{Patience, Wanted};
use genom_supervisor::outcome::Outcome;
use serde_json::json;

use crate::own::Own;
use crate::support::{Scratch, load, until};

/// One above, one below the 64 KiB up to which a component keeps a copy of what it wrote.
const SIZES: [usize; 2] = [100_000, 100];

fn image(size: usize) -> String {
    format!(
        "struct image {{ double moment; string<8> place; octet pixels[{size}]; }};\n\
         component camera {{ version \"1\"; lang \"c\"; task main;\n\
           port out image frame;\n\
           activity shoot(in octet seed = 0) {{ task main;\n\
             codel<start> camera_shoot(local in seed, out frame) yield ether; }};\n\
         }};\n"
    )
}

fn reader(size: usize) -> String {
    format!(
        "struct image {{ double moment; string<8> place; octet pixels[{size}]; }};\n\
         component eye {{ version \"1\"; lang \"c\"; task main;\n\
           ids {{ sequence<octet> seen; }};\n\
           port in image frame;\n\
           activity see() {{ task main; codel<start> eye_see(in frame, out seen) yield ether; }};\n\
           attribute tell(out seen);\n\
         }};\n"
    )
}

/// Writes NaN with a payload and a text that is not UTF-8, and then changes the buffer without
/// writing.
const CAMERA: &str = r#"
genom_event
camera_shoot(uint8_t seed, const camera_frame *frame, const genom_context self)
{
  const uint64_t nan = UINT64_C(0x7ff8dead0beef001);
  image *out = frame->data(self);

  memcpy(&out->moment, &nan, sizeof(nan));
  memset(out->place, 0, sizeof(out->place));
  memcpy(out->place, "<PLACE>", 5);
  memset(out->pixels, seed, sizeof(out->pixels));
  if (frame->write(self) != genom_ok) abort();
  memset(out->pixels, 0xee, sizeof(out->pixels));
  return camera_ether;
}
"#;

/// Keeps the value bit by bit, once there is one.
const EYE: &str = "
genom_event
eye_see(const eye_frame *frame, sequence_octet *seen, const genom_context self)
{
  const image *value;

  if (frame->read(self) != genom_ok) abort();
  value = frame->data(self);
  if (!value || seen->_length) return eye_ether;
  if (genom_sequence_reserve(seen, sizeof(*value))) abort();
  seen->_length = offsetof(image, pixels) + sizeof(value->pixels);
  memcpy(seen->_buffer, value, seen->_length);
  return eye_ether;
}
";

/// The bytes of the value that the eye has read.
fn seen(eye: &Hosted, size: usize) -> Vec<u8> {
    until("an image", || {
        eye.call("see", &json!({})).unwrap();
        let Outcome::Success(outputs) = eye.call("tell", &json!({})).unwrap() else { panic!() };
        let all = outputs["seen"].as_array()?.iter();
        let all: Vec<u8> = all.map(|byte| byte.as_u64().unwrap() as u8).collect();
        (all.len() == 16 + size).then_some(all)
    })
}

#[test]
fn the_first_value_where_a_port_moves_to_is_the_last_that_was_written() {
    for size in SIZES {
        for (from, to) in [("local", "own"), ("own", "local")] {
            moves(size, from, to, *b"\xff\xfe\x80x");
        }
        // A text that is not UTF-8 cannot be encoded as CDR, which shared memory uses for such
        // types.
        for (from, to) in [("local", "shm"), ("shm", "local")] {
            moves(size, from, to, *b"left");
        }
    }
}

fn moves(size: usize, from: &str, to: &str, place: [u8; 4]) {
    let scratch = Scratch::new();
    let escaped: String = place.iter().map(|byte| format!("\\{byte:03o}")).collect();
    let camera = scratch.component("camera", &image(size), &CAMERA.replace("<PLACE>", &escaped));
    let eye = scratch.component("eye", &reader(size), EYE);
    let supervisor = scratch.supervisor();
    supervisor.backends.add(Own::new());
    let (camera, eye) = (load(&supervisor, camera), load(&supervisor, eye));
    let on = |name: &str| BackendNames::one(name);
    supervisor.connections.move_to(&camera, None, &on(from)).unwrap();
    let shoot = |seed: u8| {
        let ended = camera.call("shoot", &json!({ "seed": seed })).unwrap();
        assert_eq!(ended.exception(), None);
    };
    // A component always keeps a copy of its first value, whatever the size.
    [1, 2, 3].into_iter().for_each(shoot);
    let wanted = Wanted {
        inport: "eye/frame".to_owned(),
        kind: None,
        outport: "camera/frame".to_owned(),
        policy: None,
        over: None,
        wait: false,
        patience: Patience::Full,
    };
    supervisor.connections.connect(&wanted).unwrap();
    supervisor.connections.move_to(&camera, None, &on(to)).unwrap();
    let made = supervisor.connections.present("eye/frame").unwrap();
    assert_eq!(made.backend(), Some(to));
    let got = seen(&eye, size);
    // The NaN, the text, and pixels of the third image, in C layout.
    let mut written = 0x7ff8_dead_0bee_f001_u64.to_ne_bytes().to_vec();
    written.extend(place);
    written.resize(16, 0);
    written.resize(16 + size, 3);
    assert_eq!(got[..16], written[..16], "{size} bytes from {from} to {to}");
    assert!(got == written, "image {} of {size} bytes from {from} to {to}", got[16]);
    drop((camera, eye));
    assert!(supervisor.unload_all().is_empty());
}
