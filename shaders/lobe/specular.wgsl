//@ alternative layer when specular
// The layer of glTF's material with a share or a colour of its own (KHR_materials_specular).

fn pbr_f0(material: Material, hit: Interaction) -> vec3<f32> {
    return hit.f0;
}

fn pbr_layer(material: Material, hit: Interaction, cos_facet: f32) -> vec3<f32> {
    return schlick_up_to(cos_facet, hit.f0, hit.f90);
}

// The share of light that the layer lets pass, by its largest channel.
fn pbr_passed(layer: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(1.0 - max(max(layer.x, layer.y), layer.z));
}
