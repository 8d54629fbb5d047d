//@ use bind/paths
//@ each other_path_word
//@ use bind/path_words
//@ end
//@ use bind/settings
// Where the state of the slots' paths lies. It has only the fields that this scene's kernels pass to each other
// (src/plan/state.rs lists them). Most fields lie in planes of one vec4 of words per slot, which are read and written at
// once. Words that fit no plane lie in a separate buffer. If a vector has no fourth word of its own, the fourth word of its
// vec4 holds another field, as long as there is one.

//@ each path_plane
const PLANE_OF_${name}: u32 = ${number}u;
//@ end

fn index_of(plane: u32, slot: u32) -> u32 {
    return plane * settings.slots + slot;
}

fn vector_of(words: vec4<u32>) -> vec3<f32> {
    return bitcast<vec3<f32>>(words.xyz);
}

fn store_plane(plane: u32, slot: u32, vector: vec3<f32>, last: u32) {
    paths[index_of(plane, slot)] = vec4<u32>(bitcast<vec3<u32>>(vector), last);
}

// Stores a vector alone, because the fourth word belongs to another field.
fn store_vector(plane: u32, slot: u32, vector: vec3<f32>) {
    let words = bitcast<vec3<u32>>(vector);
    paths[index_of(plane, slot)].x = words.x;
    paths[index_of(plane, slot)].y = words.y;
    paths[index_of(plane, slot)].z = words.z;
}

//@ each path_word
fn load_${name}(slot: u32) -> u32 {
    return paths[index_of(${number}u / 4u, slot)][${number}u % 4u];
}

fn store_${name}(slot: u32, value: u32) {
    paths[index_of(${number}u / 4u, slot)][${number}u % 4u] = value;
}

//@ end
//@ each other_path_word
fn load_${name}(slot: u32) -> u32 {
    return path_words[index_of(${number}u, slot)];
}

fn store_${name}(slot: u32, value: u32) {
    path_words[index_of(${number}u, slot)] = value;
}

//@ end
