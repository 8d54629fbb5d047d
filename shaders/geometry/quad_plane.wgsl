// The plane of a quad, and of the square around a disk.

// Distance to the plane; not finite for a parallel ray.
fn quad_plane_distance(ray: Ray, quad: Quad) -> f32 {
    return dot(quad.corner - ray.origin, quad.normal) / dot(ray.direction, quad.normal);
}

// The coordinates a and b of a point on the plane.
fn quad_coordinates(ray: Ray, t: f32, quad: Quad) -> vec2<f32> {
    let on_plane = t * ray.direction - (quad.corner - ray.origin);
    return vec2<f32>(dot(on_plane, quad.a_axis), dot(on_plane, quad.b_axis));
}

// A bound of the rounding error of a and b: the error of the quad's points plus the error of t, divided by the cosine between ray and
// normal, since an offset of the plane moves the hit point within it by up to that much. The bound grows without limit for rays along
// the plane, so it is limited to 1/64.
fn quad_slack(ray: Ray, t: f32, quad: Quad) -> vec2<f32> {
    let distances = t + length(quad.corner - ray.origin);
    let slack = (quad.error + 2.0 * UNIT_ROUNDOFF * distances) / abs(dot(ray.direction, quad.normal));
    return min(slack * vec2<f32>(length(quad.a_axis), length(quad.b_axis)), vec2<f32>(0x1p-6f));
}

// The surface at these coordinates. The point is computed as corner + a u + b v, which puts it back onto the plane.
fn quad_surface_at(at: vec2<f32>, quad: Quad) -> Surface {
    var surface: Surface;
    surface.point = quad.corner + (at.x * quad.u + at.y * quad.v);
    surface.normal = quad.normal;
    surface.error = quad.error_across;
    surface.material = quad.material;
    surface.frame = quad.frame;
    surface.local = vec3<f32>(at, 0.0);
    return surface;
}
