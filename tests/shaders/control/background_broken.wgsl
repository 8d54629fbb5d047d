//@ use bind/settings
// Wrong on purpose: the square root of a negative number for directions of length 2, and an overflow for those of length 4.
fn solid_background(direction: vec3<f32>) -> vec3<f32> {
    let size = length(direction);
    let nan = sqrt(1.5 - size);
    let infinity = 3e38 * size;
    return settings.background_bottom * select(select(1.0, nan, size > 1.5), infinity, size > 3.0);
}
