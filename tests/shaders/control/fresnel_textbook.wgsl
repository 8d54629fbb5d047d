// Wrong on purpose: Fresnel's formulas and Snell's law as they stand in books, which cancel as the index nears 1.
struct Refraction {
    reflectance: f32,
    cos_transmitted: f32,
}

fn fresnel(cos_incident: f32, eta: f32, contrast: f32) -> Refraction {
    let sin2 = (1.0 - cos_incident * cos_incident) / (eta * eta);
    if sin2 >= 1.0 {
        return Refraction(1.0, 0.0);
    }
    let cos_transmitted = sqrt(1.0 - sin2);
    let s = (cos_incident - eta * cos_transmitted) / (cos_incident + eta * cos_transmitted);
    let p = (eta * cos_incident - cos_transmitted) / (eta * cos_incident + cos_transmitted);
    return Refraction(0.5 * (s * s + p * p), cos_transmitted);
}

fn refract_by(incoming: vec3<f32>, normal: vec3<f32>, cos_incident: f32, eta: f32, cos_transmitted: f32) -> vec3<f32> {
    let across = (incoming + cos_incident * normal) / eta;
    return across - sqrt(abs(1.0 - dot(across, across))) * normal;
}
