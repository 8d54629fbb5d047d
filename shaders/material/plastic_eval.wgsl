//@ use choice/facets
//@ use choice/fresnel
//@ use choice/rough_layer
// The body scatters at every angle.
fn plastic_is_non_specular(material: Material) -> bool {
    return true;
}

// The reflectance of the layer, or of a microfacet of it.
fn plastic_layer(material: Material, cosine: f32) -> f32 {
    let contrast = material.${plastic.contrast};
    return fresnel(cosine, sqrt(1.0 + contrast), contrast).reflectance;
}

// The share of light that enters the layer at this cosine, or leaves it.
fn plastic_passed(material: Material, hit: Interaction, cosine: f32) -> f32 {
    return passed_by_layer(1.0 - plastic_layer(material, cosine), material, hit, cosine);
}

// The albedo of the body under the layer. Of its light, `leaving` / n^2 leaves the layer, whose index is n, and the body sees the rest again:
// c / n^2 (1 + c (1 - leaving / n^2) + ...). If it is not nonlinear, all but the first c are 1.
fn plastic_body(material: Material, hit: Interaction) -> vec3<f32> {
    let again = select(vec3<f32>(1.0), hit.colour, hit.second.${plastic.nonlinear} > 0.0);
    return hit.colour / ((1.0 + material.${plastic.contrast}) * (1.0 - again) + material.${plastic.leaving} * again);
}

// The probability of drawing from the layer: about its share of the light that comes back.
fn plastic_share_of_layer(material: Material, hit: Interaction, cos_view: f32) -> f32 {
    let passed = plastic_passed(material, hit, cos_view);
    let body = passed * material.${plastic.leaving} * dot(plastic_body(material, hit), vec3<f32>(1.0 / 3.0));
    return select(clamp((1.0 - passed) / (1.0 - passed + body), 0.1, 0.9), 1.0, body == 0.0);
}

// The microfacet BRDF of the layer and that of the body, T(v) T(l) times that over pi, times cosine; T is what enters or leaves.
fn plastic_eval(material: Material, hit: Interaction, direction: vec3<f32>) -> Response {
    let cos_view = clamp(-dot(hit.incoming, hit.normal), 0.0, 1.0);
    let cos_light = min(dot(direction, hit.normal), 1.0);
    if !(cos_light > 0.0) {
        return no_response();
    }
    let share = plastic_share_of_layer(material, hit, cos_view);
    let both_ways = plastic_passed(material, hit, cos_view) * plastic_passed(material, hit, cos_light);
    let matt = both_ways * plastic_body(material, hit) * (cos_light / PI);
    let matt_pdf = (1.0 - share) * cos_light / PI;
    if material.${plastic.roughness} < LEAST_ROUGHNESS {
        return Response(matt, matt_pdf, 0.0);
    }
    let alpha = material.${plastic.roughness} * material.${plastic.roughness};
    let half_way = direction - hit.incoming;
    let cos_facet = clamp(dot(direction, half_way) * inverseSqrt(dot(half_way, half_way)), 0.0, 1.0);
    let facets = 0.25 * visible_facets(half_way, hit, cos_view, alpha);
    let glossy = plastic_layer(material, cos_facet) * facets * facet_shadowing(hit, cos_view, direction, cos_light, alpha);
    let pdf = matt_pdf + share * facets;
    return Response(glossy + matt, pdf, select(0.0, share * facets / pdf, is_narrow(width_of_reflection(widest_alpha(hit, alpha)))));
}
