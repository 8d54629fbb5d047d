//@ use geometry/quad_plane
// A disk: the circle within a square, which the kernel has as a quad.

// A point of the plane from the disk's middle, in radii.
fn disk_offset(ray: Ray, t: f32, square: Quad) -> vec2<f32> {
    return 2.0 * quad_coordinates(ray, t, square) - 1.0;
}

// Distance to the disk, or NO_HIT. As a quad, it is widened by a bound of the rounding error.
fn disk_distance(ray: Ray, square: Quad) -> f32 {
    let t = quad_plane_distance(ray, square);
    // A parallel ray gives no finite t. Every comparison below fails for a NaN.
    if !(t > 0.0) {
        return NO_HIT;
    }
    let slack = 2.0 * quad_slack(ray, t, square).x;
    return select(NO_HIT, t, length(disk_offset(ray, t, square)) <= 1.0 + slack);
}

fn disk_surface(ray: Ray, t: f32, square: Quad) -> Surface {
    let offset = disk_offset(ray, t, square);
    let at = 0.5 + 0.5 * (offset / max(length(offset), 1.0));
    return quad_surface_at(clamp(at, vec2<f32>(0.0), vec2<f32>(1.0)), square);
}

fn disk_uv(square: Quad, point: vec3<f32>, local: vec3<f32>) -> SurfaceUv {
    return SurfaceUv(local.xy, vec2<bool>(false));
}
