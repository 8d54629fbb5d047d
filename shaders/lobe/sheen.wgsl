//@ use lobe/sheen_albedo
// KHR_materials_sheen: fibres over the base. What lies below has the factor min(1 - m E(v), 1 - m E(l)), with m the largest channel of the
// colour and E the directional albedo of white sheen. Where E is more than 1, at grazing angles of a low roughness, the sheen is
// divided by it, so that it returns no more light than there is. Directions are sampled by the cosine.

fn has_sheen(lobes: Lobes) -> bool {
    return any(lobes.sheen > vec3<f32>(0.0));
}

fn sheen_spreads(material: Material, lobes: Lobes, under: bool) -> bool {
    return under || has_sheen(lobes);
}

// The albedos at the view and at the light.
fn sheen_albedos(hit: Interaction, direction: vec3<f32>) -> vec2<f32> {
    let roughness = hit.lobes.sheen_roughness;
    let cos_view = clamp(-dot(hit.incoming, hit.normal), 0.0, 1.0);
    let cos_light = min(abs(dot(direction, hit.normal)), 1.0);
    return vec2<f32>(white_sheen_albedo(cos_view, roughness), white_sheen_albedo(cos_light, roughness));
}

fn sheen_scaling(hit: Interaction, albedos: vec2<f32>) -> f32 {
    let most = max(max(hit.lobes.sheen.x, hit.lobes.sheen.y), hit.lobes.sheen.z);
    return 1.0 - most * min(max(albedos.x, albedos.y), 1.0);
}

// The weight of what lies below the sheen, in a specular lobe.
fn below_sheen(scatter: Scatter, hit: Interaction) -> Scatter {
    if !has_sheen(hit.lobes) {
        return scatter;
    }
    var scaled = scatter;
    scaled.weight *= sheen_scaling(hit, sheen_albedos(hit, scatter.direction));
    return scaled;
}

// What comes back to the view of the sheen by itself, and of all.
fn albedo_of_sheen(hit: Interaction) -> f32 {
    let albedo = min(sheen_albedos(hit, hit.incoming).x, 1.0);
    return albedo * dot(hit.lobes.sheen, vec3<f32>(1.0)) / 3.0;
}

fn sheen_albedo(material: Material, hit: Interaction, under: f32) -> f32 {
    if !has_sheen(hit.lobes) {
        return under;
    }
    return albedo_of_sheen(hit) + sheen_scaling(hit, sheen_albedos(hit, hit.incoming)) * under;
}

// The probability of drawing from the sheen: its share of the light that comes from the view, between 0.05 and 0.95, since where the view has
// none there is some for other lights.
fn share_of_sheen(material: Material, hit: Interaction, under: f32) -> f32 {
    if under == 0.0 {
        return 1.0;
    }
    return clamp(albedo_of_sheen(hit) / sheen_albedo(material, hit, under), 0.05, 0.95);
}

fn draw_sheen(draw: LobeDraw, material: Material, hit: Interaction, u: vec2<f32>, under: f32) -> LobeDraw {
    if draw.is_drawn || !has_sheen(hit.lobes) {
        return draw;
    }
    let share = share_of_sheen(material, hit, under);
    if draw.u >= share {
        return draw_from_rest(draw, share, 1.0);
    }
    let direction = normalize(from_basis(basis_around(hit.normal), sample_cosine_hemisphere(u)));
    return take_lobe(draw, scatter_towards(direction, vec3<f32>(1.0), LOBE_WIDE));
}

// D / (4 cos_view (1 + lambda_view + lambda_light)): the BRDF of white sheen times the cosine of the light.
fn white_sheen(hit: Interaction, direction: vec3<f32>) -> f32 {
    let alpha = charlie_alpha(hit.lobes.sheen_roughness);
    let cos_view = clamp(-dot(hit.incoming, hit.normal), 0x1p-24f, 1.0);
    let cos_light = min(dot(direction, hit.normal), 1.0);
    let half_way = direction - hit.incoming;
    let height = dot(half_way, hit.normal);
    let across = half_way - height * hit.normal;
    let sine2 = dot(across, across) / dot(half_way, half_way);
    let hidden = charlie_lambda(cos_view, alpha) + charlie_lambda(cos_light, alpha);
    return charlie_density(min(sine2, 1.0), alpha) / (4.0 * cos_view * (1.0 + hidden));
}

fn with_sheen(under: Response, material: Material, hit: Interaction, direction: vec3<f32>, albedo: f32) -> Response {
    if !has_sheen(hit.lobes) {
        return under;
    }
    let albedos = sheen_albedos(hit, direction);
    let cos_light = dot(direction, hit.normal);
    var value = sheen_scaling(hit, albedos) * under.value;
    let share = share_of_sheen(material, hit, albedo);
    let of_sheen = share * max(cos_light, 0.0) / PI;
    if cos_light > 0.0 {
        value += hit.lobes.sheen * (white_sheen(hit, direction) / max(max(albedos.x, albedos.y), 1.0));
    }
    let of_rest = (1.0 - share) * under.pdf;
    let pdf = of_rest + of_sheen;
    return Response(value, pdf, select(0.0, min(of_rest * under.narrow / pdf, 1.0), pdf > 0.0));
}
