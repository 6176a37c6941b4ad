//! Messages of ROS 2 that tests write and read byte by byte, and the hashes of their types.

pub(super) fn bytes(hexadecimal: &str) -> Vec<u8> {
    let digits = hexadecimal.as_bytes().chunks(2);
    digits.map(|two| u8::from_str_radix(std::str::from_utf8(two).unwrap(), 16).unwrap()).collect()
}

/// `diagnostic_msgs/msg/DiagnosticStatus`, but for its values.
#[derive(Debug)]
pub(super) struct Status {
    pub(super) level: u8,
    pub(super) name: String,
    pub(super) message: String,
}

/// Little-endian CDR, version 1, read from its start (OMG DDS-XTypes 1.3, 7.4.1).
pub(super) struct Cdr<'a> {
    pub(super) all: &'a [u8],
    pub(super) at: usize,
}

impl Cdr<'_> {
    pub(super) fn number(&mut self) -> u32 {
        self.at = self.at.next_multiple_of(4);
        let four = self.all[self.at..self.at + 4].try_into().unwrap();
        self.at += 4;
        u32::from_le_bytes(four)
    }

    pub(super) fn octet(&mut self) -> u8 {
        self.at += 1;
        self.all[self.at - 1]
    }

    /// Its length counts the zero at its end.
    pub(super) fn text(&mut self) -> String {
        let length = self.number() as usize;
        let text = &self.all[self.at..self.at + length - 1];
        self.at += length;
        String::from_utf8(text.to_vec()).unwrap()
    }
}

/// A `diagnostic_msgs/msg/DiagnosticArray`.
pub(super) fn statuses(body: &[u8]) -> Vec<Status> {
    assert_eq!(body[..4], [0, 1, 0, 0]);
    let mut cdr = Cdr { all: &body[4..], at: 0 };
    let _date = (cdr.number(), cdr.number());
    let _frame = cdr.text();
    let count = cdr.number();
    let status = |_| {
        let level = cdr.octet();
        let (name, message, _hardware) = (cdr.text(), cdr.text(), cdr.text());
        for _ in 0..cdr.number() {
            let _value = (cdr.text(), cdr.text());
        }
        Status { level, name, message }
    };
    (0..count).map(status).collect()
}

/// Text in hexadecimal CDR that begins on a multiple of 4, and ends on one.
pub(super) fn text(text: &str) -> String {
    let mut all = (text.len() as u32 + 1).to_le_bytes().to_vec();
    all.extend(text.bytes().chain([0]));
    all.resize(all.len().next_multiple_of(4), 0);
    all.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// A date in hexadecimal CDR, as a message of `/clock` has it.
pub(super) fn date(milliseconds: u32) -> String {
    let nanosec = (milliseconds % 1000 * 1_000_000).to_le_bytes();
    let sec = (milliseconds / 1000).to_le_bytes();
    let body = [&[0, 1, 0, 0][..], &sec, &nanosec].concat();
    body.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// A type as a key has it, and its hash as ROS 2 Jazzy publishes it.
pub(super) const DIAGNOSTICS: [&str; 2] = [
    "diagnostic_msgs::msg::dds_::DiagnosticArray_",
    "RIHS01_5a8a36efb05fb25070fa0fb3810290c0e6cd4862b54a8fb975a1ee8dc55a333e",
];
pub(super) const LOAD_NODE: [&str; 2] = [
    "composition_interfaces::srv::dds_::LoadNode_",
    "RIHS01_2e521ef6066fba6d7fc3a3b175d486709f01b4d738d9a59188858546fc8e5acd",
];
pub(super) const CLOCK: [&str; 2] = [
    "rosgraph_msgs::msg::dds_::Clock_",
    "RIHS01_692f7a66e93a3c83e71765d033b60349ba68023a8c689a79e48078bcb5c58564",
];
pub(super) const LOG: [&str; 2] = [
    "rcl_interfaces::msg::dds_::Log_",
    "RIHS01_e28ce254ca8abc06abf92773b74602cdbf116ed34fbaf294fb9f81da9f318eac",
];
pub(super) const FLOAT: [&str; 2] = [
    "std_msgs::msg::dds_::Float64_",
    "RIHS01_705ba9c3d1a09df43737eb67095534de36fd426c0587779bda2bc51fe790182a",
];
