//@ implements density_ratio when light_paths
//@ use bind/settings
//@ use choice/both_sides
//@ use choice/camera_view
//@ use choice/delta_emission
//@ use choice/delta_lights
//@ use choice/light_surfaces
//@ use choice/normal_map
//@ use choice/one_sided
//@ use light_path/emission
//@ use scene/at_run_time
//@ use scene/interaction
//@ use scene/responses
//@ use light_path/reversal
// Camera paths beside light paths. The paths that both find have a first event that is not specular and a last one that scatters into a specular
// or a narrow lobe. Three techniques find their light: BSDF sampling, light sampling and light paths, with the densities p_b, p_l and p_t. By
// the balance heuristic (Veach, "Robust Monte Carlo Methods for Light Transport Simulation", 1997, sections 9.2 and 10.2), light paths have the
// weight W = p_t / (p_b + p_l + p_t). The other two keep the weights that they have without light paths, times 1 - W. A path
// carries the product of p_t / p_b up to its last event (Georgiev, Krivanek, Davidovic, Slusallek, "Light Transport Simulation with Vertex
// Connection and Merging", ACM TOG 31(6), 2012), as a logarithm: it leaves the range of f32. What all techniques have alike is left out:
// distances between events, the transmittance of media and panes, roulette. So are the filter and the transmittance to the camera, because
// weights need only sum to 1.

// The logarithm (base 2) of a ratio of 0: no light path is like this one.
const NO_RATIO: f32 = -0x1p100f;

// Whether a material has a narrow lobe. If none has, light paths begin with specular events alone, whose light is not sampled.
const NARROW_LOBES: bool = ${narrow_lobes}u == 1u;

fn has_ratio(log_ratio: f32) -> bool {
    return log_ratio > 0.5 * NO_RATIO;
}

// What the ratio has before the first event: light paths for each camera path of a pixel, over the density of that event's point. A light
// path reaches any pixel.
fn log_ratio_at_camera(direction: vec3<f32>, distance: f32, cosine: f32) -> f32 {
    let pixels = f32(settings.image_width) * f32(settings.image_height);
    let light_paths = pixels * f32(settings.light_paths) / f32(RUN_LENGTH);
    let density = log_density_of_camera(direction) + log_of_density(cosine);
    return log_of_density(light_paths) - density + log_spread_of_camera(distance);
}

// An event in the order of light paths.
struct ReverseEvent {
    interaction: Interaction,
    // Whether the camera is on the right side of the surface.
    is_kept: bool,
    // The response to the camera, and the share of its density with which a light path begins at this event.
    response: Response,
}

// An event in the orders for its light sample and for its BSDF sample.
struct ReverseEvents {
    of_light: ReverseEvent,
    of_sample: ReverseEvent,
}

