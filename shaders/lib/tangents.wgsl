// The frame of a normal map.

// The directions in which the texture coordinates u and v grow along a surface, of any length.
struct Tangents {
    u: vec3<f32>,
    v: vec3<f32>,
}

// The vector `mapped` of a normal map, whose axes are u, v and the normal, around this unit normal. The axis of u is perpendicular to the
// normal, and that of v to both, on the side where v grows, so that images which are mirrored keep their relief. Where the tangents
// have no direction, the normal stays.
fn normal_of_map(mapped: vec3<f32>, normal: vec3<f32>, tangents: Tangents) -> vec3<f32> {
    let along = tangents.u - dot(tangents.u, normal) * normal;
    let length2 = dot(along, along);
    if !(length2 > 0.0) {
        return normal;
    }
    let u = along * inverseSqrt(length2);
    let v = cross(normal, u);
    let side = select(1.0, -1.0, dot(v, tangents.v) < 0.0);
    let turned = mapped.x * u + (side * mapped.y) * v + mapped.z * normal;
    let turned2 = dot(turned, turned);
    return select(normal, turned * inverseSqrt(turned2), turned2 > 0.0);
}
