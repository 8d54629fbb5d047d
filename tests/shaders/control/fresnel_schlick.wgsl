// Wrong on purpose: Schlick's approximation with the cosine of the incident side, as "Ray Tracing in One Weekend" has it.
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
