//@ implements tint when dispersion
// Returns the light times the tint of a transmissive surface, if the direction crosses the surface: of the followed channel
// (step/followed_channel).
fn tint_through(light: vec3<f32>, evaluated: EvaluatedMaterial, direction: vec3<f32>, normal: vec3<f32>) -> vec3<f32> {
    if !(dot(direction, normal) < 0.0) {
        return light;
    }
    switch evaluated.material.kind {
        //@ each transmissive
        case ${number}u: {
            return light * evaluated.kept * evaluated.colour;
        }
        //@ end
        default: {
            return light * evaluated.kept;
        }
    }
}
