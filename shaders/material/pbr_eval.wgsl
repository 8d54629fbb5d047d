//@ use data/material
//@ use lib/fresnel_conductor
//@ use lib/microfacet
//@ use lib/sampling
// glTF 2.0, appendix B. `colour` is the base colour, `parameter` the roughness, contrast_outside the reflectance of the glossy layer for
// light straight on it, and contrast_inside the metallic share.

// The narrowest lobe that f32 tells from a mirror stands for one. So the matt part always has company that is not specular.
fn pbr_alpha(material: Material) -> f32 {
    let roughness = max(material.parameter, LEAST_ROUGHNESS);
    return roughness * roughness;
}

fn pbr_is_non_specular(material: Material) -> bool {
    return true;
}

// The probability of drawing a microfacet instead of a matt direction: about its share of the light that comes back. A grazing view
// makes the matt share 0 for light from straight ahead alone, so that it does not decide whether there is a matt part.
fn pbr_share_of_facets(material: Material, hit: Interaction, cos_view: f32) -> f32 {
    let base = hit.colour;
    let metallic = material.contrast_inside;
    //@ if plain_layer
    let layer = schlick(cos_view, vec3<f32>(material.contrast_outside));
    //@ end
    //@ if own_layer
    let layer = schlick_up_to(cos_view, hit.straight, hit.grazing);
    //@ end
    let facets = mix(layer, schlick(cos_view, base), metallic);
    let matt = (1.0 - metallic) * (1.0 - layer) * base;
    let bright = vec2<f32>(facets.x + facets.y + facets.z, matt.x + matt.y + matt.z);
    if metallic == 1.0 || all(base == vec3<f32>(0.0)) {
        return 1.0;
    }
    return clamp(bright.x / (bright.x + bright.y), 0.1, 0.9);
}

// The BRDF times cosine. A dielectric reflects the share F from microfacets, and 1 - F of the base colour in all directions, with F at the
// half vector. If the layer has a share or a colour of its own (KHR_materials_specular), the largest channel of F counts in 1 - F. A metal
// reflects from microfacets by its base colour. They are mixed by the metallic share.
fn pbr_eval(material: Material, hit: Interaction, direction: vec3<f32>) -> Response {
    let metallic = material.contrast_inside;
    let alpha = pbr_alpha(material);
    let cos_view = clamp(-dot(hit.incoming, hit.normal), 0.0, 1.0);
    let cos_light = min(dot(direction, hit.normal), 1.0);
    if !(cos_light > 0.0) {
        return Response(vec3<f32>(0.0), 0.0);
    }
    let half_way = direction - hit.incoming;
    let facets = 0.25 * visible_density(microfacet_density(half_way, hit.normal, alpha), cos_view, alpha);
    let cos_facet = clamp(dot(direction, half_way) * inverseSqrt(dot(half_way, half_way)), 0.0, 1.0);
    //@ if plain_layer
    let straight = vec3<f32>(material.contrast_outside);
    let layer = schlick(cos_facet, straight);
    let passed = 1.0 - layer;
    //@ end
    //@ if own_layer
    let straight = hit.straight;
    let layer = schlick_up_to(cos_facet, straight, hit.grazing);
    let passed = 1.0 - max(max(layer.x, layer.y), layer.z);
    //@ end
    //@ if single_scattering
    let glossy = mix(layer, schlick(cos_facet, hit.colour), metallic);
    //@ end
    //@ if multiscatter
    let whole_layer = layer * (1.0 + straight * hit.lost_over_kept);
    let glossy = mix(whole_layer, schlick(cos_facet, hit.colour) * (1.0 + hit.colour * hit.lost_over_kept), metallic);
    //@ end
    let matt = (1.0 - metallic) * passed * hit.colour;
    let value = glossy * (facets * smith_shadowing(cos_view, cos_light, alpha)) + matt * (cos_light / PI);
    return Response(value, mix(cos_light / PI, facets, pbr_share_of_facets(material, hit, cos_view)));
}
