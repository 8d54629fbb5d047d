//@ alternative layer when !specular
// The layer of glTF's material by its index of refraction alone.

// The reflectance at normal incidence.
fn pbr_f0(material: Material, hit: Interaction) -> vec3<f32> {
    return vec3<f32>(material.${pbr.f0});
}

// The reflectance of a microfacet at this cosine.
fn pbr_layer(material: Material, hit: Interaction, cos_facet: f32) -> vec3<f32> {
    return schlick(cos_facet, pbr_f0(material, hit));
}

// The share of light that the layer lets pass.
fn pbr_passed(layer: vec3<f32>) -> vec3<f32> {
    return 1.0 - layer;
}
