//@ use slots/state
// What the stages of a bounce hand to each other: the hit, and the ray to a light.

fn load_hit(slot: u32, path: ptr<function, Path>) {
    load_ray(slot, path);
    (*path).t = bitcast<f32>(load_word(WORD_OF_T, slot));
    //@ each mesh
    (*path).instance = load_word(WORD_OF_INSTANCE, slot);
    //@ end
}

fn store_hit(slot: u32, path: ptr<function, Path>) {
    store_word(WORD_OF_STATUS, slot, (*path).status);
    store_word(WORD_OF_T, slot, bitcast<u32>((*path).t));
    //@ each mesh
    store_word(WORD_OF_INSTANCE, slot, (*path).instance);
    //@ end
}

fn load_light(slot: u32) -> u32 {
    return load_word(WORD_OF_LIGHT, slot);
}

// No ray to a light is on its way.
fn store_no_light(slot: u32) {
    store_word(WORD_OF_LIGHT, slot, NO_LIGHT);
}

fn load_shadow(slot: u32, path: ptr<function, Path>) {
    (*path).shadow = Ray(load_vector(WORD_OF_SHADOW_ORIGIN, slot), load_vector(WORD_OF_SHADOW_DIRECTION, slot));
    (*path).light = load_light(slot);
    (*path).light_weight = load_vector(WORD_OF_LIGHT_WEIGHT, slot);
    //@ each emitting_mesh
    (*path).light_instance = load_word(WORD_OF_LIGHT_INSTANCE, slot);
    //@ end
}

fn store_shadow(slot: u32, path: ptr<function, Path>) {
    store_vector(WORD_OF_SHADOW_ORIGIN, slot, (*path).shadow.origin);
    store_vector(WORD_OF_SHADOW_DIRECTION, slot, (*path).shadow.direction);
    store_word(WORD_OF_LIGHT, slot, (*path).light);
    store_vector(WORD_OF_LIGHT_WEIGHT, slot, (*path).light_weight);
    //@ each emitting_mesh
    store_word(WORD_OF_LIGHT_INSTANCE, slot, (*path).light_instance);
    //@ end
}
