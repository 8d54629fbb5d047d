// Wrong on purpose: Schlick's approximation with the cosine of the incident side, as "Ray Tracing in One Weekend" has it.
struct Refraction {
    reflectance: f32,
    cos_transmitted: f32,
}

fn fresnel(cos_incident: f32, eta: f32, contrast: f32) -> Refraction {
    let g2 = contrast + cos_incident * cos_incident;
    if !(g2 > 0.0) {
        return Refraction(1.0, 0.0);
    }
    let root = (1.0 - eta) / (1.0 + eta);
    let r0 = root * root;
    let m = 1.0 - cos_incident;
    return Refraction(r0 + (1.0 - r0) * m * m * m * m * m, sqrt(g2) / eta);
}

fn refract_by(incoming: vec3<f32>, normal: vec3<f32>, cos_incident: f32, eta: f32, cos_transmitted: f32) -> vec3<f32> {
    return normalize(incoming / eta + (cos_incident / eta - cos_transmitted) * normal);
}
