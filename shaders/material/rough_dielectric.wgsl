//@ use choice/boundary
//@ use material/glass
// A boundary of a transmissive solid with microfacets.
fn rough_dielectric_index(material: Material, hit: Interaction) -> f32 {
    return followed_index(hit.second.${rough_dielectric.ior}, hit);
}

fn glass_of_rough_dielectric(material: Material, hit: Interaction) -> Glass {
    let contrasts = vec2<f32>(material.${rough_dielectric.outside}, material.${rough_dielectric.inside});
    return Glass(material.${rough_dielectric.roughness}, hit.second.${rough_dielectric.ior}, contrasts);
}

fn rough_dielectric_scatter(material: Material, hit: Interaction, u: vec4<f32>) -> Scatter {
    return scatter_at_boundary(glass_of_rough_dielectric(material, hit), hit, u);
}
