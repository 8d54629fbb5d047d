//@ use slots/state
//@ use bind/materials
//@ use data/dimension
//@ use data/primitive
//@ use geometry/offset
//@ use lib/rng
//@ use scene/materials
//@ use scene/surfaces
//@ use choice/colour
//@ use choice/turn
// Lets the material of the surface that a slot's ray met decide how the path goes on.
override WORKGROUP_SIZE: u32 = 64u;

@compute @workgroup_size(WORKGROUP_SIZE)
fn scatter(@builtin(global_invocation_id) id: vec3<u32>) {
    let slot = slot_of_turn(id.x);
    if slot >= settings.slots {
        return;
    }
    let direction = paths[place(PLANE_DIRECTION, slot)];
    if direction.w >= FIRST_STATUS {
        return;
    }
    let origin = paths[place(PLANE_ORIGIN, slot)];
    let state = paths[place(PLANE_THROUGHPUT, slot)];
    let sample = paths[place(PLANE_SAMPLE, slot)];
    let ray = Ray(vector_of(origin), vector_of(direction));
    let surface = surface_at(direction.w, ray, bitcast<f32>(origin.w));
    let material = materials[surface.material];
    let front = dot(ray.direction, surface.normal) < 0.0;
    let facing = select(-surface.normal, surface.normal, front);
    let colour = surface_colour(material, direction.w, surface);
    let hit = Interaction(ray.direction, facing, front, colour);

    let events = state.w;
    let u = random4(sample.x, sample.y, event_dimension(events, DIMENSION_SCATTER), settings.seed);
    let scattered = scatter_by_material(material, hit, u);
    let throughput = vector_of(state) * scattered.weight;
    let goes_on = scattered.event == SCATTERED && events < settings.max_depth && any(throughput != vec3<f32>(0.0));
    if goes_on {
        let leaving = leave_surface(surface.point, surface.error, surface.normal, scattered.direction);
        write_ray(slot, Ray(leaving, scattered.direction));
        paths[place(PLANE_THROUGHPUT, slot)] = word_of(throughput, events + 1u);
    } else {
        let radiance = select(vec3<f32>(0.0), throughput, scattered.event == EMITTED);
        paths[place(PLANE_THROUGHPUT, slot)] = word_of(radiance, events);
        paths[place(PLANE_DIRECTION, slot)].w = PATH_ENDED;
    }
}