// Adds an event on a surface to the ratio, and finds that of the light which the event has sampled.
fn follow_ratio(
    path: ptr<function, Path>,
    hit: Hit,
    surface: Surface,
    interaction: Interaction,
    evaluated: EvaluatedMaterial,
    bsdf: Scatter,
) {
    let before = (*path).log_ratio;
    let is_first = (*path).depth == 0u;
    let is_specular = bsdf.lobe == LOBE_SPECULAR;
    let to_camera = -(*path).ray.direction;
    let to_light = (*path).shadow.direction;
    (*path).log_ratio = NO_RATIO;
    (*path).light_ratio = NO_RATIO;
    (*path).narrow_share = 0.0;
    // Without narrow lobes there is one turn, for the BSDF sample.
    var reversed: ReverseEvents;
    for (var i = select(1u, 0u, NARROW_LOBES); i < turns_of_loop(2u); i++) {
        let incoming = -select(to_light, bsdf.direction, i == 1u);
        let frame = shading_frame(hit, surface, incoming);
        let reverse = interaction_at(hit, surface, frame, evaluated, incoming);
        let lobe = select(LOBE_WIDE, bsdf.lobe, i == 1u);
        let is_kept = keep_side(scatter_towards(to_camera, vec3<f32>(1.0), lobe), reverse.normal, frame.shading).event == SCATTERED && !is_behind(surface, frame.front);
        let own = ReverseEvent(reverse, is_kept, response_of_material(evaluated.material, reverse, to_camera));
        reversed = ReverseEvents(reversed.of_sample, own);
    }
    let cos_camera = abs(dot(to_camera, surface.normal));
    let points = points_of_event(evaluated, hit);
    if NARROW_LOBES && (*path).light != NO_LIGHT && !is_first && has_ratio(before) && reversed.of_light.is_kept {
        let density = log_of_density(reversed.of_light.response.pdf * reversed.of_light.response.narrow) - log_of_density(cos_camera);
        let cos_light = abs(dot(to_light, surface.normal));
        (*path).light_ratio = before + density + log_of_density(cos_light) - log_of_density((*path).light_density / points);
    }
    let is_reached = is_first || has_ratio(before);
    if bsdf.event != SCATTERED || !is_reached || !select(reversed.of_sample.is_kept, !is_specular, is_first) {
        return;
    }
    if is_specular {
        if is_reversible(interaction, bsdf.direction, reversed.of_sample.interaction) {
            let ratio = specular_ratio(evaluated.material, interaction, surface.normal, to_camera, bsdf.direction);
            (*path).log_ratio = before + log_of_density(ratio);
            (*path).narrow_share = 1.0;
        }
        return;
    }
    let cos_light = abs(dot(bsdf.direction, surface.normal));
    let density = log_of_density(reversed.of_sample.response.pdf) - log_of_density(cos_camera);
    let reached = select(before + density, log_ratio_at_camera(-to_camera, hit.t, cos_camera), is_first);
    (*path).log_ratio = reached + log_of_density(cos_light) - log_of_density((*path).pdf / points);
    (*path).narrow_share = reversed.of_sample.response.narrow;
}

// Adds an event in a medium, at this distance. The phase function is the same in both orders. No light path begins there.
fn follow_ratio_in_medium(path: ptr<function, Path>, distance: f32) {
    if (*path).depth == 0u {
        (*path).log_ratio = log_ratio_at_camera((*path).ray.direction, distance, 1.0) - log_of_density((*path).pdf);
    }
    (*path).light_ratio = NO_RATIO;
    (*path).narrow_share = 0.0;
}

// The weight of emission that the path's ray has hit. `weight` is that beside light sampling alone, 1 / (1 + (p_l / p_b)^2).
fn weigh_beside_light_paths(path: ptr<function, Path>, hit: Hit, surface: Surface, weight: f32) -> f32 {
    if (*path).depth < 2u || !((*path).narrow_share > 0.0) || !has_ratio((*path).log_ratio) {
        return weight;
    }
    let emission = (*path).narrow_share * density_of_emission(hit, surface, (*path).ray.direction);
    let others = 1.0 + sqrt(max(1.0 / weight - 1.0, 0.0));
    return weight * select(1.0, others / (others + exp2((*path).log_ratio + log2(emission))), emission > 0.0);
}

// 1 - W for the light of the path's shadow ray, which is hit here.
fn weigh_sample_beside_light_paths(path: ptr<function, Path>, hit: Hit) -> f32 {
    if !NARROW_LOBES || !has_ratio((*path).light_ratio) || hit.code == HIT_NOTHING {
        return 1.0;
    }
    let shadow = (*path).shadow;
    var emission = 0.0;
    if is_delta_light(hit.code) {
        emission = density_of_delta_emission(hit.code, shadow);
    } else {
        emission = density_of_emission(hit, light_surface_at(hit, shadow), shadow.direction);
    }
    return select(1.0, 1.0 / (1.0 + exp2((*path).light_ratio + log2(emission))), emission > 0.0);
}

//@ without
// No light paths are traced.
fn follow_ratio(
    path: ptr<function, Path>,
    hit: Hit,
    surface: Surface,
    interaction: Interaction,
    evaluated: EvaluatedMaterial,
    bsdf: Scatter,
) {
}

fn follow_ratio_in_medium(path: ptr<function, Path>, distance: f32) {
}

fn weigh_beside_light_paths(path: ptr<function, Path>, hit: Hit, surface: Surface, weight: f32) -> f32 {
    return weight;
}

fn weigh_sample_beside_light_paths(path: ptr<function, Path>, hit: Hit) -> f32 {
    return 1.0;
}
