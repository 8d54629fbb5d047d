//@ use lib/sampling
//@ use lib/basis
fn sample_phase(incoming: vec3<f32>, g: f32, one_minus_g: f32, u: vec2<f32>) -> vec3<f32> {
    return sample_sphere(u);
}
