//@ use data/hit
//@ use data/found
// Surfaces without vertex normals: light scatters about the surface's own normal.

// The normal that the material sees; `facing` is the surface's own, on the side that the ray came from.
fn shading_normal(hit: Hit, surface: Surface, incoming: vec3<f32>, facing: vec3<f32>) -> vec3<f32> {
    return facing;
}

// Where an event on the side of `facing` is: there it chooses a light and aims at it, and from there, but for the offset, rays to that side
// leave.
fn event_point(hit: Hit, surface: Surface, facing: vec3<f32>) -> vec3<f32> {
    return surface.point;
}
