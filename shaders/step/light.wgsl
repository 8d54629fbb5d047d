//@ use data/hit
//@ use data/path
//@ use data/dimension
//@ use data/light
//@ use bind/settings
//@ use choice/sampler
//@ use lib/float
//@ use choice/walk
//@ if alpha
//@ use scene/coverage
//@ end
//@ if medium
//@ use scene/transmittance
//@ end
//@ use choice/clamp
//@ use choice/probe
//@ if aov_direct
//@ use step/aov_direct
//@ end
//@ use scene/lights
//@ if emitting_sky
//@ use scene/background
//@ end
//@ if emitting_surface
//@ use bind/materials
//@ use choice/colour
//@ use scene/surfaces
//@ end
//@ if glow
//@ use scene/glow
//@ end
// Light sampling: each event sends a shadow ray to a light, in addition to the ray that continues the path. Both rays can find
// the same light. They are combined by multiple importance sampling with the power heuristic (Veach, "Robust Monte Carlo
// Methods for Light Transport Simulation", 1997, section 9.2.4).

// A sampled light, and a sampled direction to it from the point of an event.
struct LightSample {
    light: u32,
    direction: vec3<f32>,
    // The joint pdf of light and direction; 0 if no light can be sampled.
    pdf: f32,
}

fn sample_light(path: ptr<function, Path>, from_point: vec3<f32>) -> LightSample {
    let u = random4((*path).pixel, (*path).sample, bounce_dimension((*path).depth, DIMENSION_LIGHT), settings.seed);
    let choice = choose_light(from_point, u.xw);
    let light = lights[choice.index];
    let sample = direction_to_light(light, from_point, u.yzw);
    return LightSample(choice.index, sample.direction, choice.probability * sample.pdf);
}

// Stores a shadow ray to the light. `response` is BSDF times cosine, or the phase function. `pdf` is the pdf with which BSDF
// sampling draws the same direction.
fn send_shadow_ray(path: ptr<function, Path>, light_sample: LightSample, origin: vec3<f32>, response: vec3<f32>, pdf: f32) {
    //@ if delta_light
    if is_delta_light(lights[light_sample.light].code) {
        send_to_delta_light(path, light_sample, origin, response);
        return;
    }
    //@ end
    let weight = (*path).throughput * response * (power_heuristic(light_sample.pdf, pdf) / light_sample.pdf);
    weigh_probe(path, light_sample.pdf, true);
    if light_sample.pdf > 0.0 && (any(weight > vec3<f32>(0.0)) || is_probe(path)) {
        let light = lights[light_sample.light];
        (*path).shadow = Ray(origin, light_sample.direction);
        (*path).light = light.code;
        //@ if emitting_mesh
        (*path).light_instance = light.instance;
        //@ end
        (*path).light_weight = weight_of_light(weight, (*path).depth);
    }
}

//@ if delta_light
// The same to a light without size. BSDF sampling never hits it, so the MIS weight is 1. The ray's weight has the light's intensity.
fn send_to_delta_light(path: ptr<function, Path>, light_sample: LightSample, origin: vec3<f32>, response: vec3<f32>) {
    let code = lights[light_sample.light].code;
    let intensity = delta_light_intensity(light_sample.direction, delta_lights[primitive_index(code)]);
    let weight = (*path).throughput * response * intensity / light_sample.pdf;
    weigh_probe(path, light_sample.pdf, false);
    if light_sample.pdf > 0.0 && (any(weight > vec3<f32>(0.0)) || is_probe(path)) {
        (*path).shadow = Ray(origin, light_sample.direction);
        (*path).light = code;
        (*path).light_weight = weight_of_light(weight, (*path).depth);
    }
}

//@ end
// The MIS weight of a light that BSDF sampling hit; 1 if light sampling cannot sample it.
fn mis_weight(path: ptr<function, Path>, hit: Hit) -> f32 {
    let pdf = (*path).pdf;
    if !(pdf > 0.0) {
        return 1.0;
    }
    return power_heuristic(pdf, light_density(hit, (*path).ray.origin, (*path).ray.direction));
}

// The hit of the shadow ray on its light. Hits beyond it do not matter.
fn limit_of_shadow(path: ptr<function, Path>) -> Hit {
    //@ if delta_light
    if is_delta_light((*path).light) {
        let light = delta_lights[primitive_index((*path).light)];
        let distance = delta_light_distance((*path).shadow.origin, (*path).shadow.direction, light);
        return hit_at((*path).light, select(VERY_FAR, distance, light.has_place > 0.0));
    }
    //@ end
    //@ if emitting_surface
    if (*path).light != HIT_NOTHING {
        return limit_at_surface(path);
    }
    //@ end
    return hit_at(HIT_NOTHING, VERY_FAR);
}

