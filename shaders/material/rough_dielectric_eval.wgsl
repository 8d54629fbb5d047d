//@ use data/material
//@ use choice/boundary
//@ use choice/facets
//@ use choice/film
//@ use choice/fresnel
//@ use lib/microfacet
// A rough dielectric that is smooth is clear glass.
fn rough_dielectric_is_non_specular(material: Material) -> bool {
    return is_rough_boundary(material.parameter * material.parameter, material.contrast_outside);
}

// The microfacet BSDF times cosine, and the density with which rough_dielectric_scatter samples the direction. The half vector of a
// refraction is the sum of the view and eta times the direction. The Jacobian of its unit vector is eta^2 |cos_out| over the
// square of the sum's length (Walter et al., EGSR 2007, equations 16, 17 and 21).
fn rough_dielectric_eval(material: Material, hit: Interaction, direction: vec3<f32>) -> Response {
    let alpha = material.parameter * material.parameter;
    let ior = hit.second.parameter;
    let boundary = boundary_at(material, ior, hit);
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
    let plain = reflected_at(material, ior, hit, min(cos_facet, 1.0), refraction.reflectance);
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
