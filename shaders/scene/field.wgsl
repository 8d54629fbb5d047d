// The position in a field (data/scalar_field) of a point, by its offset from the medium's own point, with a 1 behind it; with a 0, of a direction.
fn position_in_field(field: ScalarField, offset: vec4<f32>) -> vec3<f32> {
    return vec3<f32>(dot(field.x, offset), dot(field.y, offset), dot(field.z, offset));
}
