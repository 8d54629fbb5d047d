//@ implements coat when coat
// KHR_materials_clearcoat: a layer of microfacets around all else. It reflects the share s F(n_c v) of the light, with its own normal n_c, and
// all that lies below, its emission too, has the factor 1 - s F(n_c v). This depends on the view alone, so it is not reciprocal.

// The share that the coat reflects to the view.
fn coat_reflectance(hit: Interaction) -> f32 {
    let cos_view = clamp(-dot(hit.incoming, hit.coat_normal), 0.0, 1.0);
    return hit.lobes.coat * schlick(cos_view, vec3<f32>(hit.lobes.coat_f0)).x;
}

fn is_smooth_coat(lobes: Lobes) -> bool {
    return lobes.coat_roughness < LEAST_ROUGHNESS;
}

// Whether the material has a lobe that is not specular: `under` says it of what lies below.
fn coat_spreads(material: Material, lobes: Lobes, under: bool) -> bool {
    return under || (lobes.coat > 0.0 && !is_smooth_coat(lobes));
}

fn emission_under_coat(emission: vec3<f32>, hit: Interaction) -> vec3<f32> {
    return emission * (1.0 - coat_reflectance(hit));
}

// The probability of drawing from the coat: its share of the light that comes from the view.
fn share_of_coat(hit: Interaction, under: f32) -> f32 {
    let coat = coat_reflectance(hit);
    return coat / (coat + (1.0 - coat) * under);
}

// Whether light reaches the coat in this direction. Below the normal of the base it would pass a closed surface.
fn is_above_coat(hit: Interaction, direction: vec3<f32>) -> bool {
    return dot(direction, hit.coat_normal) > 0.0 && dot(direction, hit.normal) > 0.0;
}

// About what comes back to the view, with `under` of it from below.
fn coat_albedo(material: Material, hit: Interaction, under: f32) -> f32 {
    return mix(under, 1.0, coat_reflectance(hit));
}

fn draw_coat(draw: LobeDraw, material: Material, hit: Interaction, u: vec2<f32>, under: f32) -> LobeDraw {
    let coat = coat_reflectance(hit);
    if draw.is_drawn || coat == 0.0 {
        return draw;
    }
    let share = share_of_coat(hit, under);
    if draw.u >= share {
        return draw_from_rest(draw, share, 1.0 - coat);
    }
    let normal = hit.coat_normal;
    if is_smooth_coat(hit.lobes) {
        let mirrored = mirror_direction(hit.incoming, normal);
        let reflected = scatter_towards(mirrored, vec3<f32>(coat / share), LOBE_SPECULAR);
        if is_above_coat(hit, mirrored) {
            return take_lobe(draw, reflected);
        }
        return take_lobe(draw, absorbed());
    }
    let alpha = hit.lobes.coat_roughness * hit.lobes.coat_roughness;
    let basis = basis_around(normal);
    let view = vec3<f32>(-in_basis(basis, hit.incoming).xy, clamp(-dot(hit.incoming, normal), 0.0, 1.0));
    let facet = from_basis(basis, sample_visible_normal(view, alpha, u));
    let direction = normalize(hit.incoming + 2.0 * clamp(-dot(hit.incoming, facet), 0.0, 1.0) * facet);
    if is_above_coat(hit, direction) {
        return take_lobe(draw, scatter_towards(direction, vec3<f32>(1.0), lobe_of(width_of_reflection(alpha))));
    }
    return take_lobe(draw, absorbed());
}

// The response of the microfacets of the coat, which reflect all.
fn coat_response(hit: Interaction, direction: vec3<f32>) -> Response {
    if is_smooth_coat(hit.lobes) || !is_above_coat(hit, direction) {
        return no_response();
    }
    let alpha = hit.lobes.coat_roughness * hit.lobes.coat_roughness;
    let cos_view = clamp(-dot(hit.incoming, hit.coat_normal), 0.0, 1.0);
    let cos_light = min(dot(direction, hit.coat_normal), 1.0);
    let half_way = direction - hit.incoming;
    let pdf = 0.25 * visible_density(microfacet_density(half_way, hit.coat_normal, alpha), cos_view, alpha);
    let value = vec3<f32>(pdf * smith_shadowing(cos_view, cos_light, alpha));
    return Response(value, pdf, select(0.0, 1.0, is_narrow(width_of_reflection(alpha))));
}

// A sample of what lies below, which the draw has weighted.
fn below_coat(scatter: Scatter, hit: Interaction) -> Scatter {
    return scatter;
}

fn with_coat(under: Response, material: Material, hit: Interaction, direction: vec3<f32>, albedo: f32) -> Response {
    let coat = coat_reflectance(hit);
    if coat == 0.0 {
        return under;
    }
    return mixed_response(under, coat_response(hit, direction), coat, share_of_coat(hit, albedo));
}

// Whether a specular event has the same weight in both orders. That of a coat with a normal of its own has not, nor has a refraction below a coat:
// its angles on both sides differ.
fn coat_is_reversible(hit: Interaction, reverse: Interaction) -> bool {
    let has_one_normal = all(hit.coat_normal == hit.normal) && all(reverse.coat_normal == reverse.normal);
    return hit.lobes.coat == 0.0 || (has_one_normal && hit.lobes.transmission == 0.0);
}

//@ without
// No material of glTF has a coat.
fn emission_under_coat(emission: vec3<f32>, hit: Interaction) -> vec3<f32> {
    return emission;
}

fn coat_is_reversible(hit: Interaction, reverse: Interaction) -> bool {
    return true;
}
