//@ implements tint when tinted & !dispersion
// Returns the light times the tint of a transmissive surface, if the direction crosses the surface.
fn tint_through(light: vec3<f32>, evaluated: EvaluatedMaterial, direction: vec3<f32>, normal: vec3<f32>) -> vec3<f32> {
    switch evaluated.material.kind {
        //@ each transmissive
        case ${number}u: {
            return light * select(vec3<f32>(1.0), evaluated.colour, dot(direction, normal) < 0.0);
        }
        //@ end
        default: {
            return light;
        }
    }
}

//@ without
// No surface lets a share of light pass alone.
fn tint_through(light: vec3<f32>, evaluated: EvaluatedMaterial, direction: vec3<f32>, normal: vec3<f32>) -> vec3<f32> {
    return light;
}
