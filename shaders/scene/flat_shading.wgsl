//@ alternative shading when !smooth
//@ use geometry/offset
// Surfaces without vertex normals: light scatters around the surface's own normal.

// The normal for the material. `facing` is the surface's own normal, on the side from which the ray comes.
fn shading_normal(hit: Hit, surface: Surface, incoming: vec3<f32>, facing: vec3<f32>) -> vec3<f32> {
    return facing;
}

// The point of an event, from which lights are chosen and sampled. It does not have the offset of leaving rays. With the
// offset, a small lamp would be too bright by twice the offset over its distance.
fn event_point(hit: Hit, surface: Surface, facing: vec3<f32>) -> vec3<f32> {
    return surface.point;
}

// A ray in a direction, starting where it leaves the surface.
fn spawn_ray(
    hit: Hit,
    surface: Surface,
    facing: vec3<f32>,
    shading: vec3<f32>,
    point: vec3<f32>,
    direction: vec3<f32>,
) -> Ray {
    let side = select(facing, -facing, dot(direction, facing) < 0.0);
    return Ray(leave_surface(point, surface.error, side, side), direction);
}
