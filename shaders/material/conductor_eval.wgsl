//@ use choice/facets
//@ use choice/multiscatter
// A conductor that is smooth is a mirror.
fn conductor_is_non_specular(material: Material) -> bool {
    return material.${conductor.roughness} >= LEAST_ROUGHNESS;
}

// The microfacet BRDF F D G2 / (4 cos_view cos_light) times cos_light (Walter et al., EGSR 2007, equation 20), and the density G1 D /
// (4 cos_view) with which conductor_scatter samples the direction.
fn conductor_eval(material: Material, hit: Interaction, direction: vec3<f32>) -> Response {
    let alpha = material.${conductor.roughness} * material.${conductor.roughness};
    let cos_view = clamp(-dot(hit.incoming, hit.normal), 0.0, 1.0);
    let cos_light = min(dot(direction, hit.normal), 1.0);
    if !(cos_light > 0.0) {
        return no_response();
    }
    let half_way = direction - hit.incoming;
    let pdf = 0.25 * visible_facets(half_way, hit, cos_view, alpha);
    let cos_facet = clamp(dot(direction, half_way) * inverseSqrt(dot(half_way, half_way)), 0.0, 1.0);
    let single = reflectance_of_metal(cos_facet, hit.colour, hit.second.colour, hit.second.${conductor.reflectance});
    let f0 = reflectance_of_metal(1.0, hit.colour, hit.second.colour, hit.second.${conductor.reflectance});
    let share = compensated(single, f0, hit);
    let value = share * (pdf * facet_shadowing(hit, cos_view, direction, cos_light, alpha));
    return Response(value, pdf, select(0.0, 1.0, is_narrow(width_of_reflection(widest_alpha(hit, alpha)))));
}
