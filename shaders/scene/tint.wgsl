//@ use data/material
// Light times the share that the surface of a clear solid lets pass, if it goes from one side to the other.
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
