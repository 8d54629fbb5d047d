//@ use data/hit
//@ use data/found
//@ use choice/offset
// Surfaces without vertex normals: light scatters about the surface's own normal.

// The normal that the material sees; `facing` is the surface's own, on the side that the ray came from.
fn shading_normal(hit: Hit, surface: Surface, incoming: vec3<f32>, facing: vec3<f32>) -> vec3<f32> {
    return facing;
}

// Where a ray in such a direction leaves from.
fn leaving_point(
    hit: Hit,
    surface: Surface,
    facing: vec3<f32>,
    shading: vec3<f32>,
    direction: vec3<f32>,
) -> vec3<f32> {
    return leave_surface(surface.point, surface.error, surface.normal, direction);
}
