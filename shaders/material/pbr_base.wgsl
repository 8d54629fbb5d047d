//@ use choice/facets
//@ use choice/multiscatter
//@ use choice/layer
//@ use choice/film
//@ use choice/body
// The base of glTF's material: glTF 2.0, appendix B. `colour` is the base colour. A roughness below LEAST_ROUGHNESS makes its microfacets a
// mirror: a specular lobe, which has no part in the response.

// The numbers of the material, where the table of all materials has them.
fn pbr_roughness(material: Material) -> f32 {
    return material.${pbr.roughness};
}

fn pbr_metallic(material: Material) -> f32 {
    return material.${pbr.metallic};
}

fn pbr_is_smooth(material: Material) -> bool {
    return pbr_roughness(material) < LEAST_ROUGHNESS;
}

// The reflectance of the microfacets of layer and metal at this cosine, by single scattering and without a film.
fn pbr_reflectance(material: Material, hit: Interaction, cos_facet: f32) -> vec3<f32> {
    let metallic = pbr_metallic(material);
    return (1.0 - metallic) * pbr_layer(material, hit, cos_facet) + metallic * schlick(cos_facet, hit.colour);
}

// The reflectance of the layer, and that of the metal, with the film on them.
fn layer_with_film(material: Material, hit: Interaction, cos_facet: f32) -> vec3<f32> {
    return with_film(pbr_layer(material, hit, cos_facet), pbr_f0(material, hit), hit.f90, hit, cos_facet);
}

fn metal_with_film(hit: Interaction, cos_facet: f32) -> vec3<f32> {
    return with_film(schlick(cos_facet, hit.colour), hit.colour, 1.0, hit, cos_facet);
}

// About what comes back of the light by microfacets and by the matt body, each the sum of its channels. At a grazing view the matt share is
// 0 only for light at normal incidence.
fn pbr_brightness(material: Material, hit: Interaction, cos_view: f32) -> vec2<f32> {
    let facets = pbr_reflectance(material, hit, cos_view);
    let matt = (1.0 - pbr_metallic(material)) * (1.0 - pbr_layer(material, hit, cos_view)) * body_albedo(hit);
    // Dot products, because Mesa adds a plain sum of such terms in another order in another kernel.
    return vec2<f32>(dot(facets, vec3<f32>(1.0)), dot(matt, vec3<f32>(1.0)));
}

// The probability of drawing a microfacet instead of a matt direction: about its share of the light that comes back.
fn pbr_share_of_facets(material: Material, hit: Interaction, cos_view: f32) -> f32 {
    let bright = pbr_brightness(material, hit, cos_view);
    if pbr_metallic(material) == 1.0 || all(body_albedo(hit) == vec3<f32>(0.0)) {
        return 1.0;
    }
    return clamp(bright.x / (bright.x + bright.y), 0.1, 0.9);
}

// Draws one of the two lobes of the base.
fn draw_base(draw: LobeDraw, material: Material, hit: Interaction, u: vec2<f32>) -> LobeDraw {
    if draw.is_drawn {
        return draw;
    }
    let normal = hit.normal;
    let cos_view = clamp(-dot(hit.incoming, normal), 0.0, 1.0);
    let share = pbr_share_of_facets(material, hit, cos_view);
    let draws_facet = draw.u < share;
    if draws_facet && pbr_is_smooth(material) {
        let mirrored = mirror_direction(hit.incoming, normal);
        if !(dot(mirrored, normal) > 0.0) {
            return take_lobe(draw, absorbed());
        }
        let metallic = pbr_metallic(material);
        let reflected = (1.0 - metallic) * layer_with_film(material, hit, cos_view) + metallic * metal_with_film(hit, cos_view);
        let weight = reflected / share * draw.rest;
        return take_lobe(draw, scatter_towards(mirrored, weight, LOBE_SPECULAR));
    }
    let alpha = pbr_roughness(material) * pbr_roughness(material);
    var direction = draw_body(hit, u, uniform_above(draw.u, share));
    var lobe = LOBE_WIDE;
    if draws_facet {
        let facet = sample_facet(hit, cos_view, alpha, u);
        direction = hit.incoming + 2.0 * clamp(-dot(hit.incoming, facet), 0.0, 1.0) * facet;
        lobe = lobe_of(width_of_reflection(widest_alpha(hit, alpha)));
    }
    direction = normalize(direction);
    if !leaves_base(hit, direction, draws_facet) {
        return take_lobe(draw, absorbed());
    }
    return take_lobe(draw, scatter_towards(direction, vec3<f32>(1.0), lobe));
}

// The BRDF of the base times cosine. A dielectric reflects the share F from microfacets, and 1 - F of the base colour in all directions, with
// F at the half vector. If the layer has a share or a colour of its own (KHR_materials_specular), the largest channel of F counts in 1 - F.
// A metal reflects from microfacets by its base colour. They are mixed by the metallic share.
fn base_response(material: Material, hit: Interaction, direction: vec3<f32>) -> Response {
    let metallic = pbr_metallic(material);
    let cos_view = clamp(-dot(hit.incoming, hit.normal), 0.0, 1.0);
    let light = mirrored_to_near_side(hit, direction);
    let cos_light = min(dot(light, hit.normal), 1.0);
    if !(cos_light > 0.0) {
        return no_response();
    }
    let half_way = light - hit.incoming;
    let cos_facet = clamp(dot(light, half_way) * inverseSqrt(dot(half_way, half_way)), 0.0, 1.0);
    let layer = layer_with_film(material, hit, cos_facet);
    let matt = (1.0 - metallic) * pbr_passed(layer) * body_colour(hit, direction);
    let share = pbr_share_of_facets(material, hit, cos_view);
    let matt_pdf = (1.0 - share) * body_pdf(hit, direction, cos_light);
    if pbr_is_smooth(material) || !is_on_near_side(hit, direction) {
        return Response(matt * (cos_light / PI), matt_pdf, 0.0);
    }
    let alpha = pbr_roughness(material) * pbr_roughness(material);
    let facets = 0.25 * visible_facets(half_way, hit, cos_view, alpha);
    let f0 = pbr_f0(material, hit);
    let full_layer = compensated(layer, with_film(f0, f0, hit.f90, hit, 1.0), hit);
    // Sums, since a GPU may compute mix(x, y, a) as x + a (y - x), which loses a small y.
    let glossy = (1.0 - metallic) * full_layer + metallic * compensated(metal_with_film(hit, cos_facet), with_film(hit.colour, hit.colour, 1.0, hit, 1.0), hit);
    let value = glossy * (facets * facet_shadowing(hit, cos_view, direction, cos_light, alpha)) + matt * (cos_light / PI);
    let pdf = matt_pdf + share * facets;
    return Response(value, pdf, select(0.0, share * facets / pdf, is_narrow(width_of_reflection(widest_alpha(hit, alpha)))));
}
