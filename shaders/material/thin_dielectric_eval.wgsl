//@ use data/material
//@ use choice/facets
//@ use lib/microfacet
//@ use material/thin_dielectric
// A thin pane that is smooth is clear glass.
fn thin_dielectric_is_non_specular(material: Material) -> bool {
    return material.parameter >= LEAST_ROUGHNESS;
}

// The microfacet BSDF times cosine, and the density with which thin_dielectric_scatter samples the direction. A direction behind the pane
// counts as its mirror image before it.
fn thin_dielectric_eval(material: Material, hit: Interaction, direction: vec3<f32>) -> Response {
    let alpha = material.parameter * material.parameter;
    let cos_view = clamp(-dot(hit.incoming, hit.normal), 0.0, 1.0);
    let height = dot(direction, hit.normal);
    if height == 0.0 {
        return no_response();
    }
    let mirrored = direction - 2.0 * min(height, 0.0) * hit.normal;
    let half_way = mirrored - hit.incoming;
    let cos_facet = clamp(dot(mirrored, half_way) * inverseSqrt(dot(half_way, half_way)), 0.0, 1.0);
    let reflected = reflected_by_pane(material, hit, cos_facet);
    let share = select(1.0 - reflected.chance, reflected.chance, height > 0.0);
    let colour = select(vec3<f32>(1.0), reflected.colour, height > 0.0);
    let pdf = 0.25 * share * visible_facets(half_way, hit, cos_view, alpha);
    let value = pdf * facet_shadowing(hit, cos_view, mirrored, min(abs(height), 1.0), alpha);
    return Response(value * colour, pdf, select(0.0, 1.0, is_narrow(width_of_reflection(widest_alpha(hit, alpha)))));
}
