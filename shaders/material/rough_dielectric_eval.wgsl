//@ use material/glass
//@ use material/rough_dielectric
// A rough dielectric that is smooth is clear glass.
fn rough_dielectric_is_non_specular(material: Material) -> bool {
    let roughness = material.${rough_dielectric.roughness};
    return is_rough_boundary(roughness * roughness, material.${rough_dielectric.outside});
}

fn rough_dielectric_eval(material: Material, hit: Interaction, direction: vec3<f32>) -> Response {
    return boundary_response(glass_of_rough_dielectric(material, hit), hit, direction);
}
