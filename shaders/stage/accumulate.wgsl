//@ use bind/records
//@ use bind/window
//@ use step/count
//@ use step/film
//@ use choice/aov_film
//@ use choice/film_lights
//@ use step/pixel_order
// Adds the finished runs to the film. It is a kernel of its own, where every invocation has a run to add. In the kernel that ends runs,
// few invocations would.
override WORKGROUP_SIZE: u32 = 64u;

@compute @workgroup_size(WORKGROUP_SIZE)
fn accumulate(@builtin(global_invocation_id) id: vec3<u32>) {
    let finished = atomicLoad(&counters.records);
    let invocations = window.end_slot - window.first_slot;
    if id.x >= min(invocations, finished) {
        return;
    }
    var paths = 0u;
    var rays = 0u;
    for (var i = id.x; i < finished; i += invocations) {
        let run = records[i];
        let pixel = rank_of_pixel(run.pixel) - window.first_pixel;
        paths += add_run(pixel, run);
        add_aov(pixel, run);
        add_lights_of_run(pixel, run);
        rays += run.rays;
    }
    count(PATHS, paths);
    count(RAYS, rays);
}
