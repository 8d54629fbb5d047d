//@ use geometry/slab

fn to_cuboid(cuboid: Cuboid, v: vec3<f32>) -> vec3<f32> {
    let z_axis = cross(cuboid.x_axis, cuboid.y_axis);
    return vec3<f32>(dot(cuboid.x_axis, v), dot(cuboid.y_axis, v), dot(z_axis, v));
}

fn cuboid_slab(ray: Ray, cuboid: Cuboid) -> Slab {
    let origin = to_cuboid(cuboid, ray.origin - cuboid.center);
    let direction = to_cuboid(cuboid, ray.direction);
    return slab(origin, slab_inverse(direction), -cuboid.half_extent, cuboid.half_extent);
}

// The distances at which the ray's line enters and leaves the cuboid. The line misses it if the first is larger.
fn cuboid_crossings(s: Slab) -> vec2<f32> {
    return vec2<f32>(max(max(s.enter.x, s.enter.y), s.enter.z), min(min(s.leave.x, s.leave.y), s.leave.z));
}

// Distance to the nearest face in front of the origin, or NO_HIT. Both crossings come from one test, so that no ray
// slips between two faces.
fn cuboid_distance(ray: Ray, cuboid: Cuboid) -> f32 {
    let t = cuboid_crossings(cuboid_slab(ray, cuboid));
    if !(t.x <= t.y) || !(t.y > 0.0) {
        return NO_HIT;
    }
    return select(t.y, t.x, t.x > 0.0);
}

// Bound of the rounding error of a point on a face along the normal, plus the error of the next distance that is computed from
// the point. Own derivation, in units of roundoff. h are the half edges as vectors and c is the centre. Their components are
// weighted by those of the normal:
// - The point is off by 3 |h|. Adding the centre adds |c| + |h|.
// - The origin of the next ray, in the box's axes, is off by |h| from the difference and by 3 |h| from the products and sums.
// - The axes are rounded and not exactly perpendicular: 2 |h| on the way to render space, and 2 |h| on the way back.
// For a box along the axes of render space, only one of the half edges has a component along the normal.
fn cuboid_error(cuboid: Cuboid, normal: vec3<f32>) -> f32 {
    let z_axis = cross(cuboid.x_axis, cuboid.y_axis);
    let h = cuboid.half_extent;
    let extent = h.x * abs(cuboid.x_axis) + h.y * abs(cuboid.y_axis) + h.z * abs(z_axis);
    return UNIT_ROUNDOFF * dot(abs(normal), 2.0 * abs(cuboid.center) + 12.0 * extent);
}

// Finds the hit face with the same arithmetic as the distance: it is the face whose crossing is t. Then puts
// the point back onto that face.
fn cuboid_surface(ray: Ray, t: f32, cuboid: Cuboid) -> Surface {
    let s = cuboid_slab(ray, cuboid);
    let enter = cuboid_crossings(s).x;
    let at_face = select(s.leave, s.enter, enter > 0.0);
    let off = abs(at_face - vec3<f32>(t));
    var axis = select(vec3<f32>(0.0, 0.0, 1.0), vec3<f32>(0.0, 1.0, 0.0), off.y <= off.z);
    axis = select(axis, vec3<f32>(1.0, 0.0, 0.0), off.x <= off.y && off.x <= off.z);
    let direction = to_cuboid(cuboid, ray.direction);
    let outward = select(sign(direction), -sign(direction), enter > 0.0) * axis;
    let free = to_cuboid(cuboid, ray.origin - cuboid.center) + t * direction;
    let within = clamp(free, -cuboid.half_extent, cuboid.half_extent);
    let local = select(within, outward * cuboid.half_extent, axis != vec3<f32>(0.0));
    let z_axis = cross(cuboid.x_axis, cuboid.y_axis);
    var surface: Surface;
    surface.point = cuboid.center + (local.x * cuboid.x_axis + local.y * cuboid.y_axis + local.z * z_axis);
    surface.normal = outward.x * cuboid.x_axis + outward.y * cuboid.y_axis + outward.z * z_axis;
    surface.error = cuboid_error(cuboid, surface.normal);
    surface.material = cuboid.material;
    surface.frame = cuboid.frame;
    // From 0 at the low corner to 1 at the high one. Along the normal of the hit face it is exactly 0 or 1. (Where x / x may be more than 1, so may
    // the quotient.)
    let on_face = clamp(0.5 + 0.5 * (local / cuboid.half_extent), vec3<f32>(0.0), vec3<f32>(1.0));
    surface.local = select(on_face, 0.5 + 0.5 * outward, axis != vec3<f32>(0.0));
    return surface;
}

// 0..1 over each face. Seen from outside, u goes right and v goes up. On the top and the bottom, u goes along x.
fn cuboid_uv(cuboid: Cuboid, point: vec3<f32>, local: vec3<f32>) -> SurfaceUv {
    if local.z == 0.0 || local.z == 1.0 {
        return SurfaceUv(vec2<f32>(select(local.x, 1.0 - local.x, local.z == 0.0), local.y), vec2<bool>(false));
    }
    if local.x == 0.0 || local.x == 1.0 {
        return SurfaceUv(vec2<f32>(select(local.z, 1.0 - local.z, local.x == 1.0), local.y), vec2<bool>(false));
    }
    return SurfaceUv(vec2<f32>(local.x, select(local.z, 1.0 - local.z, local.y == 1.0)), vec2<bool>(false));
}
