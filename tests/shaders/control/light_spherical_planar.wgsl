// Wrong on purpose: directions to points uniform over the area, with the density in solid angle of the whole.
struct Corner {
    direction: vec3<f32>,
    distance: f32,
}

fn corner_at(offset: vec3<f32>) -> Corner {
    let distance = length(offset);
    return Corner(offset / distance, distance);
}

fn spherical_area(p: Corner, a: Corner, c: Corner, volume: f32) -> f32 {
    let shape = volume / p.distance / a.distance / c.distance;
    let beside = 1.0 + dot(p.direction, a.direction) + dot(a.direction, c.direction) + dot(c.direction, p.direction);
    return 2.0 * atan2(shape, beside);
}

fn spherical_direction(
    p: Corner,
    a: Corner,
    c: Corner,
    to_a: vec3<f32>,
    to_c: vec3<f32>,
    determinant: f32,
    part: f32,
    v: f32,
) -> vec3<f32> {
    let area = spherical_area(p, a, c, abs(determinant));
    return normalize(p.distance * p.direction + sqrt(v) * (to_a + min(part / area, 1.0) * to_c));
}
