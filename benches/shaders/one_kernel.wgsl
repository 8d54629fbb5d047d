//@ use bind/settings
//@ use bind/window
//@ use bind/records
//@ use bind/materials
//@ use scene/background
//@ use choice/camera
//@ use choice/colour
//@ use data/dimension
//@ use data/window
//@ use choice/shading
//@ use lib/compensated
//@ use lib/spread
//@ use lib/float
//@ use choice/sampler
//@ use scene/materials
//@ use scene/surfaces
//@ use scene/traverse
// The plain tracer: an invocation a pixel, a loop over the samples of a run, a loop over the bounces of a path. Shares every
// function with the wavefront and none of its stages.
override WORKGROUP_SIZE: u32 = 64u;

fn radiance_of(pixel: u32, sample: u32, rays: ptr<function, u32>) -> vec3<f32> {
    let lens = random4(pixel, sample, DIMENSION_CAMERA, settings.seed);
    var ray = camera_ray(pixel % settings.image_width, pixel / settings.image_width, lens);
    var throughput = vec3<f32>(1.0);
    for (var events = 0u; ; events++) {
        *rays += 1u;
        let hit = nearest_hit(ray, settings.root);
        if hit.code == HIT_NOTHING {
            return throughput * background_radiance(ray.direction);
        }
        let surface = surface_at(hit, ray);
        let material = materials[surface.material];
        let front = dot(ray.direction, surface.normal) < 0.0;
        let facing = select(-surface.normal, surface.normal, front);
        let shading = shading_normal(hit, surface, ray.direction, facing);
        let colour = surface_colour(material, hit, surface);
        let u = random4(pixel, sample, event_dimension(events, DIMENSION_SCATTER), settings.seed);
        let scattered = scatter_by_material(material, Interaction(ray.direction, shading, front, colour), u);
        throughput *= scattered.weight;
        if scattered.event == EMITTED {
            return throughput;
        }
        if scattered.event == ABSORBED || events >= settings.max_depth || all(throughput == vec3<f32>(0.0)) {
            break;
        }
        let leaving = leaving_point(hit, surface, facing, shading, event_point(hit, surface, facing), scattered.direction);
        ray = Ray(leaving, scattered.direction);
    }
    return vec3<f32>(0.0);
}

@compute @workgroup_size(WORKGROUP_SIZE)
fn one_kernel(@builtin(global_invocation_id) id: vec3<u32>) {
    let pixels = settings.image_width * settings.image_height;
    if id.x >= pixels {
        return;
    }
    var run = Compensated();
    var spread = vec3<f32>(0.0);
    var counts = 0u;
    var rays = 0u;
    let first = window.first_block * RUN_LENGTH;
    for (var sample = first; sample < first + RUN_LENGTH; sample++) {
        let radiance = radiance_of(id.x, sample, &rays);
        if is_nan(radiance.x + radiance.y + radiance.z) || is_infinite(radiance.x + radiance.y + radiance.z) {
            counts += 0x100u;
        } else {
            spread += spread_by(counts & 0xffu, run.sum, radiance);
            counts += 1u;
            run = compensated_sum(run, radiance, settings.zero);
        }
    }
    let sum = run.sum - run.excess;
    records[id.x] = RunRecord(sum.x, sum.y, sum.z, id.x, counts, rays, spread.x, spread.y, spread.z);
}
