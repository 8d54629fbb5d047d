//@ use bind/settings
//@ use choice/camera_view
//@ use choice/panes
//@ use choice/sampler
//@ use choice/transmittance
//@ use light_path/counted_splat
//@ use light_path/density_ratio
//@ use step/light
//@ use light_path/light_sample
//@ use light_path/splat
// Connections of light paths: each event but the first sends a ray to a point of the lens, and what arrives is added to the film there. The
// shadow ray of a path is that ray.

fn view_of_event(path: ptr<function, Path>, point: vec3<f32>) -> CameraView {
    let u = random4((*path).pixel, (*path).sample, bounce_dimension((*path).depth, DIMENSION_LIGHT), settings.seed);
    return view_from_camera(point, u);
}

// Sends the ray to the lens. `response` is BSDF times cosine in the order of camera paths, times cos_camera / cos_light with the surface's
// own normal, or the phase function. `pdf` is the density with which a camera path scatters to the light, over cos_light.
fn send_to_lens(path: ptr<function, Path>, view: CameraView, origin: vec3<f32>, response: vec3<f32>, cos_camera: f32, pdf: f32) {
    let contribution = (*path).radiance * (*path).throughput * response * view.density;
    if !(view.density > 0.0) || !any(contribution > vec3<f32>(0.0)) {
        return;
    }
    let log_ratio = (*path).log_ratio + log_ratio_at_camera(-view.direction, view.distance, cos_camera) - log_of_density(pdf);
    let pixels = f32(settings.image_width) * f32(settings.image_height);
    (*path).shadow = Ray(origin, view.direction);
    (*path).light = HIT_NOTHING;
    (*path).light_weight = contribution / ((1.0 + exp2(-log_ratio)) * pixels);
    (*path).film_point = view.film_point;
    (*path).film_choice = view.u;
    (*path).lens_distance = view.distance;
}

// Traces the path's ray to the lens, if it has one, and adds the light to the film if nothing blocks it. Before that, a path from infinity
// has a ray back there. Returns `iterations` plus its own.
fn trace_to_lens(path: ptr<function, Path>, iterations: u32) -> u32 {
    if (*path).light == NO_LIGHT {
        return iterations;
    }
    let limit = hit_at(HIT_NOTHING, (*path).lens_distance);
    let hit = shadow_hit(path, limit);
    var steps = hit.steps;
    var status = (*path).status;
    var arriving = vec3<f32>(0.0);
    if hit.code == HIT_NOTHING {
        arriving = pass_panes(path, transmit_light(vec3<f32>(1.0), (*path).shadow, hit.t, &steps, &status));
    } else if hit.code == PATH_CUT {
        status = PATH_CUT;
    }
    (*path).light = NO_LIGHT;
    (*path).rays += 1u;
    (*path).status = status;
    if limit.t == VERY_FAR {
        (*path).throughput *= arriving;
    } else if any(arriving > vec3<f32>(0.0)) {
        let half = half_of_light_path(path);
        record_splat(path, splat(path, (*path).film_point, (*path).light_weight * arriving, half, (*path).film_choice));
    }
    return iterations + steps;
}
