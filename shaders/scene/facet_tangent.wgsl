//@ implements facet_tangent when anisotropy
//@ use bind/extensions
//@ use scene/normal_by_map
// The direction along which microfacets are rougher: `turn` in the axes of the texture coordinates, made perpendicular to the normal. Where
// there are no such axes, it is any.
fn facet_tangent(hit: Hit, surface: Surface, normal: vec3<f32>, front: bool, turn: vec2<f32>) -> vec3<f32> {
    let row = extensions[surface.material].anisotropy;
    if row == NO_EXTENSION {
        return normal;
    }
    let mapped = vector_by_row(row, vec3<f32>(turn, 0.0), select(-normal, normal, front), hit, surface);
    let along = mapped - dot(mapped, normal) * normal;
    let length2 = dot(along, along);
    if !(length2 > 1e-8) {
        return basis_around(normal).tangent;
    }
    return along * inverseSqrt(length2);
}

//@ without
// No material has an anisotropy.
fn facet_tangent(hit: Hit, surface: Surface, normal: vec3<f32>, front: bool, turn: vec2<f32>) -> vec3<f32> {
    return normal;
}
