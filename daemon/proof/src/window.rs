//! Accepts each number of a session once, in whatever order they arrive (a sliding window against
//! replays).

/// How many numbers behind the greatest one are still accepted: a client has at most this many
/// questions under way.
const WIDTH: u64 = 64;

/// The numbers used so far, of those that are not too old.
#[derive(Clone, Debug, Default)]
pub struct Window {
    /// The greatest number used.
    last: u64,
    /// Bit n is set if `last - n` was used.
    used: u64,
}

impl Window {
    /// Marks a number as used. Returns `false` if it was used before, or is too old to tell.
    pub fn take(&mut self, number: u64) -> bool {
        if number > self.last {
            let steps = number - self.last;
            self.used = if steps < WIDTH { self.used << steps } else { 0 } | 1;
            self.last = number;
            return true;
        }
        let age = self.last - number;
        if number == 0 || age >= WIDTH || self.used & (1 << age) != 0 {
            return false;
        }
        self.used |= 1 << age;
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_number_is_good_once_in_whatever_order() {
        let mut window = Window::default();
        for number in [1, 3, 2, 70, 64, 69, 7, u64::MAX] {
            assert!(window.take(number), "{number}");
            assert!(!window.take(number), "{number} again");
        }
        for old in [0, 1, 4, 5, 6, 70, u64::MAX - WIDTH] {
            assert!(!window.take(old), "{old}");
        }
        assert!(window.take(u64::MAX - WIDTH + 1));
    }
}
