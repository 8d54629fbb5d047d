//@ use data/material
//@ use choice/boundary
//@ use choice/fresnel
//@ use choice/film
//@ use choice/facets
//@ use lib/microfacet
// A boundary of a transmissive solid with microfacets. `parameter` is its roughness, and that of its second part the index of refraction. A
// microfacet is drawn from those that are visible. It reflects with the probability of its reflectance and refracts otherwise, so the
// weight is the share of the visible microfacets that the light reaches too (Walter et al., EGSR 2007). Light that ends on the wrong
// side of the surface is lost. Radiance is not scaled by the index squared, as with a dielectric.
fn rough_dielectric_index(material: Material, hit: Interaction) -> f32 {
    return followed_index(hit.second.parameter, hit);
}

fn rough_dielectric_scatter(material: Material, hit: Interaction, u: vec4<f32>) -> Scatter {
    let ior = hit.second.parameter;
    let boundary = boundary_at(material, ior, hit);
    let eta = boundary.eta;
    let alpha = material.parameter * material.parameter;
    let is_rough = is_rough_boundary(alpha, material.contrast_outside);
    let normal = hit.normal;
    let cos_view = clamp(-dot(hit.incoming, normal), 0.0, 1.0);
    var facet = normal;
    var cos_facet = cos_view;
    if is_rough {
        facet = sample_facet(hit, cos_view, alpha, u.zw);
        cos_facet = clamp(-dot(hit.incoming, facet), 0.0, 1.0);
    }
    let refraction = fresnel(cos_facet, eta, boundary.contrast);
    let plain = reflected_at(material, ior, hit, cos_facet, refraction.reflectance);
    let reflected = film_on_glass(plain, hit, select(refraction.cos_transmitted, cos_facet, hit.front));
    let reflects = u.x < reflected.chance;
    let colour = select(vec3<f32>(1.0), reflected.colour, reflects);
    var direction = hit.incoming;
    if reflects {
        direction = normalize(hit.incoming + 2.0 * cos_facet * facet);
    } else if boundary.contrast != 0.0 {
        direction = refract_by(hit.incoming, facet, cos_facet, eta, refraction.cos_transmitted);
    }
    if !is_rough {
        return scatter_towards(direction, colour, LOBE_SPECULAR);
    }
    let cos_light = dot(direction, normal) * select(-1.0, 1.0, reflects);
    if !(cos_light > 0.0) {
        return absorbed();
    }
    let weight = facet_shadowing(hit, cos_view, direction, min(cos_light, 1.0), alpha);
    let widest = widest_alpha(hit, alpha);
    let width = select(width_of_refraction(widest, eta), width_of_reflection(widest), reflects);
    return scatter_towards(direction, weight * colour, lobe_of(width));
}
