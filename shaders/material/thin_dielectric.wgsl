//@ use material/pane
// A thin pane. A smooth one scatters only the light that it reflects: rays pass it before they are scattered (step/panes).

fn thin_dielectric_reflectance(material: Material, cos_incident: f32) -> f32 {
    return reflectance_of_pane(material.${thin_dielectric.contrast}, material.${thin_dielectric.inner_reflections}, cos_incident);
}

// On both of its sides is the same.
fn thin_dielectric_index(material: Material, hit: Interaction) -> f32 {
    return 1.0;
}

fn glass_of_thin_dielectric(material: Material) -> Glass {
    let contrasts = vec2<f32>(material.${thin_dielectric.contrast}, 0.0);
    return Glass(material.${thin_dielectric.roughness}, material.${thin_dielectric.inner_reflections}, contrasts);
}

fn thin_dielectric_scatter(material: Material, hit: Interaction, u: vec4<f32>) -> Scatter {
    return scatter_at_pane(glass_of_thin_dielectric(material), hit, u);
}
