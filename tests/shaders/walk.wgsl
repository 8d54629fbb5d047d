//@ use scene/traverse
// The nearest hit of a ray by the walk through the BVH, and by asking every primitive.
struct In {
    origin: vec3<f32>,
    root: u32,
    direction: vec3<f32>,
    padding: u32,
}

// Code, t as bits, steps.
struct Out {
    walked: vec3<u32>,
    padding0: u32,
    brute_force: vec3<u32>,
    padding1: u32,
}

// How many there are of each kind.
const COUNTS = array<u32, 3>(${spheres}u, ${quads}u, ${cuboids}u);

fn words_of(hit: Hit) -> vec3<u32> {
    return vec3<u32>(hit.code, bitcast<u32>(hit.t), hit.steps);
}

fn run(row: u32) {
    let ray = Ray(input[row].origin, input[row].direction);
    var brute_force = hit_at(HIT_NOTHING, VERY_FAR);
    var order = 0xffffffffu;
    for (var kind = 0u; kind < 3u; kind++) {
        for (var i = 0u; i < COUNTS[kind]; i++) {
            let code = PRIMITIVE_BIT | (kind << PRIMITIVE_KIND_SHIFT) | i;
            let t = primitive_distance(code, Pose(), ray);
            let own = primitive_order(hit_at(code, t));
            if t != NO_HIT && (t < brute_force.t || (t == brute_force.t && own < order)) {
                brute_force.code = code;
                brute_force.t = t;
                order = own;
            }
        }
    }
    let walked = nearest_hit(ray, input[row].root);
    output[row] = Out(words_of(walked), 0u, words_of(brute_force), 0u);
}
