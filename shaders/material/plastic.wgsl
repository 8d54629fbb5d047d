//@ use choice/facets
//@ use choice/fresnel
//@ use material/plastic_eval
// A matt body under a clear layer, smooth or of microfacets. Light is reflected by the layer, or enters it, is scattered by the body, which the
// layer reflects back again and again, and leaves it. One of the two is drawn.
fn plastic_scatter(material: Material, hit: Interaction, u: vec4<f32>) -> Scatter {
    let cos_view = clamp(-dot(hit.incoming, hit.normal), 0.0, 1.0);
    let share = plastic_share_of_layer(material, hit, cos_view);
    let draws_layer = u.x < share;
    let is_smooth = material.${plastic.roughness} < LEAST_ROUGHNESS;
    var direction = from_basis(basis_around(hit.normal), sample_cosine_hemisphere(u.zw));
    var lobe = LOBE_WIDE;
    if draws_layer {
        let alpha = material.${plastic.roughness} * material.${plastic.roughness};
        var facet = hit.normal;
        lobe = LOBE_SPECULAR;
        if !is_smooth {
            facet = sample_facet(hit, cos_view, alpha, u.zw);
            lobe = lobe_of(width_of_reflection(widest_alpha(hit, alpha)));
        }
        direction = hit.incoming + 2.0 * clamp(-dot(hit.incoming, facet), 0.0, 1.0) * facet;
    }
    direction = normalize(direction);
    if !(dot(direction, hit.normal) > 0.0) {
        return absorbed();
    }
    if lobe == LOBE_SPECULAR {
        return scatter_towards(direction, vec3<f32>(plastic_layer(material, cos_view) / share), lobe);
    }
    let response = plastic_eval(material, hit, direction);
    if !(response.pdf > 0.0) {
        return absorbed();
    }
    return scatter_towards(direction, response.value / response.pdf, lobe);
}
