//@ use material/glass
//@ use material/pane
//@ use material/pbr_base
// KHR_materials_transmission with a share between: (1 - t) of the base and t of glass, with t the share of what is no metal
// (extension/transmission). The glass is that of a rough dielectric, or of a thin one, of the same roughness. It tints what passes by the
// base colour.

fn is_solid_glass(hit: Interaction) -> bool {
    return hit.lobes.ior > 0.0;
}

fn glass_of(material: Material, lobes: Lobes) -> Glass {
    return Glass(pbr_roughness(material), lobes.ior, lobes.contrasts);
}

fn is_rough_glass(material: Material, lobes: Lobes) -> bool {
    let roughness = pbr_roughness(material);
    if lobes.ior > 0.0 {
        return is_rough_boundary(roughness * roughness, lobes.contrasts.x);
    }
    return roughness >= LEAST_ROUGHNESS;
}

// Whether the material has a lobe that is not specular: `under` says it of what lies below.
fn transmission_spreads(material: Material, lobes: Lobes, under: bool) -> bool {
    return (under && lobes.transmission < 1.0) || (lobes.transmission > 0.0 && is_rough_glass(material, lobes));
}

// The colour of light in this direction, which glass tints where it passes.
fn tint_of_glass(hit: Interaction, direction: vec3<f32>) -> vec3<f32> {
    return select(vec3<f32>(1.0), hit.colour, dot(direction, hit.normal) < 0.0);
}

fn reflectance_of_glass(material: Material, hit: Interaction, cos_view: f32) -> f32 {
    let contrast = select(hit.lobes.contrasts.y, hit.lobes.contrasts.x, hit.front || !is_solid_glass(hit));
    return fresnel(cos_view, sqrt(1.0 + contrast), contrast).reflectance;
}

fn albedo_of_glass(material: Material, hit: Interaction) -> f32 {
    let cos_view = clamp(-dot(hit.incoming, hit.normal), 0.0, 1.0);
    let passed = dot(hit.colour, vec3<f32>(1.0)) / 3.0;
    return mix(passed, 1.0, reflectance_of_glass(material, hit, cos_view));
}

fn transmission_albedo(material: Material, hit: Interaction, under: f32) -> f32 {
    return mix(under, albedo_of_glass(material, hit), hit.lobes.transmission);
}

// The probability of drawing from the glass: its share of the light that comes from the view.
fn share_of_glass(material: Material, hit: Interaction, base: f32) -> f32 {
    let glass = hit.lobes.transmission * albedo_of_glass(material, hit);
    let all = glass + (1.0 - hit.lobes.transmission) * base;
    return select(hit.lobes.transmission, glass / all, all > 0.0);
}

// A smooth pane reflects, or lets light pass straight on, which is an event here: the base is no pane.
fn smooth_pane_scatter(material: Material, hit: Interaction, u: f32) -> Scatter {
    let cos_view = clamp(-dot(hit.incoming, hit.normal), 0.0, 1.0);
    let reflected = reflected_by_pane(glass_of(material, hit.lobes), hit, cos_view);
    let mirrored = normalize(hit.incoming + 2.0 * cos_view * hit.normal);
    if u < reflected.chance {
        return scatter_towards(mirrored, reflected.colour, LOBE_SPECULAR);
    }
    return scatter_towards(hit.incoming, vec3<f32>(1.0), LOBE_SPECULAR);
}

fn glass_scatter(material: Material, hit: Interaction, u: vec4<f32>) -> Scatter {
    if is_solid_glass(hit) {
        return scatter_at_boundary(glass_of(material, hit.lobes), hit, u);
    }
    if !is_rough_glass(material, hit.lobes) {
        return smooth_pane_scatter(material, hit, u.x);
    }
    return scatter_at_pane(glass_of(material, hit.lobes), hit, u);
}

fn draw_transmission(draw: LobeDraw, material: Material, hit: Interaction, u: vec2<f32>, under: f32) -> LobeDraw {
    if draw.is_drawn || hit.lobes.transmission == 0.0 {
        return draw;
    }
    let share = share_of_glass(material, hit, under);
    if draw.u >= share {
        return draw_from_rest(draw, share, 1.0 - hit.lobes.transmission);
    }
    var found = glass_scatter(material, hit, vec4<f32>(uniform_below(draw.u, share), 0.0, u));
    found.weight *= tint_of_glass(hit, found.direction) * (hit.lobes.transmission / share * draw.rest);
    return take_lobe(draw, found);
}

fn with_transmission(under: Response, material: Material, hit: Interaction, direction: vec3<f32>, albedo: f32) -> Response {
    if hit.lobes.transmission == 0.0 {
        return under;
    }
    var glass = no_response();
    if is_rough_glass(material, hit.lobes) {
        if is_solid_glass(hit) {
            glass = boundary_response(glass_of(material, hit.lobes), hit, direction);
        } else {
            glass = pane_response(glass_of(material, hit.lobes), hit, direction);
        }
    }
    glass.value *= tint_of_glass(hit, direction);
    return mixed_response(under, glass, hit.lobes.transmission, share_of_glass(material, hit, albedo));
}

// A sample of what lies below, which the draw has weighted.
fn below_transmission(scatter: Scatter, hit: Interaction) -> Scatter {
    return scatter;
}
