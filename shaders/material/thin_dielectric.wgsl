//@ use data/material
//@ use choice/facets
//@ use choice/film
//@ use choice/fresnel
//@ use lib/microfacet
// A thin pane of a transmissive solid: light that it refracts leaves it in the direction in which it came. `parameter` is its roughness. A
// smooth pane scatters only the light that it reflects: rays pass it before they are scattered (step/panes). In a rough one, a microfacet
// is drawn from those that are visible. It reflects with the probability of its reflectance. The light that passes is spread as the
// reflected light is, on the other side of the pane, so both have the weight of a microfacet's reflection.

// What a facet of the pane reflects.
fn reflected_by_pane(material: Material, hit: Interaction, cos_incident: f32) -> Reflected {
    return film_on_glass(Reflected(vec3<f32>(1.0), thin_dielectric_reflectance(material, cos_incident)), hit, cos_incident);
}

// The share of light that a pane or a facet reflects.
fn thin_dielectric_reflectance(material: Material, cos_incident: f32) -> f32 {
    return fresnel(cos_incident, sqrt(1.0 + material.contrast_outside), material.contrast_outside).reflectance;
}

// On both of its sides is the same.
fn thin_dielectric_index(material: Material, hit: Interaction) -> f32 {
    return 1.0;
}

fn thin_dielectric_scatter(material: Material, hit: Interaction, u: vec4<f32>) -> Scatter {
    let normal = hit.normal;
    let cos_view = clamp(-dot(hit.incoming, normal), 0.0, 1.0);
    if material.parameter < LEAST_ROUGHNESS {
        let mirrored = normalize(hit.incoming + 2.0 * cos_view * normal);
        return scatter_towards(mirrored, vec3<f32>(1.0), LOBE_SPECULAR);
    }
    let alpha = material.parameter * material.parameter;
    let facet = sample_facet(hit, cos_view, alpha, u.zw);
    let cos_facet = clamp(-dot(hit.incoming, facet), 0.0, 1.0);
    let mirrored = normalize(hit.incoming + 2.0 * cos_facet * facet);
    let cos_light = dot(mirrored, normal);
    if !(cos_light > 0.0) {
        return absorbed();
    }
    let reflected = reflected_by_pane(material, hit, cos_facet);
    let reflects = u.x < reflected.chance;
    let colour = select(vec3<f32>(1.0), reflected.colour, reflects);
    let passing = normalize(mirrored - 2.0 * cos_light * normal);
    let share = facet_shadowing(hit, cos_view, mirrored, min(cos_light, 1.0), alpha);
    return scatter_towards(select(passing, mirrored, reflects), share * colour, lobe_of(width_of_reflection(widest_alpha(hit, alpha))));
}
