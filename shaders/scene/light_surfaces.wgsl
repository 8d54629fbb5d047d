//@ implements light_surfaces when area_light
//@ use choice/crossings
//@ use choice/faces
//@ use choice/light_crossings
//@ use choice/surface_radiance
//@ use scene/lights
// Surfaces at which shadow rays end.

// The hit of a shadow ray on the light of this code.
fn limit_at_surface(code: u32, instance: u32, shadow: Ray) -> Hit {
    let pose = pose_at(code, instance);
    // Rounding can make a sampled direction miss a light that is tiny as seen from here, or miss the edge of any light. The
    // sample counts nevertheless, because the pdf says that it was drawn. Only a hit before the light blocks it.
    var limit = hit_at(code, distance_to_light(code, instance, pose, shadow));
    limit.instance = instance_of_primitive(code, instance);
    return limit_at_crossing(limit, instance, pose, shadow);
}

fn emitted_by_surface(ray: Ray, hit: Hit) -> vec3<f32> {
    let surface = light_surface_at(hit, ray);
    return surface_radiance(hit, surface, ray_to_hit(hit, surface.pose, ray).ray);
}

//@ without
// No surface is sampled as a light.
fn limit_at_surface(code: u32, instance: u32, shadow: Ray) -> Hit {
    return hit_at(code, 0.0);
}

fn emitted_by_surface(ray: Ray, hit: Hit) -> vec3<f32> {
    return vec3<f32>(0.0);
}
