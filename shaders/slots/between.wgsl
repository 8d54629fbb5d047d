//@ use slots/state
// The data that the stages of a bounce pass to each other: the hit and the shadow ray.

fn load_hit(slot: u32, path: ptr<function, Path>) {
    load_ray(slot, path);
    (*path).t = bitcast<f32>(load_t(slot));
    //@ if mesh
    (*path).instance = load_instance(slot);
    //@ end
}

fn store_hit(slot: u32, path: ptr<function, Path>) {
    store_status(slot, (*path).status);
    //@ if event
    store_t(slot, bitcast<u32>((*path).t));
    //@ end
    //@ if mesh
    store_instance(slot, (*path).instance);
    //@ end
}

fn load_light(slot: u32) -> u32 {
    return paths[place(PLANE_OF_SHADOW_ORIGIN, slot)].w;
}

// Marks that the slot has no shadow ray.
fn store_no_light(slot: u32) {
    paths[place(PLANE_OF_SHADOW_ORIGIN, slot)].w = NO_LIGHT;
}

fn load_light_weight(slot: u32, path: ptr<function, Path>) {
    let words = paths[place(PLANE_OF_LIGHT_WEIGHT, slot)];
    (*path).light_weight = vector_of(words);
    //@ if probed
    (*path).probe = bitcast<f32>(words.w);
    //@ end
}

fn load_shadow(slot: u32, path: ptr<function, Path>) {
    let origin = paths[place(PLANE_OF_SHADOW_ORIGIN, slot)];
    (*path).shadow = Ray(vector_of(origin), vector_of(paths[place(PLANE_OF_SHADOW_DIRECTION, slot)]));
    (*path).light = origin.w;
    //@ if emitting_mesh
    (*path).light_instance = load_light_instance(slot);
    //@ end
}

fn store_shadow(slot: u32, path: ptr<function, Path>) {
    store_plane(PLANE_OF_SHADOW_ORIGIN, slot, (*path).shadow.origin, (*path).light);
    store_vector(PLANE_OF_SHADOW_DIRECTION, slot, (*path).shadow.direction);
    //@ if probed
    store_plane(PLANE_OF_LIGHT_WEIGHT, slot, (*path).light_weight, bitcast<u32>((*path).probe));
    //@ end
    //@ if unprobed
    store_vector(PLANE_OF_LIGHT_WEIGHT, slot, (*path).light_weight);
    //@ end
    //@ if emitting_mesh
    store_light_instance(slot, (*path).light_instance);
    //@ end
}
