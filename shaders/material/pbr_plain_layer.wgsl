//@ use data/material
//@ use lib/fresnel_conductor
// The layer of glTF's material by its index of refraction alone.

// What it reflects of light straight on it: the reflectance of its index, which the table has as contrast_outside.
fn pbr_f0(material: Material, hit: Interaction) -> vec3<f32> {
    return vec3<f32>(material.contrast_outside);
}

// What it reflects of light that meets a microfacet at this cosine.
fn pbr_layer(material: Material, hit: Interaction, cos_facet: f32) -> vec3<f32> {
    return schlick(cos_facet, pbr_f0(material, hit));
}

// The share of light that it lets pass.
fn pbr_passed(layer: vec3<f32>) -> vec3<f32> {
    return 1.0 - layer;
}
