//! Finds the end of a bottle that arrives in pieces: replies come without a length.

use super::{MOST_DEPTH, NoBottle, tag, width};

/// How far a bottle was seen.
#[derive(Debug, Default)]
pub(crate) struct Skim {
    at: usize,
    begun: bool,
    /// Of each open list, the number of elements left and their common tag.
    open: Vec<(u32, Option<u32>)>,
}

fn word(bytes: &[u8], at: usize) -> Option<u32> {
    let bytes = bytes.get(at..at.checked_add(4)?)?;
    bytes.try_into().ok().map(u32::from_le_bytes)
}

fn length(bytes: &[u8], at: usize) -> Result<Option<u32>, NoBottle> {
    match word(bytes, at) {
        Some(length) if i32::try_from(length).is_err() => Err(NoBottle::Negative),
        length => Ok(length),
    }
}

fn common(code: u32) -> Option<u32> {
    Some(code & !tag::LIST).filter(|tag| *tag != 0)
}

impl Skim {
    /// The length of the bottle that `bytes` begins with; `None` while it has not arrived. Each
    /// call goes on where the last one ended.
    pub(crate) fn end(&mut self, bytes: &[u8]) -> Result<Option<usize>, NoBottle> {
        if !self.begun {
            let Some(code) = word(bytes, 0) else { return Ok(None) };
            if code & tag::LIST == 0 {
                return Err(NoBottle::Tag(code));
            }
            let Some(count) = length(bytes, 4)? else { return Ok(None) };
            self.open.push((count, common(code)));
            (self.at, self.begun) = (8, true);
        }
        while let Some((left, shared)) = self.open.last_mut() {
            if *left == 0 {
                self.open.pop();
                continue;
            }
            if let Some(width) = shared.and_then(width) {
                let there = bytes.len().saturating_sub(self.at) / width;
                let passed = (*left as usize).min(there);
                self.at += passed * width;
                *left -= passed as u32;
                if *left > 0 {
                    return Ok(None);
                }
                continue;
            }
            let (code, after) = match *shared {
                Some(code) => (code, self.at),
                None => match word(bytes, self.at) {
                    Some(code) => (code, self.at + 4),
                    None => return Ok(None),
                },
            };
            let end = match (width(code), code) {
                (Some(width), _) => after + width,
                (None, tag::STRING | tag::BLOB) => match length(bytes, after)? {
                    Some(length) => after + 4 + length as usize,
                    None => return Ok(None),
                },
                (None, list) if list & tag::LIST != 0 => {
                    let Some(count) = length(bytes, after)? else { return Ok(None) };
                    *left -= 1;
                    self.at = after + 4;
                    if self.open.len() >= MOST_DEPTH {
                        return Err(NoBottle::Deep);
                    }
                    self.open.push((count, common(list)));
                    continue;
                }
                (None, other) => return Err(NoBottle::Tag(other)),
            };
            if end > bytes.len() {
                return Ok(None);
            }
            *left -= 1;
            self.at = end;
        }
        Ok(Some(self.at))
    }
}

#[cfg(test)]
mod tests {
    use super::super::Value;
    use super::*;

    #[test]
    fn the_end_of_a_bottle_is_found_however_it_arrives() {
        let text = r#"1 2.5 hello (1 2 3) ("a" (x {1 2} [ok])) ()"#;
        let bottle = Value::parse(text).unwrap();
        let bytes = Value::to_bottle(&bottle);
        for step in 1..bytes.len() {
            let mut skim = Skim::default();
            let mut seen = 0;
            loop {
                seen = (seen + step).min(bytes.len());
                match skim.end(&bytes[..seen]).unwrap() {
                    Some(end) => {
                        assert_eq!((end, seen), (bytes.len(), bytes.len()));
                        break;
                    }
                    None => assert!(seen < bytes.len()),
                }
            }
        }
    }

    #[test]
    fn what_is_no_bottle_is_refused_as_soon_as_that_shows() {
        let head = |code: u32, count: i32| [code.to_le_bytes(), count.to_le_bytes()].concat();
        assert_eq!(Skim::default().end(&head(7, 1)), Err(NoBottle::Tag(7)));
        assert_eq!(Skim::default().end(&head(256, -1)), Err(NoBottle::Negative));
        assert_eq!(Skim::default().end(&head(256 + 3, 1)), Err(NoBottle::Tag(3)));
        assert_eq!(Skim::default().end(&head(256 + 1, i32::MAX)), Ok(None), "it is cut");
        let deep: Vec<u8> = (0..200).flat_map(|_| [256u32, 1]).flat_map(u32::to_le_bytes).collect();
        assert_eq!(Skim::default().end(&deep), Err(NoBottle::Deep));
    }
}
