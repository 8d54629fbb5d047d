//@ use data/material
//@ use choice/fresnel
// A smooth boundary of a clear solid. It reflects with the probability of its reflectance and refracts otherwise, so the weight
// is 1. Radiance is not scaled by the index squared, because the camera and the lights are in the same medium.
fn dielectric_index(material: Material, hit: Interaction) -> f32 {
    return material.parameter;
}

fn dielectric_scatter(material: Material, hit: Interaction, u: vec4<f32>) -> Scatter {
    let ior = material.parameter;
    let eta = select(1.0 / ior, ior, hit.front);
    let contrast = select(material.contrast_inside, material.contrast_outside, hit.front);
    let cos_incident = clamp(-dot(hit.incoming, hit.normal), 0.0, 1.0);
    let boundary = fresnel(cos_incident, eta, contrast);
    if u.x < boundary.reflectance {
        let mirrored = hit.incoming + 2.0 * cos_incident * hit.normal;
        return scatter_towards(normalize(mirrored), vec3<f32>(1.0), LOBE_SPECULAR);
    }
    if contrast == 0.0 {
        return scatter_towards(hit.incoming, vec3<f32>(1.0), LOBE_SPECULAR);
    }
    let refracted = refract_by(hit.incoming, hit.normal, cos_incident, eta, boundary.cos_transmitted);
    return scatter_towards(refracted, vec3<f32>(1.0), LOBE_SPECULAR);
}
