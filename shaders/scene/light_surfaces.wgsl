//@ implements light_surfaces when area_light
//@ use data/hit
//@ use data/material
//@ use data/primitive
//@ use data/ray
//@ use data/surface
//@ use choice/crossings
//@ use choice/light_crossings
//@ use choice/surface_radiance
//@ use scene/lights
//@ if area_light.triangle
//@ use bind/instances
//@ use choice/moved_instance
//@ use geometry/instance
//@ use geometry/slab
//@ use scene/at_run_time
//@ end
// Surfaces at which shadow rays end.

// A ray in the space of a light's shape. Only the faces of meshes need the inverse.
struct LightRay {
    ray: Ray,
    inverse: vec3<f32>,
    instance: u32,
    pose: Pose,
}

//@ if area_light.triangle
fn ray_to_shape(code: u32, instance: u32, pose: Pose, shadow: Ray) -> LightRay {
    if primitive_kind(code) != KIND_TRIANGLE {
        return LightRay(shadow, vec3<f32>(0.0), NO_INSTANCE, pose);
    }
    let ray = to_mesh(moved_instance(instances[at_run_time(instance)], pose), shadow);
    return LightRay(ray, slab_inverse(ray.direction), instance, pose);
}

//@ else
fn ray_to_shape(code: u32, instance: u32, pose: Pose, shadow: Ray) -> LightRay {
    return LightRay(shadow, vec3<f32>(0.0), NO_INSTANCE, pose);
}

//@ end
// The hit of a shadow ray on the light of this code.
fn limit_at_surface(code: u32, instance: u32, shadow: Ray) -> Hit {
    let light_ray = ray_to_shape(code, instance, pose_at(code, instance), shadow);
    let t = light_hit_distance(code, light_ray.pose, light_ray.ray, light_ray.inverse);
    // Rounding can make a sampled direction miss a light that is tiny as seen from here, or miss the edge of any light. The
    // sample counts nevertheless, because the pdf says that it was drawn. Only a hit before the light blocks it.
    var limit = hit_at(code, select(distance_to_light(code, light_ray.pose, light_ray.ray), t, t != NO_HIT));
    limit.instance = light_ray.instance;
    return limit_at_crossing(limit, instance, light_ray.pose, shadow);
}

fn emitted_by_surface(ray: Ray, hit: Hit) -> vec3<f32> {
    let surface = light_surface_at(hit, ray);
    return surface_radiance(hit, surface, ray_to_hit(hit, surface.pose, ray).ray);
}

//@ without
//@ use data/hit
//@ use data/ray
// No surface is sampled as a light.
fn limit_at_surface(code: u32, instance: u32, shadow: Ray) -> Hit {
    return hit_at(code, 0.0);
}

fn emitted_by_surface(ray: Ray, hit: Hit) -> vec3<f32> {
    return vec3<f32>(0.0);
}
