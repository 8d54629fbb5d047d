//@ use data/hit
//@ use data/light
//@ use data/material
//@ use data/path
//@ use data/surface
//@ use data/window
//@ use bind/settings
//@ use camera/film_point
//@ use choice/normal_map
//@ use scene/emission
//@ use scene/interaction
//@ use scene/near_mirrors
//@ use scene/responses
//@ use scene/reversal
// Camera paths beside light paths. The paths that both find have a first event that is not specular and a last one that is; near mirrors
// (scene/near_mirrors) count as specular there. Each such path
// is weighed by the balance heuristic: with r the density of light paths over that of camera paths, camera paths have the weight 1/(1 + r),
// and light paths r/(1 + r) (Veach, "Robust Monte Carlo Methods for Light Transport Simulation", 1997, sections 9.2 and 10.2). A path
// carries the product of r up to its last event (Georgiev, Krivanek, Davidovic, Slusallek, "Light Transport Simulation with Vertex
// Connection and Merging", ACM TOG 31(6), 2012), as a logarithm: it leaves the range of f32. What both kinds of path have alike is left out:
// distances between events, the transmittance of media and panes, roulette. So are the filter and the transmittance to the camera, because
// weights need only sum to 1.

// The logarithm (base 2) of a ratio of 0: no light path is like this one.
const NO_RATIO: f32 = -0x1p100f;
const LEAST_DENSITY: f32 = 0x1p-100f;

fn log_of_density(density: f32) -> f32 {
    return log2(max(density, LEAST_DENSITY));
}

// What the ratio has before the first event: light paths for each camera path of a pixel, over the density of that event's point. A light
// path reaches any pixel.
fn log_ratio_at_camera(direction: vec3<f32>, distance: f32, cosine: f32) -> f32 {
    let pixels = f32(settings.image_width) * f32(settings.image_height);
    let light_paths = pixels * f32(settings.light_paths) / f32(RUN_LENGTH);
    let density = log_of_density(density_of_camera_ray(direction)) + log_of_density(cosine);
    return log_of_density(light_paths) - density + 2.0 * log_of_density(distance);
}

// Adds an event on a surface to the ratio.
fn follow_ratio(
    path: ptr<function, Path>,
    hit: Hit,
    surface: Surface,
    interaction: Interaction,
    evaluated: EvaluatedMaterial,
    bsdf: Scatter,
) {
    let is_first = (*path).depth == 0u;
    let is_specular = bsdf.lobe == LOBE_SPECULAR;
    let to_camera = -(*path).ray.direction;
    let frame = shading_frame(hit, surface, -bsdf.direction);
    let reverse = interaction_at(hit, surface, frame, evaluated, -bsdf.direction);
    let is_kept = keep_side(scatter_towards(to_camera, vec3<f32>(1.0), bsdf.lobe), reverse.normal, frame.shading).event == SCATTERED;
    let is_reached = select(is_kept, !is_specular && !counts_as_specular(evaluated), is_first);
    if bsdf.event != SCATTERED || !is_reached || (is_specular && !is_reversible(interaction, bsdf.direction, reverse)) {
        (*path).log_ratio = NO_RATIO;
        return;
    }
    if is_specular {
        let ratio = specular_ratio(evaluated.material, interaction, surface.normal, to_camera, bsdf.direction);
        (*path).log_ratio += log_of_density(ratio);
        return;
    }
    // One call for both orders: first that of light paths, then that of camera paths.
    var pdfs = vec2<f32>(0.0);
    var order = reverse;
    var direction = to_camera;
    for (var i = 0u; i < 2u + settings.zero; i++) {
        pdfs = vec2<f32>(pdfs.y, response_of_material(evaluated.material, order, direction).pdf);
        order = interaction;
        direction = bsdf.direction;
    }
    let cos_camera = abs(dot(to_camera, surface.normal));
    let cos_light = abs(dot(bsdf.direction, surface.normal));
    let before = log_of_density(pdfs.x) - log_of_density(cos_camera) + (*path).log_ratio;
    let reached = select(before, log_ratio_at_camera(-to_camera, hit.t, cos_camera), is_first);
    (*path).log_ratio = reached + log_of_density(cos_light) - log_of_density(pdfs.y);
}

// Adds an event in a medium, at this distance. The phase function is the same in both orders.
fn follow_ratio_in_medium(path: ptr<function, Path>, distance: f32) {
    if (*path).depth == 0u {
        (*path).log_ratio = log_ratio_at_camera((*path).ray.direction, distance, 1.0) - log_of_density((*path).pdf);
    }
}

// Whether light paths find the light that a ray of this path finds in this lobe.
fn light_paths_follow(path: ptr<function, Path>, lobe: u32) -> bool {
    return FIND_ALL && lobe == LOBE_SPECULAR && (*path).depth > 0u && (*path).log_ratio > 0.5 * NO_RATIO;
}

// Whether light paths find the light that a ray of this path finds by a near mirror, so that light sampling does not.
fn light_paths_replace_samples(path: ptr<function, Path>, evaluated: EvaluatedMaterial) -> bool {
    return counts_as_specular(evaluated) && light_paths_follow(path, LOBE_SPECULAR);
}

// The weight of emission that the path's ray has hit, beside light paths. `weight` is that beside light sampling, which is 1 after a
// specular event.
fn weigh_beside_light_paths(path: ptr<function, Path>, hit: Hit, surface: Surface, weight: f32) -> f32 {
    if (*path).depth < 2u || (*path).pdf > 0.0 || !((*path).log_ratio > 0.5 * NO_RATIO) {
        return weight;
    }
    let emission = density_of_emission(hit, surface, (*path).ray.direction);
    return weight * select(1.0, 1.0 / (1.0 + exp2((*path).log_ratio + log2(emission))), emission > 0.0);
}
