//@ use bind/paths
//@ each other_path_word
//@ use bind/path_words
//@ end
//@ use bind/settings
//@ use data/path
//@ if light
//@ use data/light
//@ end
// The state of the slots' paths in memory. It has only the fields that this scene's kernels pass to each other
// (src/plan/state.rs lists them). Most fields lie in planes of one vec4 of words per slot, which are read and written as a
// whole. Words that fit no plane lie in a separate buffer. If a vector has no fourth word of its own, the fourth word of its
// vec4 holds another field, as long as there is one.

//@ each path_plane
const PLANE_OF_${name}: u32 = ${number}u;
//@ end

fn place(plane: u32, slot: u32) -> u32 {
    return plane * settings.slots + slot;
}

fn vector_of(words: vec4<u32>) -> vec3<f32> {
    return bitcast<vec3<f32>>(words.xyz);
}

fn store_plane(plane: u32, slot: u32, vector: vec3<f32>, last: u32) {
    paths[place(plane, slot)] = vec4<u32>(bitcast<vec3<u32>>(vector), last);
}

// Stores a vector alone, because the fourth word belongs to another field.
fn store_vector(plane: u32, slot: u32, vector: vec3<f32>) {
    let words = bitcast<vec3<u32>>(vector);
    paths[place(plane, slot)].x = words.x;
    paths[place(plane, slot)].y = words.y;
    paths[place(plane, slot)].z = words.z;
}

//@ each path_word
fn load_${name}(slot: u32) -> u32 {
    return paths[place(${number}u / 4u, slot)][${number}u % 4u];
}

fn store_${name}(slot: u32, value: u32) {
    paths[place(${number}u / 4u, slot)][${number}u % 4u] = value;
}

//@ end
//@ each other_path_word
fn load_${name}(slot: u32) -> u32 {
    return path_words[place(${number}u, slot)];
}

fn store_${name}(slot: u32, value: u32) {
    path_words[place(${number}u, slot)] = value;
}

//@ end
fn load_status(slot: u32) -> u32 {
    return paths[place(PLANE_OF_DIRECTION, slot)].w;
}

fn store_status(slot: u32, status: u32) {
    paths[place(PLANE_OF_DIRECTION, slot)].w = status;
}

fn load_ray(slot: u32, path: ptr<function, Path>) {
    let direction = paths[place(PLANE_OF_DIRECTION, slot)];
    (*path).ray = Ray(vector_of(paths[place(PLANE_OF_ORIGIN, slot)]), vector_of(direction));
    (*path).status = direction.w;
}

fn store_ray(slot: u32, path: ptr<function, Path>) {
    store_vector(PLANE_OF_ORIGIN, slot, (*path).ray.origin);
    store_plane(PLANE_OF_DIRECTION, slot, (*path).ray.direction, (*path).status);
}

//@ if probed
// The word of the depth has the history of the path's lobes in its highest bits. No path has as many events as are left for the depth.
const DEPTH_BITS: u32 = 29u;

fn word_of_depth(path: ptr<function, Path>) -> u32 {
    return min((*path).depth, (1u << DEPTH_BITS) - 1u) | ((*path).history << DEPTH_BITS);
}

fn take_depth(path: ptr<function, Path>, word: u32) {
    (*path).depth = word & ((1u << DEPTH_BITS) - 1u);
    (*path).history = word >> DEPTH_BITS;
}

//@ end
//@ if unprobed
fn word_of_depth(path: ptr<function, Path>) -> u32 {
    return (*path).depth;
}

fn take_depth(path: ptr<function, Path>, word: u32) {
    (*path).depth = word;
}

//@ end
fn load_throughput(slot: u32, path: ptr<function, Path>) {
    let words = paths[place(PLANE_OF_THROUGHPUT, slot)];
    (*path).throughput = vector_of(words);
    take_depth(path, words.w);
}

fn store_throughput(slot: u32, path: ptr<function, Path>) {
    store_plane(PLANE_OF_THROUGHPUT, slot, (*path).throughput, word_of_depth(path));
}

fn load_sample_of_path(slot: u32, path: ptr<function, Path>) {
    (*path).pixel = load_pixel(slot);
    (*path).sample = load_sample(slot);
}

fn load_run(slot: u32, path: ptr<function, Path>) {
    let words = paths[place(PLANE_OF_SUM, slot)];
    (*path).sum = Compensated(vector_of(words), vector_of(paths[place(PLANE_OF_EXCESS, slot)]));
    (*path).rays = words.w;
    (*path).counts = load_counts(slot);
    (*path).spread = vector_of(paths[place(PLANE_OF_SPREAD, slot)]);
}

fn load_rays(slot: u32) -> u32 {
    return paths[place(PLANE_OF_SUM, slot)].w;
}

fn store_rays(slot: u32, rays: u32) {
    paths[place(PLANE_OF_SUM, slot)].w = rays;
}

