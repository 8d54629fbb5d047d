//@ alternative round_lens when projection.calibrated_fisheye
//@ use camera/radial
// OpenCV's fisheye lens (Kannala, Brandt, "A Generic Camera Model and Calibration Method", IEEE TPAMI 28(8), 2006, equation 6).

// The distance of an angle, and its derivative; 0 behind the fold.
fn lens_distance(angle: f32) -> vec2<f32> {
    let found = radial_of(angle);
    return vec2<f32>(found.x, select(0.0, found.y, angle < settings.fold));
}

// The angle of a distance, or -1 where there is none.
fn lens_angle(r: f32) -> f32 {
    let angle = inverse_radial(r);
    return select(-1.0, angle, abs(radial_of(angle).x - r) <= 1e-5 * (1.0 + r));
}
