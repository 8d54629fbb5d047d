//@ use data/material
//@ use lib/basis
//@ use lib/microfacet
//@ use lib/sampling
//@ use material/pbr_eval
// The material of glTF 2.0: matt and glossy, or a metal. One of its two lobes is drawn, and the weight is that of both, so that no
// direction is noisier for the choice. Smooth microfacets are a lobe of one direction, whose weight is its own.
fn pbr_scatter(material: Material, hit: Interaction, u: vec4<f32>) -> Scatter {
    let normal = hit.normal;
    let cos_view = clamp(-dot(hit.incoming, normal), 0.0, 1.0);
    let share = pbr_share_of_facets(material, hit, cos_view);
    let draws_facet = u.x < share;
    if draws_facet && pbr_is_smooth(material) {
        let mirrored = mirror_direction(hit.incoming, normal);
        if !(dot(mirrored, normal) > 0.0) {
            return absorbed();
        }
        return scatter_towards(mirrored, pbr_reflectance(material, hit, cos_view) / share, LOBE_SPECULAR);
    }
    let alpha = pbr_roughness(material) * pbr_roughness(material);
    let basis = basis_around(normal);
    var direction = from_basis(basis, sample_cosine_hemisphere(u.zw));
    var lobe = LOBE_WIDE;
    if draws_facet {
        let across = vec2<f32>(dot(hit.incoming, basis.tangent), dot(hit.incoming, basis.bitangent));
        let view = vec3<f32>(-across, cos_view);
        let facet = from_basis(basis, sample_visible_normal(view, alpha, u.zw));
        direction = hit.incoming + 2.0 * clamp(-dot(hit.incoming, facet), 0.0, 1.0) * facet;
        lobe = lobe_of(width_of_reflection(alpha));
    }
    direction = normalize(direction);
    let response = pbr_eval(material, hit, direction);
    if !(response.pdf > 0.0) {
        return absorbed();
    }
    return scatter_towards(direction, response.value / response.pdf, lobe);
}
