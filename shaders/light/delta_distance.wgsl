//@ use light/delta
// The length of a shadow ray. It ends before the light by more than the rounding of a surface that the light lies on, but at most
// by half its length.
fn delta_light_distance(origin: vec3<f32>, direction: vec3<f32>, light: DeltaLight) -> f32 {
    let distance = dot(to_delta_light(origin, light), direction);
    let magnitude = abs(light.position);
    let rounding = 0x1p-20f * (max(max(magnitude.x, magnitude.y), magnitude.z) + distance);
    return max(distance - rounding, 0.5 * distance);
}
