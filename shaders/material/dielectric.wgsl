//@ use choice/boundary
//@ use choice/fresnel
// A smooth boundary of a clear solid. It reflects with the probability of its reflectance and refracts otherwise, so the weight
// is 1. Radiance is not scaled by the index squared, because the camera and the lights are in the same medium.
fn dielectric_index(material: Material, hit: Interaction) -> f32 {
    return followed_index(material.${dielectric.ior}, hit);
}

fn dielectric_scatter(material: Material, hit: Interaction, u: vec4<f32>) -> Scatter {
    let glass = Glass(0.0, material.${dielectric.ior}, vec2<f32>(material.${dielectric.outside}, material.${dielectric.inside}));
    let boundary = boundary_at(glass, hit);
    let cos_incident = clamp(-dot(hit.incoming, hit.normal), 0.0, 1.0);
    let refraction = fresnel(cos_incident, boundary.eta, boundary.contrast);
    let reflected = reflected_at(glass, hit, cos_incident, refraction.reflectance);
    if u.x < reflected.chance {
        let mirrored = hit.incoming + 2.0 * cos_incident * hit.normal;
        return scatter_towards(normalize(mirrored), reflected.colour, LOBE_SPECULAR);
    }
    if boundary.contrast == 0.0 {
        return scatter_towards(hit.incoming, vec3<f32>(1.0), LOBE_SPECULAR);
    }
    let refracted = refract_by(hit.incoming, hit.normal, cos_incident, boundary.eta, refraction.cos_transmitted);
    return scatter_towards(refracted, vec3<f32>(1.0), LOBE_SPECULAR);
}
