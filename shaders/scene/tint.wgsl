//@ use data/material
// What the surface of a clear solid lets pass of light that goes from one of its sides to the other.
fn tint_of(material: Material, colour: vec3<f32>, direction: vec3<f32>, normal: vec3<f32>) -> vec3<f32> {
    switch material.kind {
        //@ each clear
        case ${number}u: {
            return select(vec3<f32>(1.0), colour, dot(direction, normal) < 0.0);
        }
        //@ end
        default: {
            return vec3<f32>(1.0);
        }
    }
}
