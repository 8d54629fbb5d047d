//@ use bind/paths
//@ use bind/settings
//@ use data/path
//@ each light
//@ use data/light
//@ end
// The state of the slots' paths in memory, of just the fields that this scene's kernels hand to each other (src/plan.rs lists them):
// a field's words one behind the other, each word of all slots together, so that neighbouring slots read neighbouring words.

//@ each path_field
const ${name}: u32 = ${number}u;
//@ end

fn load_word(word: u32, slot: u32) -> u32 {
    return paths[word * settings.slots + slot];
}

fn store_word(word: u32, slot: u32, value: u32) {
    paths[word * settings.slots + slot] = value;
}

fn load_vector(word: u32, slot: u32) -> vec3<f32> {
    return bitcast<vec3<f32>>(
        vec3<u32>(load_word(word, slot), load_word(word + 1u, slot), load_word(word + 2u, slot)));
}

fn store_vector(word: u32, slot: u32, vector: vec3<f32>) {
    let words = bitcast<vec3<u32>>(vector);
    store_word(word, slot, words.x);
    store_word(word + 1u, slot, words.y);
    store_word(word + 2u, slot, words.z);
}

fn load_status(slot: u32) -> u32 {
    return load_word(WORD_OF_STATUS, slot);
}

fn store_status(slot: u32, status: u32) {
    store_word(WORD_OF_STATUS, slot, status);
}

fn load_ray(slot: u32, path: ptr<function, Path>) {
    (*path).ray = Ray(load_vector(WORD_OF_ORIGIN, slot), load_vector(WORD_OF_DIRECTION, slot));
    (*path).status = load_status(slot);
}

fn store_ray(slot: u32, path: ptr<function, Path>) {
    store_vector(WORD_OF_ORIGIN, slot, (*path).ray.origin);
    store_vector(WORD_OF_DIRECTION, slot, (*path).ray.direction);
    store_word(WORD_OF_STATUS, slot, (*path).status);
}

fn load_throughput(slot: u32, path: ptr<function, Path>) {
    (*path).throughput = load_vector(WORD_OF_THROUGHPUT, slot);
    (*path).events = load_word(WORD_OF_EVENTS, slot);
}

fn store_throughput(slot: u32, path: ptr<function, Path>) {
    store_vector(WORD_OF_THROUGHPUT, slot, (*path).throughput);
    store_word(WORD_OF_EVENTS, slot, (*path).events);
}

fn load_sample(slot: u32, path: ptr<function, Path>) {
    (*path).pixel = load_word(WORD_OF_PIXEL, slot);
    (*path).sample = load_word(WORD_OF_SAMPLE, slot);
}

fn store_sample(slot: u32, path: ptr<function, Path>) {
    store_word(WORD_OF_PIXEL, slot, (*path).pixel);
    store_word(WORD_OF_SAMPLE, slot, (*path).sample);
}

fn load_run(slot: u32, path: ptr<function, Path>) {
    (*path).counts = load_word(WORD_OF_COUNTS, slot);
    (*path).sum = load_vector(WORD_OF_SUM, slot);
    load_rays(slot, path);
}

fn store_run(slot: u32, path: ptr<function, Path>) {
    store_word(WORD_OF_COUNTS, slot, (*path).counts);
    store_vector(WORD_OF_SUM, slot, (*path).sum);
    store_rays(slot, path);
}

fn load_rays(slot: u32, path: ptr<function, Path>) {
    (*path).rays = load_word(WORD_OF_RAYS, slot);
}

fn store_rays(slot: u32, path: ptr<function, Path>) {
    store_word(WORD_OF_RAYS, slot, (*path).rays);
}

fn load_radiance(slot: u32, path: ptr<function, Path>) {
    (*path).radiance = load_vector(WORD_OF_RADIANCE, slot);
}

fn store_radiance(slot: u32, path: ptr<function, Path>) {
    store_vector(WORD_OF_RADIANCE, slot, (*path).radiance);
}

fn load_pdf(slot: u32, path: ptr<function, Path>) {
    (*path).pdf = bitcast<f32>(load_word(WORD_OF_PDF, slot));
}

fn store_pdf(slot: u32, path: ptr<function, Path>) {
    store_word(WORD_OF_PDF, slot, bitcast<u32>((*path).pdf));
}

// Between bounces: all that a path is when it has a new ray.
fn load_path(slot: u32, path: ptr<function, Path>) {
    load_ray(slot, path);
    load_throughput(slot, path);
    load_sample(slot, path);
    load_run(slot, path);
    //@ each light
    load_radiance(slot, path);
    load_pdf(slot, path);
    (*path).light = NO_LIGHT;
    //@ end
}

fn store_path(slot: u32, path: ptr<function, Path>) {
    store_ray(slot, path);
    store_throughput(slot, path);
    store_sample(slot, path);
    store_run(slot, path);
    //@ each light
    store_radiance(slot, path);
    store_pdf(slot, path);
    //@ end
}
