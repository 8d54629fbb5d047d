//@ use bind/paths
//@ use bind/settings
//@ use data/ray
//@ use data/primitive
// The state of a slot's path: a vec4 of words in each of five planes.

const PLANE_ORIGIN: u32 = 0u; // the ray's origin; t of its hit
const PLANE_DIRECTION: u32 = 1u; // the ray's direction; code of its hit, or what the slot is doing (data/primitive)
const PLANE_THROUGHPUT: u32 = 2u; // throughput, or the ended path's radiance; scattering events so far
const PLANE_SAMPLE: u32 = 3u; // pixel; sample; one past the run's last sample; counts of its RunRecord
const PLANE_SUM: u32 = 4u; // sum of the run's radiance; its rays

fn place(plane: u32, slot: u32) -> u32 {
    return plane * settings.slots + slot;
}

fn vector_of(word: vec4<u32>) -> vec3<f32> {
    return bitcast<vec3<f32>>(word.xyz);
}

fn word_of(vector: vec3<f32>, last: u32) -> vec4<u32> {
    return vec4<u32>(bitcast<vec3<u32>>(vector), last);
}

fn write_ray(slot: u32, ray: Ray) {
    paths[place(PLANE_ORIGIN, slot)] = word_of(ray.origin, 0u);
    paths[place(PLANE_DIRECTION, slot)] = word_of(ray.direction, RAY_READY);
}
