//@ use bind/lights
//@ use light/sample
//@ use scene/at_run_time
//@ use choice/pose
//@ use choice/crossings
//@ use choice/light_choice
//@ use choice/light_crossings
//@ use choice/light_parts
//@ each emitter
//@ use light/${name}
//@ use geometry/${name}
//@ use bind/${name}s
//@ use choice/moved_${name}
//@ end
//@ each parted_emitter
//@ use light/${name}_parts
//@ end
//@ use choice/delta_lights
//@ use choice/sky_light
// The scene's lights; only the kinds that the scene has.

// Samples a direction from a point to a light, with its pdf in solid angle.
fn direction_to_light(light: Light, from_point: vec3<f32>, u: vec3<f32>) -> DirectionSample {
    let index = primitive_index(light.code);
    if light.code == HIT_NOTHING {
        return sky_light_sample(u);
    }
    if is_delta_light(light.code) {
        return direction_to_delta_light(light.code, from_point);
    }
    let pose = pose_at(light.code, light.instance);
    switch primitive_kind(light.code) {
        //@ each whole_emitter
        case ${number}u: {
            return ${name}_light_sample(from_point, moved_${name}(${name}_at(index, light.instance), pose), u.xy);
        }
        //@ end
        //@ each parted_emitter
        case ${number}u: {
            return ${name}_part_sample(from_point, moved_${name}(${name}_at(index, light.instance), pose), light.part, u.xy);
        }
        //@ end
        default: {
            return DirectionSample(vec3<f32>(0.0), 0.0);
        }
    }
}

// The distance to a light along a shadow ray, approximate where the ray misses it. Unlike primitive_distance (scene/primitives), it has no code
// for primitives that are no lights, because GPUs inline each call.
fn distance_to_light(code: u32, instance: u32, pose: Pose, ray: Ray) -> f32 {
    let index = primitive_index(code);
    var t = NO_HIT;
    switch primitive_kind(code) {
        //@ each emitter
        case ${number}u: {
            let shape = moved_${name}(${name}_at(index, instance), pose);
            t = ${name}_distance(ray, shape);
            if t == NO_HIT {
                t = ${name}_light_distance(ray, shape);
            }
        }
        //@ end
        default: {}
    }
    return t;
}

// The hit record of a ray that hits a light. Unlike surface_at (scene/surfaces), it has no code for other primitives.
fn light_surface_at(hit: Hit, ray: Ray) -> Surface {
    let index = primitive_index(hit.code);
    let pose = pose_at(hit.code, hit.instance);
    let to_hit = ray_to_hit(hit, pose, ray);
    switch primitive_kind(hit.code) {
        //@ each emitter
        case ${number}u: {
            let shape = ${name}_at(index, hit.instance);
            return ${name}_at_rest(in_pose(${name}_surface(to_hit.ray, to_hit.t, moved_${name}(shape, pose)), pose), shape);
        }
        //@ end
        default: {
            return Surface();
        }
    }
}

// Whether a ray arrives at the front of a light, whose surface at the hit is given.
fn arrives_at_front(hit: Hit, ray: Ray, surface: Surface) -> bool {
    let index = primitive_index(hit.code);
    switch primitive_kind(hit.code) {
        //@ each emitter
        case ${number}u: {
            return ${name}_light_front(ray, surface.normal, moved_${name}(${name}_at(index, hit.instance), surface.pose));
        }
        //@ end
        default: {
            return dot(ray.direction, surface.normal) < 0.0;
        }
    }
}

// The probability of choosing a light; 0 for an emitter that is not sampled.
fn probability_of_light(index: u32, from_point: vec3<f32>) -> f32 {
    if index >= NOT_SAMPLED {
        return 0.0;
    }
    return light_probability(index, from_point);
}

// The number of the light that a ray hit; the parts of a shape have one together. The sky has a number of its own, and lights without size
// are numbered separately.
fn number_of_light(hit: Hit) -> u32 {
    let index = primitive_index(hit.code);
    if is_delta_light(hit.code) {
        return index;
    }
    switch primitive_kind(hit.code) {
        //@ each emitter
        case ${number}u: {
            return ${name}_at(index, hit.instance).light;
        }
        //@ end
        default: {
            return at_run_time(NUMBER_OF_SKY);
        }
    }
}

// The index of the light that a ray hit in the table of lights: that of a part where its shape is cut. `local` is that of the surface.
fn light_at(hit: Hit, local: vec3<f32>) -> u32 {
    return part_at_hit(number_of_light(hit), hit, local);
}

// The pdf of light sampling for a direction that hits a light: the probability of choosing the light, times the pdf of the direction. `local` is
// that of the surface.
fn light_density(hit: Hit, local: vec3<f32>, from_point: vec3<f32>, direction: vec3<f32>) -> f32 {
    return density_of_light(light_at(hit, local), hit.code, hit.instance, from_point, direction);
}

// The same, for the light of this index, code and instance.
fn density_of_light(index: u32, code: u32, instance: u32, from_point: vec3<f32>, direction: vec3<f32>) -> f32 {
    let of_kind = primitive_index(code);
    let pose = pose_at(code, instance);
    let part = part_of_light(index);
    var pdf = 0.0;
    switch primitive_kind(code) {
        //@ each whole_emitter
        case ${number}u: {
            pdf = ${name}_light_pdf(from_point, direction, moved_${name}(${name}_at(of_kind, instance), pose));
        }
        //@ end
        //@ each parted_emitter
        case ${number}u: {
            pdf = ${name}_part_pdf(from_point, direction, moved_${name}(${name}_at(of_kind, instance), pose), part);
        }
        //@ end
        default: {}
    }
    return probability_of_light(index, from_point) * pdf * share_of_crossing(index, Ray(from_point, direction));
}
