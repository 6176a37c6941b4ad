//! Which numbers of a session were used: each is good once, in whatever order they arrive.

/// Numbers that may arrive late: as many as a client's threads ask at a time.
const WIDTH: u64 = 64;

/// The numbers used, as far as they can still be told apart.
#[derive(Clone, Debug, Default)]
pub struct Window {
    /// The greatest that was used.
    last: u64,
    /// Bit n: `last - n` was used.
    used: u64,
}

impl Window {
    /// Uses a number; `false` if it was used before, or is too old to tell.
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
