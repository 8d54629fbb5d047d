//@ use geometry/quad_plane

// Distance to the parallelogram, or NO_HIT. The host computes a_axis and b_axis in f64. The edges are widened by the slack, so that
// quads that share an edge leave no gap.
fn quad_distance(ray: Ray, quad: Quad) -> f32 {
    let t = quad_plane_distance(ray, quad);
    // A parallel ray gives no finite t. Every comparison below fails for a NaN.
    if !(t > 0.0) {
        return NO_HIT;
    }
    let at = quad_coordinates(ray, t, quad);
    let slack = quad_slack(ray, t, quad);
    return select(NO_HIT, t, all(at >= -slack) && all(at <= 1.0 + slack));
}

fn quad_surface(ray: Ray, t: f32, quad: Quad) -> Surface {
    return quad_surface_at(clamp(quad_coordinates(ray, t, quad), vec2<f32>(0.0), vec2<f32>(1.0)), quad);
}

fn quad_uv(quad: Quad, point: vec3<f32>, local: vec3<f32>) -> SurfaceUv {
    return SurfaceUv(local.xy, vec2<bool>(false));
}
