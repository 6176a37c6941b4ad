//! Reads server-sent events, of which any piece may arrive at any time.

use serde_json::Value;

/// An event.
#[derive(Debug, PartialEq)]
pub(crate) struct Block {
    /// Its `id`.
    pub(crate) id: Option<String>,
    /// Its `event`.
    pub(crate) kind: Option<String>,
    /// Its data, as JSON.
    pub(crate) data: Value,
}

/// What arrived and is not a whole event yet.
#[derive(Debug, Default)]
pub(crate) struct Blocks(Vec<u8>);

impl Blocks {
    /// The events that are complete with these bytes. Comments and data that are no JSON are left
    /// out.
    pub(crate) fn add(&mut self, bytes: &[u8]) -> Vec<Block> {
        self.0.extend_from_slice(bytes);
        let mut found = Vec::new();
        while let Some(end) = self.0.windows(2).position(|pair| pair == b"\n\n") {
            let rest = self.0.split_off(end + 2);
            let block = std::mem::replace(&mut self.0, rest);
            found.extend(parse(&String::from_utf8_lossy(&block)));
        }
        found
    }
}

fn parse(text: &str) -> Option<Block> {
    let field = |name: &str| {
        let lines = text.lines().filter_map(|line| line.strip_prefix(name)?.strip_prefix(':'));
        let lines: Vec<_> = lines.map(|value| value.strip_prefix(' ').unwrap_or(value)).collect();
        (!lines.is_empty()).then(|| lines.join("\n"))
    };
    let data = serde_json::from_str(&field("data")?).ok()?;
    Some(Block { id: field("id"), kind: field("event"), data })
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn events_are_read_however_they_are_cut() {
        let text =
            b": comment\n\nevent: log\nid: 7\ndata: {\"a\":\ndata: 1}\n\ndata: no\n\ndata:2\n\n";
        let wanted = [
            Block { id: Some("7".into()), kind: Some("log".into()), data: json!({"a": 1}) },
            Block { id: None, kind: None, data: json!(2) },
        ];
        for size in 1..text.len() {
            let mut blocks = Blocks::default();
            let found: Vec<_> = text.chunks(size).flat_map(|piece| blocks.add(piece)).collect();
            assert_eq!(found, wanted, "pieces of {size} bytes");
        }
    }
}
