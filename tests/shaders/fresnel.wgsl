//@ use lib/fresnel
// A ray at a smooth boundary.
struct In {
    incoming: vec3<f32>,
    eta: f32,
    normal: vec3<f32>,
    contrast: f32,
}

struct Out {
    refracted: vec3<f32>,
    // Of the ray with the normal, as the shader computes it.
    cos_incident: f32,
    reflectance: f32,
    cos_transmitted: f32,
    padding0: u32,
    padding1: u32,
}

fn run(row: u32) {
    let given = input[row];
    let cos_incident = clamp(-dot(given.incoming, given.normal), 0.0, 1.0);
    let boundary = fresnel(cos_incident, given.eta, given.contrast);
    let refracted = refract_by(given.incoming, given.normal, cos_incident, given.eta, boundary.cos_transmitted);
    output[row] = Out(refracted, cos_incident, boundary.reflectance, boundary.cos_transmitted, 0u, 0u);
}
