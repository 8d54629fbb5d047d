//@ use data/ray
//@ use data/primitive
//@ use data/surface
//@ use lib/float

// Distance to the parallelogram, or NO_HIT. The host computes a_axis and b_axis in f64. The edges are widened by a bound of the
// rounding error of a and b, so that quads that share an edge leave no gap. This bound is the error of the quad's points plus
// the error of t, divided by the cosine between ray and normal: an offset of the plane moves the hit point within it by up to
// that much. The bound grows without limit for rays along the plane, so it is limited to 1/64.
fn quad_distance(ray: Ray, quad: Quad) -> f32 {
    let from_origin = quad.corner - ray.origin;
    let facing = dot(ray.direction, quad.normal);
    let t = dot(from_origin, quad.normal) / facing;
    // A parallel ray gives no finite t. Every comparison below fails for a NaN.
    if !(t > 0.0) {
        return NO_HIT;
    }
    let on_plane = t * ray.direction - from_origin;
    let a = dot(on_plane, quad.a_axis);
    let b = dot(on_plane, quad.b_axis);
    let slack = (quad.error + 2.0 * UNIT_ROUNDOFF * (t + length(from_origin))) / abs(facing);
    let a_slack = min(slack * length(quad.a_axis), 0x1p-6f);
    let b_slack = min(slack * length(quad.b_axis), 0x1p-6f);
    let inside = a >= -a_slack && a <= 1.0 + a_slack && b >= -b_slack && b <= 1.0 + b_slack;
    return select(NO_HIT, t, inside);
}

// The point is computed as corner + a u + b v, which puts it back onto the plane.
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

fn quad_uv(point: vec3<f32>, local: vec3<f32>) -> SurfaceUv {
    return SurfaceUv(local.xy, false);
}
