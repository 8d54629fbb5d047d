//@ use choice/facets
//@ use choice/film
//@ use choice/fresnel
//@ use choice/inner_reflections
// A thin pane of glass with microfacets: light that it refracts leaves it in the direction in which it came. A microfacet is drawn from those that
// are visible. It reflects with the probability of its reflectance. The light that passes is spread as the reflected light is, on the other side
// of the pane, so both have the weight of a microfacet's reflection.

// What a facet of the pane reflects.
fn reflected_by_pane(glass: Glass, hit: Interaction, cos_incident: f32) -> Reflected {
    return film_on_glass(Reflected(vec3<f32>(1.0), reflectance_of_pane(glass.contrasts.x, glass.ior, cos_incident)), hit, cos_incident);
}

// The share of light that a pane or a facet reflects. `contrast` is that of its glass from outside; `inner` is not 0 if it has inner reflections.
fn reflectance_of_pane(contrast: f32, inner: f32, cos_incident: f32) -> f32 {
    return with_inner_reflections(fresnel(cos_incident, sqrt(1.0 + contrast), contrast).reflectance, inner);
}

fn scatter_at_pane(glass: Glass, hit: Interaction, u: vec4<f32>) -> Scatter {
    let normal = hit.normal;
    let cos_view = clamp(-dot(hit.incoming, normal), 0.0, 1.0);
    if glass.roughness < LEAST_ROUGHNESS {
        let mirrored = normalize(hit.incoming + 2.0 * cos_view * normal);
        return scatter_towards(mirrored, vec3<f32>(1.0), LOBE_SPECULAR);
    }
    let alpha = glass.roughness * glass.roughness;
    let facet = sample_facet(hit, cos_view, alpha, u.zw);
    let cos_facet = clamp(-dot(hit.incoming, facet), 0.0, 1.0);
    let mirrored = normalize(hit.incoming + 2.0 * cos_facet * facet);
    let cos_light = dot(mirrored, normal);
    if !(cos_light > 0.0) {
        return absorbed();
    }
    let reflected = reflected_by_pane(glass, hit, cos_facet);
    let reflects = u.x < reflected.chance;
    let colour = select(vec3<f32>(1.0), reflected.colour, reflects);
    let passing = normalize(mirrored - 2.0 * cos_light * normal);
    let share = facet_shadowing(hit, cos_view, mirrored, min(cos_light, 1.0), alpha);
    return scatter_towards(select(passing, mirrored, reflects), share * colour, lobe_of(width_of_reflection(widest_alpha(hit, alpha))));
}

// The microfacet BSDF times cosine, and the density with which thin_dielectric_scatter samples the direction. A direction behind the pane
// counts as its mirror image before it.
fn pane_response(glass: Glass, hit: Interaction, direction: vec3<f32>) -> Response {
    let alpha = glass.roughness * glass.roughness;
    let cos_view = clamp(-dot(hit.incoming, hit.normal), 0.0, 1.0);
    let height = dot(direction, hit.normal);
    if height == 0.0 {
        return no_response();
    }
    let mirrored = direction - 2.0 * min(height, 0.0) * hit.normal;
    let half_way = mirrored - hit.incoming;
    let cos_facet = clamp(dot(mirrored, half_way) * inverseSqrt(dot(half_way, half_way)), 0.0, 1.0);
    let reflected = reflected_by_pane(glass, hit, cos_facet);
    let share = select(1.0 - reflected.chance, reflected.chance, height > 0.0);
    let colour = select(vec3<f32>(1.0), reflected.colour, height > 0.0);
    let pdf = 0.25 * share * visible_facets(half_way, hit, cos_view, alpha);
    let value = pdf * facet_shadowing(hit, cos_view, mirrored, min(abs(height), 1.0), alpha);
    return Response(value * colour, pdf, select(0.0, 1.0, is_narrow(width_of_reflection(widest_alpha(hit, alpha)))));
}
