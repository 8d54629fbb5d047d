// Wrong on purpose: the edges are tested without an allowance for the rounding of a and b, so that rays pass between
// quads that share an edge.
fn quad_distance(ray: Ray, quad: Quad) -> f32 {
    let from_origin = quad.corner - ray.origin;
    let t = dot(from_origin, quad.normal) / dot(ray.direction, quad.normal);
    // A parallel ray gives no finite t; every comparison below is written so that a NaN fails it.
    if !(t > 0.0) {
        return NO_HIT;
    }
    let on_plane = t * ray.direction - from_origin;
    let a = dot(on_plane, quad.a_axis);
    let b = dot(on_plane, quad.b_axis);
    let inside = a >= 0.0 && a <= 1.0 && b >= 0.0 && b <= 1.0;
    return select(NO_HIT, t, inside);
}

// The point is put back onto the plane as corner + a u + b v.
fn quad_surface(ray: Ray, t: f32, quad: Quad) -> Surface {
    let on_plane = t * ray.direction - (quad.corner - ray.origin);
    let a = clamp(dot(on_plane, quad.a_axis), 0.0, 1.0);
    let b = clamp(dot(on_plane, quad.b_axis), 0.0, 1.0);
    var surface: Surface;
    surface.point = quad.corner + (a * quad.u + b * quad.v);
    surface.normal = quad.normal;
    surface.error = quad.error_across;
    surface.material = quad.material;
    surface.frame = quad.frame;
    surface.local = vec3<f32>(a, b, 0.0);
    return surface;
}

fn quad_uv(quad: Quad, point: vec3<f32>, local: vec3<f32>) -> SurfaceUv {
    return SurfaceUv(local.xy, false);
}