fn load_radiance(slot: u32, path: ptr<function, Path>) {
    let words = paths[place(PLANE_OF_RADIANCE, slot)];
    (*path).radiance = vector_of(words);
    (*path).pdf = bitcast<f32>(words.w);
}

fn store_radiance(slot: u32, path: ptr<function, Path>) {
    store_plane(PLANE_OF_RADIANCE, slot, (*path).radiance, bitcast<u32>((*path).pdf));
}

// What `--aov` keeps of the first hits, of the surfaces that are seen, and of direct light.
fn load_aov_hit(slot: u32, path: ptr<function, Path>) {
    //@ if aov_hits
    (*path).hits = bitcast<f32>(load_hits(slot));
    //@ end
    //@ if aov_depth
    (*path).depth_sum = bitcast<f32>(load_depth_sum(slot));
    //@ end
    //@ if aov_position
    (*path).position_sum = vector_of(paths[place(PLANE_OF_POSITION_SUM, slot)]);
    //@ end
    //@ if aov_object
    (*path).object = bitcast<f32>(load_object(slot));
    //@ end
    //@ if aov_material
    (*path).material = bitcast<f32>(load_material(slot));
    //@ end
}

fn store_aov_hit(slot: u32, path: ptr<function, Path>) {
    //@ if aov_hits
    store_hits(slot, bitcast<u32>((*path).hits));
    //@ end
    //@ if aov_depth
    store_depth_sum(slot, bitcast<u32>((*path).depth_sum));
    //@ end
    //@ if aov_position
    store_vector(PLANE_OF_POSITION_SUM, slot, (*path).position_sum);
    //@ end
    //@ if aov_object
    store_object(slot, bitcast<u32>((*path).object));
    //@ end
    //@ if aov_material
    store_material(slot, bitcast<u32>((*path).material));
    //@ end
}

fn load_aov_surface(slot: u32, path: ptr<function, Path>) {
    //@ if aov_rough
    (*path).seen = load_seen(slot);
    //@ end
    //@ if aov_albedo
    (*path).albedo_sum = vector_of(paths[place(PLANE_OF_ALBEDO_SUM, slot)]);
    //@ end
    //@ if aov_normal
    (*path).normal_sum = vector_of(paths[place(PLANE_OF_NORMAL_SUM, slot)]);
    //@ end
}

fn store_aov_surface(slot: u32, path: ptr<function, Path>) {
    //@ if aov_rough
    store_seen(slot, (*path).seen);
    //@ end
    //@ if aov_albedo
    store_vector(PLANE_OF_ALBEDO_SUM, slot, (*path).albedo_sum);
    //@ end
    //@ if aov_normal
    store_vector(PLANE_OF_NORMAL_SUM, slot, (*path).normal_sum);
    //@ end
}

//@ if aov_direct
fn load_direct(slot: u32, path: ptr<function, Path>) {
    (*path).direct = vector_of(paths[place(PLANE_OF_DIRECT, slot)]);
}

fn store_direct(slot: u32, path: ptr<function, Path>) {
    store_vector(PLANE_OF_DIRECT, slot, (*path).direct);
}

//@ end
// Loads all that a path keeps between two bounces.
fn load_path(slot: u32, path: ptr<function, Path>) {
    load_ray(slot, path);
    load_throughput(slot, path);
    load_sample_of_path(slot, path);
    load_run(slot, path);
    //@ if gathers
    load_radiance(slot, path);
    //@ end
    //@ if light
    (*path).light = NO_LIGHT;
    //@ end
    //@ if aov_direct
    load_direct(slot, path);
    (*path).direct_sum = vector_of(paths[place(PLANE_OF_DIRECT_SUM, slot)]);
    //@ end
    //@ if aov_hit
    load_aov_hit(slot, path);
    //@ end
    //@ if aov_surface
    load_aov_surface(slot, path);
    //@ end
}

fn store_path(slot: u32, path: ptr<function, Path>) {
    store_ray(slot, path);
    store_throughput(slot, path);
    store_pixel(slot, (*path).pixel);
    store_sample(slot, (*path).sample);
    store_plane(PLANE_OF_SUM, slot, (*path).sum.sum, (*path).rays);
    store_vector(PLANE_OF_EXCESS, slot, (*path).sum.excess);
    store_vector(PLANE_OF_SPREAD, slot, (*path).spread);
    store_counts(slot, (*path).counts);
    //@ if gathers
    store_radiance(slot, path);
    //@ end
    //@ if aov_direct
    store_direct(slot, path);
    store_vector(PLANE_OF_DIRECT_SUM, slot, (*path).direct_sum);
    //@ end
    //@ if aov_hit
    store_aov_hit(slot, path);
    //@ end
    //@ if aov_surface
    store_aov_surface(slot, path);
    //@ end
}
