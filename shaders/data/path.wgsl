//@ use data/ray
//@ use data/hit
//@ use lib/compensated
// A path on its way, and the run that it is a sample of.
struct Path {
    ray: Ray,
    // Distance to the hit that `status` names.
    t: f32,
    // Code of the primitive that the ray hit, or what the path is doing (data/primitive).
    status: u32,
    // The share of the light met next that reaches the camera; of an ended path its radiance.
    throughput: vec3<f32>,
    //@ if mesh
    // With a triangle's code: the instance that it is part of.
    instance: u32,
    //@ end
    // Scattering events so far.
    depth: u32,
    pixel: u32,
    sample: u32,
    // Of the run: accepted samples | rejected as NaN << 8 | rejected as infinite << 16 | cut short << 24 | ODD_RUN.
    counts: u32,
    //@ if light
    // Radiance of the sample so far, by sampled lights.
    radiance: vec3<f32>,
    // Density of the last scattering's direction; 0 where no other direction was possible, and for the camera's rays.
    pdf: f32,
    // A ray on its way to a light, the light or NO_LIGHT, and what it brings per radiance if nothing is in its way.
    shadow: Ray,
    light: u32,
    light_weight: vec3<f32>,
    //@ end
    //@ if emitting_mesh
    // With a triangle's code for the light: the instance that it is part of.
    light_instance: u32,
    //@ end
    // Radiance of the run's samples so far, and their rays.
    sum: Compensated,
    rays: u32,
    // Sum of the squared deviations of those samples from their mean, by channel.
    spread: vec3<f32>,
}

// What the path's ray met.
fn path_hit(path: ptr<function, Path>) -> Hit {
    var hit = hit_at((*path).status, (*path).t);
    //@ if mesh
    hit.instance = (*path).instance;
    //@ end
    return hit;
}
