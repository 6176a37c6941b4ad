//! Images as a pinhole would have taken them.

use image::{GrayImage, Luma};
use imageproc::geometric_transformations::{Border, Interpolation, warp_into_with};
use images::Lens;

use crate::lens::shown;

/// Takes the distortion out of the images of one lens.
pub(crate) struct Rectifier {
    width: u32,
    /// For each pixel of the result where it comes from, row by row.
    map: Vec<(f32, f32)>,
    source: GrayImage,
    result: GrayImage,
}

impl Rectifier {
    /// For images of this width and height that `lens` took; the result is what `pinhole` would
    /// have taken.
    pub(crate) fn new((width, height): (u32, u32), pinhole: &Lens, lens: &Lens) -> Self {
        let pixels = (0..height).flat_map(|v| (0..width).map(move |u| (u, v)));
        let map = pixels.map(|(u, v)| {
            let (x, y) = shown(pinhole, lens, u.into(), v.into());
            (x as f32, y as f32)
        });
        Self {
            width,
            map: map.collect(),
            source: GrayImage::new(width, height),
            result: GrayImage::new(width, height),
        }
    }

    /// The rectified image. Where the lens saw nothing it is black.
    ///
    /// # Panics
    /// There are more or fewer pixels than an image has.
    pub(crate) fn rectify(&mut self, pixels: &[u8]) -> &GrayImage {
        self.source.copy_from_slice(pixels);
        let Self { width, map, source, result } = self;
        let from = |u: f32, v: f32| {
            let at = v as usize * *width as usize + u as usize;
            map.get(at).copied().unwrap_or((-1.0, -1.0))
        };
        warp_into_with(source, from, Interpolation::Bilinear, Border::Constant(Luma([0])), result);
        result
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: (u32, u32) = (640, 480);
    const PINHOLE: Lens = Lens { focal: 500.0, cx: 319.5, cy: 239.5, k1: 0.0, k2: 0.0 };

    /// Ideal places of the dots, px: where the pinhole shows them.
    fn dots() -> Vec<(f64, f64)> {
        let columns = (40..=600).step_by(80);
        columns.flat_map(|u| (40..=440).step_by(80).map(move |v| (u.into(), v.into()))).collect()
    }

    /// Brightness of the dots at an ideal place.
    fn brightness(dots: &[(f64, f64)], u: f64, v: f64) -> f64 {
        let near = dots.iter().find(|(x, y)| (u - x).abs() < 20.0 && (v - y).abs() < 20.0);
        near.map_or(0.0, |(x, y)| 255.0 * (-((u - x).powi(2) + (v - y).powi(2)) / 18.0).exp())
    }

    /// The distance from the centre that the lens moves to `distorted`, in focal lengths: found by
    /// halving an interval, so independent of what is tested.
    fn ideal(k1: f64, k2: f64, distorted: f64) -> f64 {
        let (mut low, mut high) = (0.0, 1.25);
        for _ in 0..40 {
            let r: f64 = (low + high) / 2.0;
            let seen = r + k1 * r.powi(3) + k2 * r.powi(5);
            if seen < distorted { low = r } else { high = r }
        }
        (low + high) / 2.0
    }

    /// What a lens with distortion sees of the dots.
    fn photograph(dots: &[(f64, f64)], k1: f64, k2: f64) -> Vec<u8> {
        let pixels = (0..SIZE.1).flat_map(|v| (0..SIZE.0).map(move |u| (u, v)));
        let value = |(u, v): (u32, u32)| {
            let (x, y) = ((f64::from(u) - 319.5) / 500.0, (f64::from(v) - 239.5) / 500.0);
            let r = x.hypot(y);
            let scale = ideal(k1, k2, r) / r;
            brightness(dots, 319.5 + 500.0 * scale * x, 239.5 + 500.0 * scale * y).round() as u8
        };
        pixels.map(value).collect()
    }

    /// Distances of the centres of gravity of the dots from their ideal places, px: mean, largest.
    fn errors(dots: &[(f64, f64)], pixels: &[u8]) -> (f64, f64) {
        let distance = |(x, y): &(f64, f64)| {
            let (mut sum, mut u_sum, mut v_sum) = (0.0, 0.0, 0.0);
            for (at, value) in pixels.iter().enumerate() {
                let (u, v) = ((at % 640) as f64, (at / 640) as f64);
                if (u - x).abs() < 36.0 && (v - y).abs() < 36.0 {
                    let value = f64::from(*value);
                    (sum, u_sum, v_sum) = (sum + value, u_sum + value * u, v_sum + value * v);
                }
            }
            // A dot that is not near its place at all counts as at the edge of what was searched.
            if sum > 0.0 { (u_sum / sum - x).hypot(v_sum / sum - y) } else { 36.0 }
        };
        let all: Vec<f64> = dots.iter().map(distance).collect();
        (all.iter().sum::<f64>() / all.len() as f64, all.iter().copied().fold(0.0, f64::max))
    }

    #[test]
    fn rectification_undoes_the_distortion_of_a_known_lens() {
        let dots = dots();
        for (k1, k2) in [(-0.2, 0.02), (-0.16, 0.01), (0.15, 0.0), (0.0, 0.0)] {
            let photograph = photograph(&dots, k1, k2);
            let lens = Lens { k1, k2, ..PINHOLE };
            let mut rectifier = Rectifier::new(SIZE, &PINHOLE, &lens);
            let (mean, largest) = errors(&dots, rectifier.rectify(&photograph).as_raw());
            println!("k1 {k1}, k2 {k2}: {mean:.3} px, at most {largest:.3} px");
            assert!(mean < 0.1 && largest < 0.5, "k1 {k1}, k2 {k2}: {mean} px, {largest} px");
        }
        // The dots are elsewhere in the photograph itself: the test can fail.
        let (mean, _) = errors(&dots, &photograph(&dots, -0.2, 0.02));
        assert!(mean > 2.0, "{mean} px");
    }

    #[test]
    fn a_lens_of_another_focal_length_and_centre_becomes_the_same_pinhole() {
        let dots = dots();
        let photograph = photograph(&dots, -0.2, 0.02);
        // The same photograph, shifted by whole pixels: the centre of its lens is elsewhere.
        let mut shifted = vec![0; photograph.len()];
        shifted[3 * 640 + 5..].copy_from_slice(&photograph[..photograph.len() - 3 * 640 - 5]);
        let lens = Lens { cx: 324.5, cy: 242.5, k1: -0.2, k2: 0.02, ..PINHOLE };
        let mut rectifier = Rectifier::new(SIZE, &PINHOLE, &lens);
        let (mean, _) = errors(&dots, rectifier.rectify(&shifted).as_raw());
        assert!(mean < 0.1, "{mean} px");
    }
}
