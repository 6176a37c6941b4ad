//! Block matching: how far each pixel moves to the left from the left image to the right one.
//!
//! The cost of a disparity is the sum of absolute differences of the blocks around two pixels. Sums
//! are kept up to date as the block moves by a pixel, so that its size does not matter for the
//! time. A disparity counts if a search from the right image finds the same, and is interpolated
//! between pixels: H. Hirschmüller, P. Innocent, J. Garibaldi, *Real-time correlation-based stereo
//! vision with reduced border errors*, International Journal of Computer Vision 47, 2002.
//!
//! Inner loops run over disparities, which lie side by side in memory, so that the compiler makes
//! vector instructions of them.

/// Number of disparities that are compared: 0 to 63 px.
const COUNT: usize = 64;
/// Sides of blocks. The cost of 11 x 11 pixels, each 255 at most, is within an `i16`.
pub(crate) const SIDES: [u32; 5] = [3, 5, 7, 9, 11];
/// Values of the result per pixel of disparity.
const STEPS: f32 = 4.0;

/// The costs of all disparities.
type Costs = [i16; COUNT];

/// All disparities, to be compared with their costs.
const DISPARITIES: Costs = {
    let mut all = [0; COUNT];
    let mut at = 0;
    while at < COUNT {
        all[at] = at as i16;
        at += 1;
    }
    all
};

/// Compares images of one size, and keeps its buffers.
pub(crate) struct Matcher {
    width: usize,
    height: usize,
    /// Rows of the right image, each from right to left, so that disparities go up with the index,
    /// and then its leftmost pixel as often as there are disparities.
    reversed: Vec<u8>,
    /// For each column of the left image: costs, summed over the rows of a block.
    columns: Vec<Costs>,
    /// For each pixel of a row: costs, summed over its block.
    blocks: Vec<Costs>,
    /// For each pixel of a row of the right image, from right to left: the least cost, and the
    /// disparity that has it.
    least: Vec<i16>,
    place: Vec<i16>,
    found: Vec<u8>,
}

impl Matcher {
    /// For images of this width and height.
    pub(crate) fn new((width, height): (u32, u32)) -> Self {
        let (columns, rows) = (width as usize, height as usize);
        Self {
            width: columns,
            height: rows,
            reversed: vec![0; rows * (columns + COUNT)],
            columns: vec![[0; COUNT]; columns],
            blocks: vec![[0; COUNT]; columns],
            least: vec![0; columns + COUNT],
            place: vec![0; columns + COUNT],
            found: vec![0; columns * rows],
        }
    }

    /// The disparity of each pixel of `left` in quarters of a pixel, row by row; 0 where it is
    /// unknown. `block` is one of [`SIDES`].
    ///
    /// # Panics
    /// An image has another size.
    pub(crate) fn compare(&mut self, left: &[u8], right: &[u8], block: u32) -> &[u8] {
        let radius = block as usize / 2;
        self.found.fill(0);
        if self.width > 2 * radius && self.height > 2 * radius {
            self.reverse(right);
            self.columns.fill([0; COUNT]);
            (0..2 * radius).for_each(|row| self.sum(left, row, i16::wrapping_add));
            for row in radius..self.height - radius {
                self.sum(left, row + radius, i16::wrapping_add);
                self.sum_blocks(radius);
                self.sum(left, row - radius, i16::wrapping_sub);
                self.search_from_right(radius);
                self.choose(row, radius);
            }
        }
        &self.found
    }

    fn reverse(&mut self, right: &[u8]) {
        let rows = self.reversed.chunks_exact_mut(self.width + COUNT);
        for (to, from) in rows.zip(right.chunks_exact(self.width)) {
            let (pixels, rest) = to.split_at_mut(self.width);
            pixels.copy_from_slice(from);
            pixels.reverse();
            rest.fill(from[0]);
        }
    }