fn limit_at_surface(path: ptr<function, Path>) -> Hit {
    let code = (*path).light;
    var ray = (*path).shadow;
    // Only the faces of meshes need this.
    var inverse = vec3<f32>(0.0);
    //@ if emitting_mesh
    if primitive_kind(code) == KIND_TRIANGLE {
        ray = to_mesh(instances[at_run_time((*path).light_instance)], ray);
        inverse = slab_inverse(ray.direction);
    }
    //@ end
    let t = light_hit_distance(code, ray, inverse);
    // Rounding can make a sampled direction miss a light that is tiny as seen from here, or miss the edge of any light. The
    // sample counts nevertheless, because the pdf says that it was drawn. Only a hit before the light blocks it.
    var limit = hit_at(code, select(distance_to_light(code, ray), t, t != NO_HIT));
    //@ if emitting_mesh
    limit.instance = (*path).light_instance;
    //@ end
    return limit;
}

// Traces the shadow ray, and adds the light if nothing blocks it. Returns the number of steps.
fn trace_shadow(path: ptr<function, Path>) -> u32 {
    let limit = limit_of_shadow(path);
    let hit = shadow_hit(path, limit);
    return add_light_of_shadow(path, limit, hit);
}

// The first hit of the shadow ray, up to the one on its light.
fn shadow_hit(path: ptr<function, Path>, limit: Hit) -> Hit {
    if !(limit.t > 0.0) {
        // Behind the origin. The light is none that HIT_NOTHING stands for, so it counts as hidden.
        var none = hit_at(HIT_NOTHING, limit.t);
        none.steps = 1u;
        return none;
    }
    //@ if alpha
    walk_for((*path).pixel, (*path).sample, bounce_dimension((*path).depth, DIMENSION_LIGHT));
    //@ end
    return first_hit((*path).shadow, settings.root, limit, true);
}

// Adds the light of the shadow ray with this first hit, if it is the one on its light. Returns the number of steps.
fn add_light_of_shadow(path: ptr<function, Path>, limit: Hit, hit: Hit) -> u32 {
    let code = (*path).light;
    (*path).light = NO_LIGHT;
    (*path).rays += 1u;
    var is_hidden = hit.code != code;
    //@ if emitting_mesh
    is_hidden |= hit.instance != limit.instance;
    //@ end
    var status = (*path).status;
    var steps = hit.steps;
    var brought = vec3<f32>(0.0);
    if !is_hidden {
        let emitted = emitted_along((*path).shadow, hit);
        var radiance = emitted;
        //@ if alpha_of_light
        radiance *= coverage_of_light((*path).shadow, hit);
        //@ end
        //@ if medium
        let through = transmittance((*path).shadow, hit.t, &steps);
        if through == WALK_CUT {
            status = PATH_CUT;
            radiance = vec3<f32>(0.0);
        }
        radiance *= through;
        //@ end
        brought = (*path).light_weight * radiance;
        note_light_of_shadow(path, hit, emitted, radiance);
    } else if hit.code == PATH_CUT {
        status = PATH_CUT;
    }
    // A probe alone does not change the image.
    if is_probe(path) && all((*path).light_weight == vec3<f32>(0.0)) {
        return steps;
    }
    //@ if aov_direct
    // `depth` counts the event that sent the ray, unless the path ended there.
    note_direct(path, brought, select((*path).depth + 1u, (*path).depth, status == RAY_READY));
    //@ end
    (*path).status = status;
    (*path).radiance += limited_light(brought);
    return steps;
}

//@ if alpha_of_light
// The coverage of the light where its shadow ray ends. The walk does not draw whether the ray passes its own end, so this is a factor.
fn coverage_of_light(ray: Ray, hit: Hit) -> f32 {
    // The sky and lights without size have no surface.
    if primitive_kind(hit.code) >= KIND_DELTA_LIGHT {
        return 1.0;
    }
    return coverage_at(hit, light_surface_at(hit, ray));
}

//@ end
// The radiance of a light along a shadow ray; 1 for a light without size.
fn emitted_along(ray: Ray, hit: Hit) -> vec3<f32> {
    var radiance = vec3<f32>(0.0);
    //@ if delta_light
    if is_delta_light(hit.code) {
        // The weight of the ray has its intensity.
        return vec3<f32>(1.0);
    }
    //@ end
    //@ if emitting_sky
    if hit.code == HIT_NOTHING {
        radiance = background_radiance(ray.direction);
    }
    //@ end
    //@ if emitting_without_scattering
    if hit.code != HIT_NOTHING {
        radiance = emitted_by_surface(ray, hit);
    }
    //@ end
    //@ if glow_of_light
    if hit.code != HIT_NOTHING {
        let surface = light_surface_at(hit, ray);
        radiance = glow_of_surface(hit, surface, arrives_at_front(hit.code, ray, surface.normal));
    }
    //@ end
    return radiance;
}

fn emitted_by_surface(ray: Ray, hit: Hit) -> vec3<f32> {
    let surface = light_surface_at(hit, ray);
    let material = materials[surface.material];
    if material.parameter == 0.0 && !arrives_at_front(hit.code, ray, surface.normal) {
        return vec3<f32>(0.0);
    }
    return surface_colour(material, hit, surface);
}
