//@ implements shadow when light
//@ use bind/settings
//@ use choice/sampler
//@ use choice/walker
//@ use choice/panes
//@ use choice/transmittance
//@ use choice/clamp
//@ use choice/probe
//@ use choice/aov_direct
//@ use choice/light_groups
//@ use choice/delta_lights
//@ use choice/light_crossings
//@ use choice/light_surfaces
//@ use choice/light_coverage
//@ use choice/sky_light
//@ use choice/density_ratio
//@ use scene/lights
// Light sampling: each event sends a shadow ray to a light, in addition to the ray that continues the path. Both rays can find
// the same light. They are combined by multiple importance sampling with the power heuristic (Veach, "Robust Monte Carlo
// Methods for Light Transport Simulation", 1997, section 9.2.4).

// A sampled light, and a sampled direction to it from the point of an event.
struct LightSample {
    light: u32,
    direction: vec3<f32>,
    // The joint pdf of light and direction; 0 if no light can be sampled.
    pdf: f32,
    // The uniform number that chooses one of the two sides of a body.
    u: f32,
}

fn sample_light(path: ptr<function, Path>, from_point: vec3<f32>) -> LightSample {
    let u = random4((*path).pixel, (*path).sample, bounce_dimension((*path).depth, DIMENSION_LIGHT), settings.seed);
    let choice = choose_light(from_point, u.xw);
    let light = lights[choice.index];
    let sample = direction_to_light(light, from_point, u.yzw);
    return LightSample(choice.index, sample.direction, choice.probability * sample.pdf, u.y);
}

// Stores a shadow ray to the light. `response` is BSDF times cosine, or the phase function. `pdf` is the pdf with which BSDF
// sampling draws the same direction. It never hits a light without size, whose MIS weight is 1.
fn send_shadow_ray(path: ptr<function, Path>, light_sample: LightSample, origin: vec3<f32>, response: vec3<f32>, pdf: f32) {
    let light = lights[light_sample.light];
    let crossing = light_crossing(light, Ray(origin, light_sample.direction), light_sample.u);
    let light_pdf = light_sample.pdf * crossing.share;
    let scattered = (*path).throughput * response;
    var weight = scattered * (power_heuristic(light_pdf, pdf) / light_pdf);
    if is_delta_light(light.code) {
        weight = scattered * intensity_of_delta_light(light.code, light_sample.direction) / light_pdf;
    }
    (*path).light_density = light_pdf + select(pdf, 0.0, is_delta_light(light.code));
    weigh_probe(path, light_pdf);
    if light_pdf > 0.0 && (any(weight > vec3<f32>(0.0)) || is_probe(path)) {
        (*path).shadow = Ray(origin, light_sample.direction);
        (*path).light = light.code;
        (*path).light_instance = crossing.instance;
        (*path).light_weight = weight_of_light(weight, (*path).depth);
    }
}

// The MIS weight of a light that BSDF sampling hit; 1 if light sampling cannot sample it. `local` is that of the surface.
fn mis_weight(path: ptr<function, Path>, hit: Hit, local: vec3<f32>) -> f32 {
    let pdf = (*path).pdf;
    if !(pdf > 0.0) {
        return 1.0;
    }
    return power_heuristic(pdf, light_density(hit, local, (*path).ray.origin, (*path).ray.direction));
}

// The hit of the shadow ray on its light. Hits beyond it do not matter.
fn limit_of_shadow(path: ptr<function, Path>) -> Hit {
    if is_delta_light((*path).light) {
        return limit_at_delta_light((*path).light, (*path).shadow);
    }
    if (*path).light != HIT_NOTHING {
        return limit_at_surface((*path).light, (*path).light_instance, (*path).shadow);
    }
    return hit_at(HIT_NOTHING, VERY_FAR);
}

// Traces the path's shadow ray, if it has one, and adds the light if nothing blocks it. Returns
// `iterations` plus its own.
fn trace_shadow(path: ptr<function, Path>, iterations: u32) -> u32 {
    if (*path).light == NO_LIGHT {
        return iterations;
    }
    let limit = limit_of_shadow(path);
    let hit = shadow_hit(path, limit);
    return iterations + add_light_of_shadow(path, limit, hit);
}

// The first hit of the shadow ray, up to the one on its light.
fn shadow_hit(path: ptr<function, Path>, limit: Hit) -> Hit {
    if !(limit.t > 0.0) {
        // The light is a surface behind the origin. A hit on nothing counts it as hidden.
        var none = hit_at(HIT_NOTHING, limit.t);
        none.steps = 1u;
        return none;
    }
    begin_walk(path, DIMENSION_LIGHT);
    return hit_of_shadow(path, limit);
}

// Adds the light of the shadow ray if its first hit is the one on its light. Returns the number of iterations.
fn add_light_of_shadow(path: ptr<function, Path>, limit: Hit, hit: Hit) -> u32 {
    let is_hidden = hit.code != (*path).light || hit.instance != limit.instance;
    (*path).light = NO_LIGHT;
    (*path).rays += 1u;
    var status = (*path).status;
    var steps = hit.steps;
    var contribution = vec3<f32>(0.0);
    if !is_hidden {
        let emitted = emitted_along((*path).shadow, hit);
        let covered = cover_light_at_hit(emitted, (*path).shadow, hit);
        let transmitted = transmit_light(covered, (*path).shadow, hit.t, &steps, &status);
        let radiance = pass_panes(path, transmitted);
        (*path).light_weight *= weigh_sample_beside_light_paths(path, hit);
        contribution = (*path).light_weight * radiance;
        record_light_of_shadow(path, hit, emitted, radiance);
        record_light(path, hit, limited_light(contribution));
    } else if hit.code == PATH_CUT {
        status = PATH_CUT;
    }
    // A ray that is only a probe does not change the image.
    if is_probe(path) && all((*path).light_weight == vec3<f32>(0.0)) {
        return steps;
    }
    // `depth` counts the event that sent the ray, unless the path ended there.
    record_direct(path, contribution, select((*path).depth + 1u, (*path).depth, status == RAY_READY));
    (*path).status = status;
    (*path).radiance += limited_light(contribution);
    return steps;
}

// The radiance of a light along a shadow ray; 1 for a light without size, whose intensity is in the ray's weight.
fn emitted_along(ray: Ray, hit: Hit) -> vec3<f32> {
    if is_delta_light(hit.code) {
        return vec3<f32>(1.0);
    }
    if hit.code == HIT_NOTHING {
        return emitted_by_sky(ray.direction);
    }
    return emitted_by_surface(ray, hit);
}

//@ without
// No light is sampled.
fn trace_shadow(path: ptr<function, Path>, iterations: u32) -> u32 {
    return iterations;
}
