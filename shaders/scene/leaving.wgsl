//@ use data/hit
//@ use choice/offset
// Where a ray in such a direction leaves from, after an event at the point `above`: what goes below the shading normal leaves the
// surface itself.
fn leaving_point(
    surface: Surface,
    facing: vec3<f32>,
    shading: vec3<f32>,
    above: vec3<f32>,
    direction: vec3<f32>,
) -> vec3<f32> {
    let below = leave_surface(surface.point, surface.error, facing, -facing);
    return select(above, below, dot(direction, shading) < 0.0);
}
