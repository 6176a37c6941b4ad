//! Lenses with radial distortion: the first two terms of the model of D. C. Brown, *Close-range
//! camera calibration*, Photogrammetric Engineering, 1971.

use images::Lens;

/// Where `lens` shows what `pinhole`, at the same place, shows at `(u, v)`. All in pixels; the
/// distortion of `pinhole` is not used.
pub(crate) fn shown(pinhole: &Lens, lens: &Lens, u: f64, v: f64) -> (f64, f64) {
    let (x, y) = ((u - pinhole.cx) / pinhole.focal, (v - pinhole.cy) / pinhole.focal);
    let r2 = x * x + y * y;
    let scale = 1.0 + r2 * (lens.k1 + r2 * lens.k2);
    (lens.cx + lens.focal * scale * x, lens.cy + lens.focal * scale * y)
}