    /// Adds the costs of a row to the columns, or takes them away.
    fn sum(&mut self, left: &[u8], row: usize, with: impl Fn(i16, i16) -> i16) {
        let left = &left[row * self.width..][..self.width];
        let right = &self.reversed[row * (self.width + COUNT)..][..self.width + COUNT];
        for (x, (costs, value)) in self.columns.iter_mut().zip(left).enumerate() {
            let right = disparities(&right[self.width - 1 - x..]);
            for (cost, other) in costs.iter_mut().zip(right) {
                *cost = with(*cost, value.abs_diff(*other).into());
            }
        }
    }

    /// Sums the columns of each block.
    fn sum_blocks(&mut self, radius: usize) {
        let mut sums = [0; COUNT];
        for column in &self.columns[..2 * radius] {
            change(&mut sums, column, i16::wrapping_add);
        }
        for x in radius..self.width - radius {
            change(&mut sums, &self.columns[x + radius], i16::wrapping_add);
            self.blocks[x] = sums;
            change(&mut sums, &self.columns[x - radius], i16::wrapping_sub);
        }
    }

    /// Finds for each pixel of the right image the disparity of least cost.
    fn search_from_right(&mut self, radius: usize) {
        self.least.fill(i16::MAX);
        for x in radius..self.width - radius {
            let at = self.width - 1 - x;
            let (Some(least), Some(place)) =
                (self.least[at..].first_chunk_mut(), self.place[at..].first_chunk_mut())
            else {
                continue;
            };
            keep_least(least, place, &self.blocks[x]);
        }
    }

    /// Finds the disparity of each pixel of a row.
    fn choose(&mut self, row: usize, radius: usize) {
        let found = &mut self.found[row * self.width..][..self.width];
        let inside = found.iter_mut().enumerate().take(self.width - radius).skip(radius);
        for (x, found) in inside {
            let costs = &self.blocks[x];
            let at = place_of_least(costs);
            // The block in the right image would be outside.
            if at + radius > x {
                continue;
            }
            // What only the left lens sees: from the right image another pixel fits better.
            let back = self.place[self.width - 1 - x + at];
            if (back - DISPARITIES[at]).abs() <= 1 {
                *found = interpolated(costs, at);
            }
        }
    }
}

/// The first values of a row, one for each disparity.
fn disparities(row: &[u8]) -> &[u8; COUNT] {
    row.first_chunk().unwrap_or(&[0; COUNT])
}

/// Takes over the costs that are less than those known, with their disparities.
fn keep_least(least: &mut Costs, place: &mut Costs, costs: &Costs) {
    for at in 0..COUNT {
        // All bits, or none: without a branch.
        let better = -i16::from(costs[at] < least[at]);
        place[at] = (DISPARITIES[at] & better) | (place[at] & !better);
        least[at] = costs[at].min(least[at]);
    }
}

/// The first disparity of least cost.
fn place_of_least(costs: &Costs) -> usize {
    let least = |costs: &[i16]| costs.iter().fold(i16::MAX, |least, cost| least.min(*cost));
    let all = least(costs);
    // Whole parts are skipped by vector instructions.
    let (parts, _) = costs.as_chunks::<16>();
    let part = parts.iter().position(|part| least(part) == all).unwrap_or(0);
    16 * part + parts[part].iter().position(|cost| *cost == all).unwrap_or(0)
}

fn change(sums: &mut Costs, costs: &Costs, with: impl Fn(i16, i16) -> i16) {
    sums.iter_mut().zip(costs).for_each(|(sum, cost)| *sum = with(*sum, *cost));
}

