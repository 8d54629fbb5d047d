//@ use geometry/cuboid
//@ use light/quad
// A box as a light. From outside, directions are uniform in its solid angle: one of the up to three visible faces is chosen
// with a probability proportional to its solid angle. From inside, directions are uniform over the sphere.

// A box as seen from the point of the event, in the box's own axes.
struct SphericalCuboid {
    // From the point to the centre.
    center: vec3<f32>,
    // Solid angles of the visible faces across x, y and z; all 0 from inside.
    areas: vec3<f32>,
}

// The face across an axis that is turned towards the point: a corner and its two edges.
struct CuboidFace {
    corner: vec3<f32>,
    u: vec3<f32>,
    v: vec3<f32>,
}

fn cuboid_face(center: vec3<f32>, half_extent: vec3<f32>, axis: u32) -> CuboidFace {
    let unit = select(vec3<f32>(0.0), vec3<f32>(1.0), vec3<u32>(axis) == vec3<u32>(0u, 1u, 2u));
    // The face towards the point is on the side opposite to the direction of the centre.
    let side = select(half_extent, -half_extent, center > vec3<f32>(0.0));
    let corner = center + select(-half_extent, side, unit > vec3<f32>(0.0));
    return CuboidFace(corner, 2.0 * half_extent * unit.zxy, 2.0 * half_extent * unit.yzx);
}

fn cuboid_face_area(center: vec3<f32>, half_extent: vec3<f32>, axis: u32) -> f32 {
    let face = cuboid_face(center, half_extent, axis);
    let seen = spherical_quad(face.corner, face.u, face.v);
    return seen.areas.x + seen.areas.y;
}

fn spherical_cuboid(from_point: vec3<f32>, cuboid: Cuboid) -> SphericalCuboid {
    let center = to_cuboid(cuboid, cuboid.center - from_point);
    let h = cuboid.half_extent;
    let outside = abs(center) > h;
    var areas = vec3<f32>(0.0);
    if outside.x {
        areas.x = cuboid_face_area(center, h, 0u);
    }
    if outside.y {
        areas.y = cuboid_face_area(center, h, 1u);
    }
    if outside.z {
        areas.z = cuboid_face_area(center, h, 2u);
    }
    return SphericalCuboid(center, areas);
}

fn cuboid_light_sample(from_point: vec3<f32>, cuboid: Cuboid, u: vec2<f32>) -> DirectionSample {
    let seen = spherical_cuboid(from_point, cuboid);
    if !any(abs(seen.center) > cuboid.half_extent) {
        return DirectionSample(sample_sphere(u), 0.25 / PI);
    }
    let area = seen.areas.x + seen.areas.y + seen.areas.z;
    if !(area > 0.0) {
        return NO_DIRECTION_SAMPLE;
    }
    var part = u.x * area;
    var axis = 0u;
    if part >= seen.areas.x {
        part -= seen.areas.x;
        axis = 1u;
        // The sum of the solid angles may have been rounded up, so `part` may exceed the last of them.
        if part >= seen.areas.y && seen.areas.z > 0.0 {
            part = min(part - seen.areas.y, seen.areas.z);
            axis = 2u;
        } else if !(seen.areas.y > 0.0) {
            part = seen.areas.x;
            axis = 0u;
        }
    }
    let face = cuboid_face(seen.center, cuboid.half_extent, axis);
    let local = spherical_quad_direction(spherical_quad(face.corner, face.u, face.v), face.u, face.v, part, u.y);
    let z_axis = cross(cuboid.x_axis, cuboid.y_axis);
    let direction = normalize(local.x * cuboid.x_axis + local.y * cuboid.y_axis + local.z * z_axis);
    return DirectionSample(direction, 1.0 / area);
}

// The pdf with which light sampling draws a direction that hits the box.
fn cuboid_light_pdf(from_point: vec3<f32>, direction: vec3<f32>, cuboid: Cuboid) -> f32 {
    let seen = spherical_cuboid(from_point, cuboid);
    if !any(abs(seen.center) > cuboid.half_extent) {
        return 0.25 / PI;
    }
    let area = seen.areas.x + seen.areas.y + seen.areas.z;
    return select(0.0, 1.0 / area, area > 0.0);
}

