//@ use data/hit
//@ use choice/offset
// Where a ray in such a direction leaves from, after an event at a point: what goes below the shading normal leaves the surface itself.
fn leaving_point(
    surface: Surface,
    facing: vec3<f32>,
    shading: vec3<f32>,
    point: vec3<f32>,
    direction: vec3<f32>,
) -> vec3<f32> {
    let below = dot(direction, shading) < 0.0;
    let side = select(facing, -facing, below);
    return leave_surface(select(point, surface.point, below), surface.error, side, side);
}
