//@ implements scatter when surface
//@ use bind/settings
//@ use choice/mix
//@ use choice/evaluation
//@ use choice/followed_channel
//@ use choice/normal_map
//@ use choice/absorption
//@ use choice/one_sided
//@ use choice/tint
//@ use choice/roulette
//@ use choice/surface_emission
//@ use choice/found_light
//@ use choice/surface_light
//@ use choice/density_ratio
//@ use choice/aov_surface
//@ use choice/clamp
//@ use choice/light_groups
//@ use scene/materials
//@ use scene/interaction
// The material at the path's hit scatters the path or ends it.
fn scatter_path(path: ptr<function, Path>) {
    // The hit and its shading frame.
    let ray = (*path).ray;
    let hit = path_hit(path);
    let surface = surface_of_event(path, hit);
    let frame = shading_frame(hit, surface, ray.direction);

    // The material with its textures.
    let evaluated = follow_channel(path, evaluate_material(hit, surface, frame.front));
    let interaction = interaction_at(hit, surface, frame, evaluated, ray.direction);
    (*path).throughput = absorb_inside((*path).throughput, surface, frame.front, hit.t);
    (*path).throughput = absorb_behind((*path).throughput, surface, frame.front);

    // The BSDF sample.
    let u = scatter_random(path, evaluated);
    let drawn = scatter_by_material(evaluated.material, interaction, u);
    let bsdf = keep_side(drawn, interaction.normal, frame.shading);
    record_surface(path, evaluated, bsdf, interaction.normal);

    // Emission, whose MIS weight needs the density of the event before. Then light sampling, which stores the density of this event.
    let emission_weight = weight_of_emission(path, hit, surface, radiance_of_surface(interaction, bsdf), bsdf.event);
    add_surface_emission(path, hit, interaction, bsdf, emission_weight);
    (*path).throughput *= select(1.0, emission_weight, bsdf.event == EMITTED);
    sample_light_at_surface(path, hit, surface, frame, interaction, evaluated, bsdf, u.y);

    follow_ratio(path, hit, surface, interaction, evaluated, bsdf);

    // Throughput, roulette, the next ray.
    var throughput = tint_through((*path).throughput * bsdf.weight, evaluated, bsdf.direction, frame.shading);
    if bsdf.event == SCATTERED {
        throughput = russian_roulette(path, throughput);
    }
    continue_path(path, bsdf, throughput, hit, surface, frame);
}

// Puts the path onto its next ray, or ends it.
fn continue_path(
    path: ptr<function, Path>,
    bsdf: Scatter,
    throughput: vec3<f32>,
    hit: Hit,
    surface: Surface,
    frame: ShadingFrame,
) {
    let depth = (*path).depth;
    let is_scattered = bsdf.event == SCATTERED && any(throughput != vec3<f32>(0.0));
    if is_scattered && depth < settings.max_depth {
        (*path).ray = spawn_ray(hit, surface, frame.facing, frame.shading, frame.point, bsdf.direction);
        (*path).status = RAY_READY;
        (*path).throughput = throughput;
        (*path).depth = depth + 1u;
    } else if is_scattered {
        (*path).status = PATH_TOO_DEEP;
        (*path).throughput = throughput;
    } else {
        (*path).status = PATH_ENDED;
        (*path).throughput = select(vec3<f32>(0.0), throughput, bsdf.event == EMITTED);
        record_light(path, hit, limited_indirect((*path).throughput, depth));
    }
}

//@ without
// There is no surface to hit.
const ITERATIONS_OF_SHADING: u32 = 0u;

fn scatter_path(path: ptr<function, Path>) {
}
