//! Two renders of one scene with one seed, on drivers or by kernels that round otherwise.

use super::device::software;
use gpu_rt::metrics::error::{RELATIVE_FLOOR, relative_variance, relmse};

/// The largest share of the noise that such renders may differ by (docs/promises.md). Its square, 4 %, is about the share of the paths that go
/// another way from some event on: their light is independent then. Where all quotients and roots are off by an ULP, 1 % of the paths of the
/// scenes do.
pub const PARTED: f64 = 0.2;

/// The root of the mean square difference of `a` and `b`, relative to that of independent renders of the variance of `a`: 1 for other seeds, and
/// 0 for the same image.
pub fn share_of_noise(a: &[[f32; 3]], variance: &[[f32; 3]], b: &[[f32; 3]]) -> f64 {
    let noise = relative_variance(variance, a, RELATIVE_FLOOR).expect("an image");
    (relmse(b, a).expect("images of one size") / (2.0 * noise)).sqrt()
}

/// Whether a render with the same seed, by kernels of other code, is what is promised: the same bytes on software drivers, which is `same`, and
/// little else on others.
pub fn is_as_promised(same: bool, a: &[[f32; 3]], variance: &[[f32; 3]], b: &[[f32; 3]]) -> bool {
    same || !software().name.software && share_of_noise(a, variance, b) < PARTED
}
