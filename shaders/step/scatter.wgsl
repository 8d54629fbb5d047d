//@ use data/path
//@ use data/dimension
//@ use data/primitive
//@ use bind/settings
//@ use bind/materials
//@ use choice/sampler
//@ use scene/materials
//@ use scene/surfaces
//@ if undetailed
//@ use choice/colour
//@ end
//@ use choice/roulette
//@ use choice/shading
//@ if two_parts
//@ use scene/second_parts
//@ end
//@ if detailed
//@ use scene/looks
//@ end
//@ if normal_map
//@ use scene/normal_map
//@ end
//@ if multiscatter
//@ use scene/multiscatter
//@ end
//@ if tinted
//@ use scene/tint
//@ end
//@ if absorbing
//@ use scene/absorption
//@ end
//@ if own_glow
//@ use choice/clamp
//@ end
//@ if glow_is_sampled
//@ use step/light
//@ end
//@ if glow_direct
//@ use step/aov_direct
//@ end
//@ if surface_samples_light
//@ use scene/responses
//@ use step/light
//@ end
//@ if met_light
//@ use step/light
//@ end
//@ if sends_shadow_ray
//@ use step/light
//@ end
//@ if light
//@ use choice/probe
//@ end
//@ if aov_surface
//@ use scene/responses
//@ use step/aov_surface
//@ end
// The material at the path's hit scatters the path or ends it.
fn scatter_path(path: ptr<function, Path>) {
    let ray = (*path).ray;
    let hit = path_hit(path);
    let surface = surface_at(hit, ray);
    //@ if undetailed
    let material = materials[surface.material];
    //@ end
    let front = dot(ray.direction, surface.normal) < 0.0;
    let facing = select(-surface.normal, surface.normal, front);
    let shading = shading_normal(hit, surface, ray.direction, facing);
    //@ if undetailed
    let colour = surface_colour(material, hit, surface);
    //@ end
    //@ if detailed
    let look = look_at(hit, surface, front);
    let material = look.material;
    let colour = look.colour;
    //@ end
    //@ if normal_map
    let mapped = mapped_normal(hit, surface, ray.direction, shading, front, look.normal);
    //@ end
    //@ if single_scattering
    let arriving = Interaction(
    //@ end
    //@ if multiscatter
    var arriving = Interaction(
    //@ end
        //@ if plain_normal
        ray.direction, shading, front, colour,
        //@ end
        //@ if normal_map
        ray.direction, mapped, front, colour,
        //@ end
        //@ if two_parts
        second_part_of(material, surface.material),
        //@ end
        //@ if multiscatter
        0.0,
        //@ end
        //@ if own_layer
        look.straight, look.grazing,
        //@ end
    );
    //@ if multiscatter
    arriving.lost_over_kept = lost_over_kept(material, surface, arriving);
    //@ end
    let point = event_point(hit, surface, facing);
    //@ if absorbing
    (*path).throughput *= left_by_absorption(surface, front, hit.t);
    //@ end

    let depth = (*path).depth;
    let u = random4((*path).pixel, (*path).sample, bounce_dimension(depth, DIMENSION_SCATTER), settings.seed);
    //@ if plain_normal
    let scattered = scatter_by_material(material, arriving, u);
    //@ end
    //@ if normal_map
    var scattered = scatter_by_material(material, arriving, u);
    if scattered.event == SCATTERED && !keeps_its_side(scattered.direction, mapped, shading) {
        scattered = absorbed();
    }
    //@ end
    //@ if aov_surface
    let passes = scattered.event == SCATTERED && !is_non_specular(material);
    let share = select(scattered.weight, vec3<f32>(1.0), scattered.event == EMITTED);
    note_surface(path, passes, (*path).throughput * share, arriving.normal);
    //@ end
    //@ if own_glow
    // A surface that emits and scatters brings its light, and the path goes on.
    let glow = select(look.glow, vec3<f32>(0.0), scattered.event == EMITTED);
    var brought = (*path).throughput * glow;
    //@ end
    //@ if glow_is_sampled
    if any(glow > vec3<f32>(0.0)) {
        brought *= mis_weight(path, hit);
        note_found_light(path, hit, glow, brought);
    }
    //@ end
    //@ if glow_direct
    note_direct(path, brought, depth);
    //@ end
    //@ if own_glow
    (*path).radiance += limited_indirect(brought, depth);
    //@ end
    //@ if met_light
    if scattered.event == EMITTED {
        (*path).throughput *= mis_weight(path, hit);
        note_found_light(path, hit, scattered.weight, (*path).throughput * scattered.weight);
    }
    //@ end
    //@ if light
    var pdf = 0.0;
    var share_of_narrow = 0.0;
    var samples_lights = false;
    //@ end
    //@ if surface_samples_light
    // Non-specular materials sample lights, on the side from which the ray comes.
    samples_lights = depth < settings.max_depth && is_non_specular(material);
    //@ end
    //@ if sends_shadow_ray
    let probes = scattered.event == SCATTERED && sends_probe(path, scattered.lobe);
    // Both sample a light here: GPUs inline the functions of all kinds of lights at each call.
    if samples_lights || probes {
    //@ end
    //@ if both_sides
        // On a smooth mesh, the two sides of a facet have two points. A material that responds on both chooses one of them
        // before it aims at a light.
        let chooses = samples_lights && responds_on_both_sides(material) && is_smooth(hit.code);
        let below = chooses && u.y < 0.5;
        let facet_point = leave_surface(surface.point, surface.error, -facing, -facing);
        let point = select(point, facet_point, below);
    //@ end
    //@ if sends_shadow_ray
        let light_sample = sample_light(path, point);
        var probed_share = 1.0;
        var response = Response();
        var leaving = scattered.direction;
    //@ end
    //@ if surface_samples_light
        if samples_lights {
            response = response_of_material(material, arriving, light_sample.direction);
            share_of_narrow = response.narrow;
            leaving = light_sample.direction;
            pdf = response_of_material(material, arriving, scattered.direction).pdf;
        }
    //@ end
    //@ if normal_map_in_light
        if samples_lights && !keeps_its_side(light_sample.direction, mapped, shading) {
            response.value = vec3<f32>(0.0);
        }
    //@ end
    //@ if both_sides
        // The other side is never aimed at. Light sampling has half of its density on this one, which is the same to MIS as twice
        // the density of the material.
        if chooses {
            let is_aimed_at = (dot(light_sample.direction, shading) < 0.0) == below;
            probed_share = select(0.0, 2.0, is_aimed_at);
            response.value *= probed_share;
            response.pdf *= 2.0;
            pdf *= 2.0;
        }
    //@ end
    //@ if tinted_in_light
        response.value *= tint_of(material, colour, leaving, shading);
    //@ end
    //@ if sends_shadow_ray
        aim_probe(path, probes, scattered, light_sample.direction, shading, probed_share);
        let origin = spawn_ray(hit, surface, facing, shading, point, leaving).origin;
        send_shadow_ray(path, light_sample, origin, response.value, response.pdf);
    }
    //@ end
    //@ if light
    // A specular lobe has no density.
    (*path).pdf = select(pdf, 0.0, scattered.lobe == LOBE_SPECULAR);
    note_event(path, scattered.lobe, share_of_narrow);
    //@ end
    var throughput = (*path).throughput * scattered.weight;
    //@ if tinted
    throughput *= tint_of(material, colour, scattered.direction, shading);
    //@ end
    if scattered.event == SCATTERED {
        throughput = russian_roulette(path, throughput);
    }
    let goes_on = scattered.event == SCATTERED && depth < settings.max_depth && any(throughput != vec3<f32>(0.0));
    if goes_on {
        (*path).ray = spawn_ray(hit, surface, facing, shading, point, scattered.direction);
        (*path).status = RAY_READY;
        (*path).throughput = throughput;
        (*path).depth = depth + 1u;
    } else if scattered.event == SCATTERED && any(throughput != vec3<f32>(0.0)) {
        (*path).status = PATH_TOO_DEEP;
        (*path).throughput = throughput;
    } else {
        (*path).status = PATH_ENDED;
        (*path).throughput = select(vec3<f32>(0.0), throughput, scattered.event == EMITTED);
    }
}
