//@ use data/ray
//@ use data/surface
//@ use data/hit
//@ use data/primitive
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
//@ if area_light.triangle
//@ use light/triangle
//@ use choice/face_parts
//@ use choice/moved_instance
//@ use scene/meshes
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
            return ${name}_light_sample(from_point, moved_${name}(${name}s[index], pose), u.xy);
        }
        //@ end
        //@ each parted_emitter
        case ${number}u: {
            return ${name}_part_sample(from_point, moved_${name}(${name}s[index], pose), light.part, u.xy);
        }
        //@ end
        //@ if area_light.triangle
        case KIND_TRIANGLE: {
            let face = corners_in_render_space(moved_instance(instances[light.instance], pose), index);
            let corners = part_of_triangle(face, light.part);
            return triangle_light_sample(from_point, corners.a, corners.b, corners.c, u.xy);
        }
        //@ end
        default: {
            return DirectionSample(vec3<f32>(0.0), 0.0);
        }
    }
}

// The distance to a light in front of the ray's origin, or NO_HIT. Unlike primitive_distance (scene/primitives), it has no code for
// primitives that are no lights, because GPUs inline each call.
fn light_hit_distance(code: u32, pose: Pose, ray: Ray, inverse: vec3<f32>) -> f32 {
    let index = primitive_index(code);
    switch primitive_kind(code) {
        //@ each emitter
        case ${number}u: {
            return ${name}_distance(ray, moved_${name}(${name}s[index], pose));
        }
        //@ end
        //@ if area_light.triangle
        case KIND_TRIANGLE: {
            return face_hit(ray, inverse, index).t;
        }
        //@ end
        default: {
            return NO_HIT;
        }
    }
}

// The hit record of a ray that hits a light. Unlike surface_at (scene/surfaces), it has no code for other primitives.
fn light_surface_at(hit: Hit, ray: Ray) -> Surface {
    let index = primitive_index(hit.code);
    let pose = pose_at(hit.code, hit.instance);
    let to_hit = ray_to_hit(hit, pose, ray);
    switch primitive_kind(hit.code) {
        //@ each emitter
        case ${number}u: {
            return ${name}_at_rest(in_pose(${name}_surface(to_hit.ray, to_hit.t, moved_${name}(${name}s[index], pose)), pose), ${name}s[index]);
        }
        //@ end
        //@ if area_light.triangle
        case KIND_TRIANGLE: {
            return in_pose(mesh_surface(ray, moved_instance(instances[at_run_time(hit.instance)], pose), index), pose);
        }
        //@ end
        default: {
            return Surface();
        }
    }
}

// Approximate distance to a primitive along a ray that misses it. For a face, the ray is in its mesh's space.
fn distance_to_light(code: u32, pose: Pose, ray: Ray) -> f32 {
    let index = primitive_index(code);
    switch primitive_kind(code) {
        //@ each emitter
        case ${number}u: {
            return ${name}_light_distance(ray, moved_${name}(${name}s[index], pose));
        }
        //@ end
        //@ if area_light.triangle
        case KIND_TRIANGLE: {
            let corners = corners_of(index);
            let normal = triangle_cross(corners.a, corners.b, corners.c);
            return dot(corners.a - ray.origin, normal) / dot(ray.direction, normal);
        }
        //@ end
        default: {
            return NO_HIT;
        }
    }
}

// Whether a shadow ray arrives at the front of a light, whose surface at the hit is given.
fn arrives_at_front(code: u32, ray: Ray, surface: Surface) -> bool {
    let index = primitive_index(code);
    switch primitive_kind(code) {
        //@ each emitter
        case ${number}u: {
            return ${name}_light_front(ray, surface.normal, moved_${name}(${name}s[index], surface.pose));
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
            return ${name}s[index].light;
        }
        //@ end
        //@ if area_light.triangle
        case KIND_TRIANGLE: {
            return instances[at_run_time(hit.instance)].to_light + index;
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
            pdf = ${name}_light_pdf(from_point, direction, moved_${name}(${name}s[of_kind], pose));
        }
        //@ end
        //@ each parted_emitter
        case ${number}u: {
            pdf = ${name}_part_pdf(from_point, direction, moved_${name}(${name}s[of_kind], pose), part);
        }
        //@ end
        //@ if area_light.triangle
        case KIND_TRIANGLE: {
            let face = corners_in_render_space(moved_instance(instances[at_run_time(instance)], pose), of_kind);
            let corners = part_of_triangle(face, part);
            pdf = triangle_light_pdf(from_point, direction, corners.a, corners.b, corners.c);
        }
        //@ end
        default: {
            return 0.0;
        }
    }
    return probability_of_light(index, from_point) * pdf * share_of_crossing(index, Ray(from_point, direction));
}
