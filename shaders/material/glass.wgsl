//@ use choice/boundary
//@ use choice/fresnel
//@ use choice/film
//@ use choice/facets
// A boundary of glass with microfacets. A microfacet is drawn from those that are visible. It reflects with the probability of its reflectance
// and refracts otherwise, so the weight is the share of the visible microfacets that the light reaches too (Walter et al., EGSR 2007). Light that
// ends on the wrong side of the surface is lost. Radiance is not scaled by the index squared, as with a dielectric.
fn scatter_at_boundary(glass: Glass, hit: Interaction, u: vec4<f32>) -> Scatter {
    let boundary = boundary_at(glass, hit);
    let eta = boundary.eta;
    let alpha = glass.roughness * glass.roughness;
    let is_rough = is_rough_boundary(alpha, glass.contrasts.x);
    let normal = hit.normal;
    let cos_view = clamp(-dot(hit.incoming, normal), 0.0, 1.0);
    var facet = normal;
    var cos_facet = cos_view;
    if is_rough {
        facet = sample_facet(hit, cos_view, alpha, u.zw);
        cos_facet = clamp(-dot(hit.incoming, facet), 0.0, 1.0);
    }
    let refraction = fresnel(cos_facet, eta, boundary.contrast);
    let plain = reflected_at(glass, hit, cos_facet, refraction.reflectance);
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

// The microfacet BSDF times cosine, and the density with which scatter_at_boundary samples the direction. The half vector of a
// refraction is the sum of the view and eta times the direction. The Jacobian of its unit vector is eta^2 |cos_out| over the
// square of the sum's length (Walter et al., EGSR 2007, equations 16, 17 and 21).
fn boundary_response(glass: Glass, hit: Interaction, direction: vec3<f32>) -> Response {
    let alpha = glass.roughness * glass.roughness;
    let boundary = boundary_at(glass, hit);
    let eta = boundary.eta;
    let cos_view = clamp(-dot(hit.incoming, hit.normal), 0.0, 1.0);
    let height = dot(direction, hit.normal);
    let reflects = height > 0.0;
    let sum = select(eta, 1.0, reflects) * direction - hit.incoming;
    let length2 = dot(sum, sum);
    if height == 0.0 || !(length2 > 0.0) {
        return no_response();
    }
    let facet = sum * (inverseSqrt(length2) * select(-1.0, 1.0, dot(sum, hit.normal) >= 0.0));
    let cos_facet = -dot(hit.incoming, facet);
    let cos_out = dot(direction, facet);
    // The microfacet must see both directions on the sides on which the surface has them.
    if !(cos_facet > 0.0) || (cos_out > 0.0) != reflects {
        return no_response();
    }
    let refraction = fresnel(min(cos_facet, 1.0), eta, boundary.contrast);
    let plain = reflected_at(glass, hit, min(cos_facet, 1.0), refraction.reflectance);
    let reflected = film_on_glass(plain, hit, select(refraction.cos_transmitted, min(cos_facet, 1.0), hit.front));
    let seen = visible_facets(sum, hit, cos_view, alpha);
    var pdf = 0.25 * seen * reflected.chance;
    if !reflects {
        pdf = seen * cos_facet * (1.0 - reflected.chance) * (eta * eta * -cos_out / length2);
    }
    let value = pdf * facet_shadowing(hit, cos_view, direction, min(abs(height), 1.0), alpha);
    let colour = select(vec3<f32>(1.0), reflected.colour, reflects);
    let widest = widest_alpha(hit, alpha);
    let width = select(width_of_refraction(widest, eta), width_of_reflection(widest), reflects);
    return Response(value * colour, pdf, select(0.0, 1.0, is_narrow(width)));
}
