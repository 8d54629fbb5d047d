// Lambertian reflection: the BSDF is albedo / pi. Directions are sampled by the cosine, so the weight is the
// albedo (PBR 4th ed., section 9.2).
fn lambertian_scatter(material: Material, hit: Interaction, u: vec4<f32>) -> Scatter {
    let direction = from_basis(basis_around(hit.normal), sample_cosine_hemisphere(u.xy));
    return scatter_towards(normalize(direction), hit.colour, LOBE_WIDE);
}
