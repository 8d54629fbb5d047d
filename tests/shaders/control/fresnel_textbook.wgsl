// Wrong on purpose: Fresnel's formulas as they stand in books, which cancel as the index nears 1.
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
