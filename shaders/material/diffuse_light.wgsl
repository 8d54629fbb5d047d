// Emits the same radiance in all directions and reflects nothing. A one-sided light (parameter 0) emits nothing from its back.
fn diffuse_light_scatter(material: Material, hit: Interaction, u: vec4<f32>) -> Scatter {
    if hit.front || material.${diffuse_light.two_sided} != 0.0 {
        return emit(hit.colour);
    }
    return absorbed();
}