/// The disparity, between pixels, where two lines through the least cost and those beside it meet:
/// sums of absolute differences go up in proportion to the distance.
fn interpolated(costs: &Costs, at: usize) -> u8 {
    let between = match (at.checked_sub(1).and_then(|before| costs.get(before)), costs.get(at + 1))
    {
        (Some(before), Some(after)) => {
            let [before, least, after] = [*before, costs[at], *after].map(f32::from);
            let slope = before.max(after) - least;
            if slope > 0.0 { (before - after) / (2.0 * slope) } else { 0.0 }
        }
        _ => 0.0,
    };
    ((at as f32 + between) * STEPS).round() as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: (u32, u32) = (200, 90);

    /// Grey values without a pattern, the same in each run.
    fn texture(u: i64, v: i64) -> u8 {
        let mixed = (u * 0x9e37_79b1 + v * 0x85eb_ca6b).wrapping_mul(0x27d4_eb2f_1656_67c5);
        (mixed >> 37) as u8
    }

    /// A square before a background; for the right lens moved to the left by 20 px and by 6.
    fn scene(right: bool) -> Vec<u8> {
        let (near, far) = if right { (20, 6) } else { (0, 0) };
        let pixels =
            (0..i64::from(SIZE.1)).flat_map(|v| (0..i64::from(SIZE.0)).map(move |u| (u, v)));
        let value = |(u, v): (i64, i64)| {
            if (80..140).contains(&(u + near)) && (20..70).contains(&v) {
                texture(u + near, v + 1000)
            } else {
                texture(u + far, v)
            }
        };
        pixels.map(value).collect()
    }

    fn at(pixels: &[u8], u: usize, v: usize) -> u8 {
        pixels[v * SIZE.0 as usize + u]
    }

    #[test]
    fn known_disparities_are_found_within_a_quarter_of_a_pixel() {
        let (left, right) = (scene(false), scene(true));
        for block in SIDES {
            let mut matcher = Matcher::new(SIZE);
            let found = matcher.compare(&left, &right, block);
            let near = |u: usize, v: usize, wanted: u8| {
                let found = at(found, u, v);
                assert!(found.abs_diff(wanted) <= 1, "block {block}, ({u}, {v}): {found}");
            };
            for v in (30..60).step_by(5) {
                near(110, v, 80);
                near(170, v, 24);
            }
        }
    }

    #[test]
    fn what_only_one_lens_sees_is_unknown() {
        let mut matcher = Matcher::new(SIZE);
        let found = matcher.compare(&scene(false), &scene(true), 5);
        // Beside the square, on the left, 14 columns are hidden from the right lens.
        let hidden = (30..60).flat_map(|v| (70..76).map(move |u| (u, v)));
        let unknown = hidden.filter(|(u, v)| at(found, *u, *v) == 0).count();
        assert!(unknown > 150, "{unknown} of 180 pixels");
        // At the left edge the right image has nothing to compare with.
        assert!((0..90).all(|v| at(found, 4, v) == 0));
    }

    #[test]
    fn disparities_between_pixels_are_interpolated() {
        // A smooth texture, shifted by half a pixel.
        let wave =
            |u: f64, v: f64| 127.0 + 60.0 * (u / 3.1 + v / 5.0).sin() + 60.0 * (u / 8.3).sin();
        let image = |shift: f64| -> Vec<u8> {
            let pixels = (0..SIZE.1).flat_map(|v| (0..SIZE.0).map(move |u| (u, v)));
            pixels.map(|(u, v)| wave(f64::from(u) + shift, f64::from(v)).round() as u8).collect()
        };
        let mut matcher = Matcher::new(SIZE);
        let found = matcher.compare(&image(0.0), &image(10.5), 9);
        let middle = (20..70).flat_map(|v| (100..180).map(move |u| (u, v)));
        let values: Vec<u8> = middle.map(|(u, v)| at(found, u, v)).collect();
        let near = values.iter().filter(|value| (41..=43).contains(*value)).count();
        assert!(near * 10 > values.len() * 8, "{near} of {} are 10.5 px", values.len());
    }

    #[test]
    fn images_smaller_than_a_block_have_no_disparities() {
        for size in [(4, 4), (11, 2), (1, 60)] {
            let image = vec![7; size.0 as usize * size.1 as usize];
            assert!(Matcher::new(size).compare(&image, &image, 11).iter().all(|value| *value == 0));
        }
    }

    /// The greatest cost is within the type of costs.
    #[test]
    fn black_compared_with_white_does_not_overflow() {
        let (black, white) = (vec![0; 18_000], vec![255; 18_000]);
        let mut matcher = Matcher::new(SIZE);
        matcher.compare(&black, &white, 11);
        assert!(matcher.blocks[100].iter().all(|cost| *cost == 121 * 255));
    }
}
