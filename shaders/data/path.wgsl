//@ use data/ray
//@ use data/hit
//@ use lib/compensated
// Light that reaches the camera by fewer scattering events is direct.
const INDIRECT_FROM: u32 = 2u;

// The state of a path, and of the run that its sample belongs to.
struct Path {
    ray: Ray,
    // Distance to the hit that `status` names.
    t: f32,
    // Code of the primitive that the ray hit, or what the path is doing (data/primitive).
    status: u32,
    // The factor that multiplies the radiance found by the ray. Once the path has ended, it holds the path's radiance.
    throughput: vec3<f32>,
    //@ if mesh
    // For a hit on a triangle: the instance of its mesh.
    instance: u32,
    //@ end
    // Number of scattering events so far.
    depth: u32,
    pixel: u32,
    sample: u32,
    // As in RunRecord.
    counts: u32,
    //@ if gathers
    // Radiance of this sample so far from light sampling, and from surfaces that emit and scatter.
    radiance: vec3<f32>,
    // The pdf with which the last event sampled the ray's direction. 0 for camera rays and in specular lobes.
    pdf: f32,
    //@ end
    //@ if light
    // The shadow ray; the code of its light, or NO_LIGHT; and its contribution per unit of radiance if nothing blocks it.
    shadow: Ray,
    light: u32,
    light_weight: vec3<f32>,
    //@ end
    //@ if probed
    // What the lobes of the path's events were, in bits, and the weight of the shadow ray as a probe (step/narrow_lobe).
    history: u32,
    probe: f32,
    //@ end
    //@ if emitting_mesh
    // For a light that is a triangle: the instance of its mesh.
    light_instance: u32,
    //@ end
    //@ if aov_rough
    // 1 if the albedo and the normal of this sample are known (step/aov_surface).
    seen: u32,
    //@ end
    //@ if aov_direct
    // Direct radiance of this sample so far (step/aov_direct), and its sum over the run's accepted samples.
    direct: vec3<f32>,
    direct_sum: vec3<f32>,
    //@ end
    // Sums over the samples of the run, and what its first sample has met (`--aov`).
    //@ if aov_albedo
    albedo_sum: vec3<f32>,
    //@ end
    //@ if aov_normal
    normal_sum: vec3<f32>,
    //@ end
    //@ if aov_hits
    hits: f32,
    //@ end
    //@ if aov_depth
    depth_sum: f32,
    //@ end
    //@ if aov_position
    position_sum: vec3<f32>,
    //@ end
    //@ if aov_object
    object: f32,
    //@ end
    //@ if aov_material
    material: f32,
    //@ end
    // Sum of the radiance of the run's finished samples, and the number of rays traced for them.
    sum: Compensated,
    rays: u32,
    // Sum of the squared deviations of those samples from their mean, per channel.
    spread: vec3<f32>,
}

// The hit of the path's ray.
fn path_hit(path: ptr<function, Path>) -> Hit {
    var hit = hit_at((*path).status, (*path).t);
    //@ if mesh
    hit.instance = (*path).instance;
    //@ end
    return hit;
}
