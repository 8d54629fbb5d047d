//@ alternative fresnel when !(fresnel.schlick & glass)
// Fresnel reflection at a smooth boundary. This form has no cancellation as the relative index approaches 1.

// cos_incident is in [0, 1]. contrast is (eta - 1)(eta + 1), with eta the index of the far side relative to the near one. Let c
// = cos_incident, s the sine, and g = sqrt(contrast + c^2) = eta cos_transmitted. The amplitude of the perpendicular
// polarisation is (c - g)/(c + g) = -contrast / (c + g)^2. The amplitude of the parallel one is that times (c g - s^2)/(c g +
// s^2) (Born and Wolf, Principles of Optics, section 1.5.2, equations 21 and 21a rearranged).
fn fresnel(cos_incident: f32, eta: f32, contrast: f32) -> Refraction {
    let c = cos_incident;
    let g2 = contrast + c * c;
    if contrast == 0.0 {
        return Refraction(0.0, c);
    }
    if !(g2 > 0.0) {
        return Refraction(1.0, 0.0);
    }
    let g = sqrt(g2);
    let s2 = (1.0 - c) * (1.0 + c);
    let perpendicular = contrast / ((c + g) * (c + g));
    let ratio = (c * g - s2) / (c * g + s2);
    let reflectance = 0.5 * perpendicular * perpendicular * (1.0 + ratio * ratio);
    return Refraction(min(reflectance, 1.0), g / eta);
}
