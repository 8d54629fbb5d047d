//@ use choice/facets
//@ use choice/multiscatter
// A metal of microfacets. `parameter` is its roughness, `colour` its albedo or its eta - 1. Its second part has k, and as `parameter`
// the factor of that reflection, or 0 where the colour is an albedo. A microfacet is drawn from those that are visible, so the weight is its
// reflectance times the share of them that the light reaches too (Heitz, "Sampling the GGX Distribution of Visible Normals", JCGT 7(4), 2018).
// Light that is reflected below the surface is lost. What microfacets scatter more than once comes back by Turquin's factor
// (scene/multiscatter), if the material asks for it.
fn conductor_scatter(material: Material, hit: Interaction, u: vec4<f32>) -> Scatter {
    let normal = hit.normal;
    let cos_view = clamp(-dot(hit.incoming, normal), 0.0, 1.0);
    if material.${conductor.roughness} < LEAST_ROUGHNESS {
        let mirrored = mirror_direction(hit.incoming, normal);
        if !(dot(mirrored, normal) > 0.0) {
            return absorbed();
        }
        let share = reflectance_of_metal(cos_view, hit.colour, hit.second.colour, hit.second.${conductor.reflectance});
        return scatter_towards(mirrored, share, LOBE_SPECULAR);
    }
    let alpha = material.${conductor.roughness} * material.${conductor.roughness};
    let facet = sample_facet(hit, cos_view, alpha, u.xy);
    let cos_facet = clamp(-dot(hit.incoming, facet), 0.0, 1.0);
    let direction = normalize(hit.incoming + 2.0 * cos_facet * facet);
    let cos_light = dot(direction, normal);
    if !(cos_light > 0.0) {
        return absorbed();
    }
    let single = reflectance_of_metal(cos_facet, hit.colour, hit.second.colour, hit.second.${conductor.reflectance});
    let f0 = reflectance_of_metal(1.0, hit.colour, hit.second.colour, hit.second.${conductor.reflectance});
    let share = compensated(single, f0, hit);
    let weight = share * facet_shadowing(hit, cos_view, direction, min(cos_light, 1.0), alpha);
    return scatter_towards(direction, weight, lobe_of(width_of_reflection(widest_alpha(hit, alpha))));
}
