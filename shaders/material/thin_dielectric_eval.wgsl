//@ use material/pane
//@ use material/thin_dielectric
// A thin pane that is smooth is clear glass.
fn thin_dielectric_is_non_specular(material: Material) -> bool {
    return material.${thin_dielectric.roughness} >= LEAST_ROUGHNESS;
}

fn thin_dielectric_eval(material: Material, hit: Interaction, direction: vec3<f32>) -> Response {
    return pane_response(glass_of_thin_dielectric(material), hit, direction);
}
