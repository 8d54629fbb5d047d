//@ use bind/paths
//@ use bind/settings
//@ use data/path
// The state of the slots' paths in memory: planes of a vec4 of words a slot.

const PLANE_ORIGIN: u32 = 0u; // the ray's origin; t of its hit
const PLANE_DIRECTION: u32 = 1u; // the ray's direction; status
const PLANE_THROUGHPUT: u32 = 2u; // throughput; events
const PLANE_SAMPLE: u32 = 3u; // pixel; sample; instance of the hit; counts
const PLANE_SUM: u32 = 4u; // sum; rays
//@ each light
const PLANE_RADIANCE: u32 = 5u; // radiance; pdf
const PLANE_SHADOW_ORIGIN: u32 = 6u; // the shadow ray's origin; light
const PLANE_SHADOW_DIRECTION: u32 = 7u; // its direction; the light's instance
const PLANE_LIGHT: u32 = 8u; // the light's weight
//@ end

fn place(plane: u32, slot: u32) -> u32 {
    return plane * settings.slots + slot;
}

fn vector_of(word: vec4<u32>) -> vec3<f32> {
    return bitcast<vec3<f32>>(word.xyz);
}

fn word_of(vector: vec3<f32>, last: u32) -> vec4<u32> {
    return vec4<u32>(bitcast<vec3<u32>>(vector), last);
}

fn load_status(slot: u32) -> u32 {
    return paths[place(PLANE_DIRECTION, slot)].w;
}

fn store_status(slot: u32, status: u32) {
    paths[place(PLANE_DIRECTION, slot)].w = status;
}

fn load_ray(slot: u32, path: ptr<function, Path>) {
    let origin = paths[place(PLANE_ORIGIN, slot)];
    let direction = paths[place(PLANE_DIRECTION, slot)];
    (*path).ray = Ray(vector_of(origin), vector_of(direction));
    (*path).t = bitcast<f32>(origin.w);
    (*path).status = direction.w;
}

fn store_ray(slot: u32, path: ptr<function, Path>) {
    paths[place(PLANE_ORIGIN, slot)] = word_of((*path).ray.origin, bitcast<u32>((*path).t));
    paths[place(PLANE_DIRECTION, slot)] = word_of((*path).ray.direction, (*path).status);
}

fn store_hit(slot: u32, path: ptr<function, Path>) {
    paths[place(PLANE_ORIGIN, slot)].w = bitcast<u32>((*path).t);
    store_status(slot, (*path).status);
    //@ each mesh
    paths[place(PLANE_SAMPLE, slot)].z = (*path).instance;
    //@ end
}

fn load_throughput(slot: u32, path: ptr<function, Path>) {
    let word = paths[place(PLANE_THROUGHPUT, slot)];
    (*path).throughput = vector_of(word);
    (*path).events = word.w;
}

fn store_throughput(slot: u32, path: ptr<function, Path>) {
    paths[place(PLANE_THROUGHPUT, slot)] = word_of((*path).throughput, (*path).events);
}

fn load_sample(slot: u32, path: ptr<function, Path>) {
    let word = paths[place(PLANE_SAMPLE, slot)];
    (*path).pixel = word.x;
    (*path).sample = word.y;
    (*path).instance = word.z;
    (*path).counts = word.w;
}

fn store_sample(slot: u32, path: ptr<function, Path>) {
    paths[place(PLANE_SAMPLE, slot)] = vec4<u32>((*path).pixel, (*path).sample, (*path).instance, (*path).counts);
}

fn load_sum(slot: u32, path: ptr<function, Path>) {
    let word = paths[place(PLANE_SUM, slot)];
    (*path).sum = vector_of(word);
    (*path).rays = word.w;
}

fn store_sum(slot: u32, path: ptr<function, Path>) {
    paths[place(PLANE_SUM, slot)] = word_of((*path).sum, (*path).rays);
}

//@ each light
fn load_radiance(slot: u32, path: ptr<function, Path>) {
    let word = paths[place(PLANE_RADIANCE, slot)];
    (*path).radiance = vector_of(word);
    (*path).pdf = bitcast<f32>(word.w);
}

fn store_radiance(slot: u32, path: ptr<function, Path>) {
    paths[place(PLANE_RADIANCE, slot)] = word_of((*path).radiance, bitcast<u32>((*path).pdf));
}

fn load_light(slot: u32) -> u32 {
    return paths[place(PLANE_SHADOW_ORIGIN, slot)].w;
}

fn load_shadow(slot: u32, path: ptr<function, Path>) {
    let origin = paths[place(PLANE_SHADOW_ORIGIN, slot)];
    let direction = paths[place(PLANE_SHADOW_DIRECTION, slot)];
    (*path).shadow = Ray(vector_of(origin), vector_of(direction));
    (*path).light = origin.w;
    (*path).light_instance = direction.w;
    (*path).light_weight = vector_of(paths[place(PLANE_LIGHT, slot)]);
}

fn store_shadow(slot: u32, path: ptr<function, Path>) {
    paths[place(PLANE_SHADOW_ORIGIN, slot)] = word_of((*path).shadow.origin, (*path).light);
    paths[place(PLANE_SHADOW_DIRECTION, slot)] = word_of((*path).shadow.direction, (*path).light_instance);
    paths[place(PLANE_LIGHT, slot)] = word_of((*path).light_weight, 0u);
}
//@ end

fn load_path(slot: u32, path: ptr<function, Path>) {
    load_ray(slot, path);
    load_throughput(slot, path);
    load_sample(slot, path);
    load_sum(slot, path);
    //@ each light
    load_radiance(slot, path);
    load_shadow(slot, path);
    //@ end
}

fn store_path(slot: u32, path: ptr<function, Path>) {
    store_ray(slot, path);
    store_throughput(slot, path);
    store_sample(slot, path);
    store_sum(slot, path);
    //@ each light
    store_radiance(slot, path);
    store_shadow(slot, path);
    //@ end
}
