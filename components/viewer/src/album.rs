//! What was seen so far.

use genom::NativeType;
use images::{Frame, Time};

use crate::types::Summary;

/// Values of a disparity image per pixel.
const STEPS: f64 = 4.0;

/// What is kept between two images.
#[derive(Default, NativeType)]
#[genom(name = "::viewer::album")]
pub(crate) struct Album {
    pub(crate) left: Page,
    pub(crate) rectified: Page,
    pub(crate) disparity: Page,
}

/// The images of a port.
#[derive(Default)]
pub(crate) struct Page {
    /// Dates of the first one and of the last one.
    dates: Option<(Time, Time)>,
    count: u32,
}

impl Page {
    /// Whether an image is new: its date is not that of the last one.
    pub(crate) fn turn(&mut self, stamp: Time) -> bool {
        let (first, last) = self.dates.unwrap_or((stamp, stamp));
        if self.count > 0 && last == stamp {
            return false;
        }
        self.dates = Some((first, stamp));
        self.count = self.count.saturating_add(1);
        true
    }

    /// Whether it is the turn of this image to be written.
    pub(crate) fn is_due(&self, every: u32) -> bool {
        every > 0 && self.count.saturating_sub(1).is_multiple_of(every)
    }

    /// Number of images.
    pub(crate) fn count(&self) -> u32 {
        self.count
    }

    /// Date of the last image.
    pub(crate) fn last(&self) -> Time {
        self.dates.unwrap_or_default().1
    }

    /// Images per second, by their dates.
    fn rate(&self) -> f64 {
        let (first, last) = self.dates.unwrap_or_default();
        let elapsed = last.seconds() - first.seconds();
        if elapsed > 0.0 { f64::from(self.count - 1) / elapsed } else { 0.0 }
    }
}

impl Album {
    /// Takes the last disparity image into account.
    pub(crate) fn report(&self, disparity: &Frame, seen: &mut Summary) {
        seen.images = self.disparity.count;
        seen.rate = self.disparity.rate();
        (seen.disparity, seen.known) = mean(&disparity.data);
    }
}

/// The mean of the known disparities, px, and which part they are of all.
fn mean(disparities: &[u8]) -> (f64, f64) {
    let known = disparities.iter().filter(|value| **value > 0).count();
    let sum: u64 = disparities.iter().map(|value| u64::from(*value)).sum();
    let (all, known) = (disparities.len().max(1) as f64, known as f64);
    (sum as f64 / known.max(1.0) / STEPS, known / all)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_leaves_out_what_is_unknown() {
        assert_eq!(mean(&[0, 40, 80, 0]), (15.0, 0.5));
        assert_eq!(mean(&[0, 0]), (0.0, 0.0));
        assert_eq!(mean(&[]), (0.0, 0.0));
    }

    #[test]
    fn an_image_counts_once_and_the_rate_is_that_of_the_dates() {
        let at = |nanosec| Time { sec: 3, nanosec };
        let mut page = Page::default();
        assert_eq!([at(0), at(0)].map(|stamp| page.turn(stamp)), [true, false]);
        assert_eq!((page.rate(), page.is_due(2), page.is_due(0)), (0.0, true, false));
        assert_eq!(
            [250_000_000, 500_000_000].map(|at| page.turn(Time { sec: 3, nanosec: at })),
            [true; 2]
        );
        assert_eq!((page.rate(), page.last(), page.is_due(2)), (4.0, at(500_000_000), true));
        assert!(!page.is_due(3));
    }
}
