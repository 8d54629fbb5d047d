//@ implements inner_reflections when inner_reflections
// A slab with two parallel sides. Light that enters is reflected between them, and some leaves each time: R + (1 - R)^2 R (1 + R^2 + R^4 + ...) =
// 2 R / (1 + R) of it on the near side, the rest on the far side.
fn with_inner_reflections(reflectance: f32, inner: f32) -> f32 {
    return select(reflectance, 2.0 * reflectance / (1.0 + reflectance), inner > 0.0);
}

//@ without
// No pane has inner reflections.
fn with_inner_reflections(reflectance: f32, inner: f32) -> f32 {
    return reflectance;
}
