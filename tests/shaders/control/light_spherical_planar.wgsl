// Wrong on purpose: directions to points uniform over the area, with the density in the total solid angle, and that from the sum of
// the angles less pi, which has no digits where it is small (Girard).
fn spherical_area(p: Corner, a: Corner, c: Corner, volume: f32) -> f32 {
    let sides = array(
        normalize(cross(p.direction, a.direction)),
        normalize(cross(a.direction, c.direction)),
        normalize(cross(c.direction, p.direction)),
    );
    return acos(-dot(sides[0], sides[1])) + acos(-dot(sides[1], sides[2])) + acos(-dot(sides[2], sides[0])) - 3.14159265;
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