// Whether a ray to the box arrives from outside.
fn cuboid_light_front(ray: Ray, normal: vec3<f32>, cuboid: Cuboid) -> bool {
    return dot(ray.direction, normal) < 0.0;
}

// Approximate distance to the near side of the box along a ray that narrowly misses it.
fn cuboid_light_distance(ray: Ray, cuboid: Cuboid) -> f32 {
    return dot(cuboid.center - ray.origin, ray.direction) - length(cuboid.half_extent);
}

// Whether a point is strictly inside.
fn is_in_cuboid(point: vec3<f32>, cuboid: Cuboid) -> bool {
    return all(abs(to_cuboid(cuboid, cuboid.center - point)) < cuboid.half_extent);
}

// The solid angle of the box; 4 pi from inside.
fn cuboid_solid_angle(from_point: vec3<f32>, cuboid: Cuboid) -> f32 {
    let seen = spherical_cuboid(from_point, cuboid);
    return select(seen.areas.x + seen.areas.y + seen.areas.z, 4.0 * PI, is_in_cuboid(from_point, cuboid));
}

// Twice the areas of the faces across x, y and z, times half the edges that a unit vector has along them: the area of the box's shadow
// along it is the sum.
fn cuboid_shadow(direction: vec3<f32>, cuboid: Cuboid) -> vec3<f32> {
    let h = cuboid.half_extent;
    return 4.0 * abs(to_cuboid(cuboid, direction)) * h.yzx * h.zxy;
}

// The axis whose part of a sum of three has a uniform number in it, and the number's place in that part, in [0, 1).
struct AxisChoice {
    axis: u32,
    rest: f32,
}

fn choose_axis(parts: vec3<f32>, u: f32) -> AxisChoice {
    let at = u * (parts.x + parts.y + parts.z);
    if at < parts.x {
        return AxisChoice(0u, at / parts.x);
    }
    if at < parts.x + parts.y || !(parts.z > 0.0) {
        return AxisChoice(1u, min((at - parts.x) / max(parts.y, 0x1p-100f), 1.0 - UNIT_ROUNDOFF));
    }
    return AxisChoice(2u, min((at - parts.x - parts.y) / parts.z, 1.0 - UNIT_ROUNDOFF));
}

// The point of a face with these coordinates in [0, 1), from the centre in render space. `side` is 1 or -1.
fn cuboid_face_point(cuboid: Cuboid, axis: u32, side: f32, u: vec2<f32>) -> vec3<f32> {
    let v = 2.0 * u - 1.0;
    var local = vec3<f32>(side, v.x, v.y);
    local = select(local, vec3<f32>(v.y, side, v.x), axis == 1u);
    local = select(local, vec3<f32>(v.x, v.y, side), axis == 2u) * cuboid.half_extent;
    let z_axis = cross(cuboid.x_axis, cuboid.y_axis);
    return local.x * cuboid.x_axis + local.y * cuboid.y_axis + local.z * z_axis;
}

fn cuboid_light_point(cuboid: Cuboid, u: vec2<f32>) -> LightPoint {
    let h = cuboid.half_extent;
    let face = choose_axis(h.yzx * h.zxy, u.x);
    let side = select(-1.0, 1.0, face.rest >= 0.5);
    let z_axis = cross(cuboid.x_axis, cuboid.y_axis);
    var outward = cuboid.x_axis;
    outward = select(outward, cuboid.y_axis, face.axis == 1u);
    outward = select(outward, z_axis, face.axis == 2u);
    let at = vec2<f32>(fract(2.0 * face.rest), u.y);
    return LightPoint(cuboid.center + cuboid_face_point(cuboid, face.axis, side, at), side * outward);
}

// Whether light paths leave the light in this direction: from the outside of a closed one.
fn cuboid_light_leaves(normal: vec3<f32>, direction: vec3<f32>) -> bool {
    return dot(normal, direction) > 0.0;
}
