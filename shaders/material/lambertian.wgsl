//@ use data/material
//@ use lib/basis
//@ use lib/sampling
// Lambertian reflection: BSDF albedo / pi, sampled by the cosine, so that the weight is the albedo
// (PBR 4th ed., section 9.2).
fn lambertian_scatter(material: Material, hit: Interaction, u: vec4<f32>) -> Scatter {
    let direction = from_basis(basis_around(hit.normal), sample_cosine_hemisphere(u.xy));
    return Scatter(SCATTERED, normalize(direction), hit.colour);
}
