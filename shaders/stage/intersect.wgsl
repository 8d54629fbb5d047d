//@ use slots/state
//@ use scene/traverse
//@ use choice/sort
// Finds what each slot's ray meets first.
override WORKGROUP_SIZE: u32 = 64u;

@compute @workgroup_size(WORKGROUP_SIZE)
fn intersect(@builtin(global_invocation_id) id: vec3<u32>) {
    let slot = id.x;
    if slot >= settings.slots {
        return;
    }
    let direction = paths[place(PLANE_DIRECTION, slot)];
    if direction.w == SLOT_IDLE {
        return;
    }
    let origin = paths[place(PLANE_ORIGIN, slot)];
    let hit = nearest_hit(Ray(vector_of(origin), vector_of(direction)), settings.root);
    paths[place(PLANE_ORIGIN, slot)].w = bitcast<u32>(hit.t);
    paths[place(PLANE_DIRECTION, slot)].w = hit.code;
    sort_slot(slot, hit.code);
}
