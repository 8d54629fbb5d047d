//@ use data/material
//@ use lib/basis
//@ use lib/microfacet
//@ use lib/sampling
//@ use material/pbr_eval
// The material of glTF 2.0: matt and glossy, or a metal. One of its two lobes is drawn, and the weight is that of both, so that no
// direction is noisier for the choice.
fn pbr_scatter(material: Material, hit: Interaction, u: vec4<f32>) -> Scatter {
    let normal = hit.normal;
    let cos_view = clamp(-dot(hit.incoming, normal), 0.0, 1.0);
    let basis = basis_around(normal);
    var direction = from_basis(basis, sample_cosine_hemisphere(u.zw));
    if u.x < pbr_share_of_facets(material, hit, cos_view) {
        let across = vec2<f32>(dot(hit.incoming, basis.tangent), dot(hit.incoming, basis.bitangent));
        let view = vec3<f32>(-across, cos_view);
        let facet = from_basis(basis, sample_visible_normal(view, pbr_alpha(material), u.zw));
        direction = hit.incoming + 2.0 * clamp(-dot(hit.incoming, facet), 0.0, 1.0) * facet;
    }
    direction = normalize(direction);
    let response = pbr_eval(material, hit, direction);
    if !(response.pdf > 0.0) {
        return absorbed();
    }
    return Scatter(SCATTERED, direction, response.value / response.pdf);
}
