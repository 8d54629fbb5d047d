//@ use scene/traverse
//@ use scene/surfaces
//@ use choice/shading
// The nearest hit of a ray by the walk through both levels and by asking every face of every instance; and the nearest hit
// of a second ray, which leaves from there.
struct In {
    origin: vec3<f32>,
    root: u32,
    direction: vec3<f32>,
    // Whether every face is to be tested.
    ask: u32,
    leaving: vec3<f32>,
    padding: u32,
}

struct Out {
    // Code, instance, t as bits, steps.
    walked: vec4<u32>,
    brute_force: vec4<u32>,
    point: vec3<f32>,
    again: f32,
    normal: vec3<f32>,
    again_code: u32,
    start: vec3<f32>,
    again_instance: u32,
}

const INSTANCES: u32 = ${instances}u;
const FACES: u32 = ${faces}u;

fn brute_force_hit(ray: Ray) -> Hit {
    var brute_force = hit_at(HIT_NOTHING, VERY_FAR);
    for (var i = 0u; i < INSTANCES; i++) {
        let here = to_mesh(instances[i], ray);
        for (var face = 0u; face < FACES; face++) {
            let code = PRIMITIVE_BIT | (KIND_TRIANGLE << PRIMITIVE_KIND_SHIFT) | face;
            let t = face_hit(here, corners_of(face)).t;
            if t != NO_HIT && t < brute_force.t {
                brute_force = hit_at(code, t);
                brute_force.instance = i;
            }
        }
    }
    return brute_force;
}

fn words_of(hit: Hit) -> vec4<u32> {
    return vec4<u32>(hit.code, hit.instance, bitcast<u32>(hit.t), hit.steps);
}

fn run(row: u32) {
    let given = input[row];
    let ray = Ray(given.origin, given.direction);
    var out: Out;
    let hit = nearest_hit(ray, given.root);
    out.walked = words_of(hit);
    out.brute_force = out.walked;
    if given.ask != 0u {
        out.brute_force = words_of(brute_force_hit(ray));
    }
    out.again = NO_HIT;
    if hit.code != HIT_NOTHING && any(given.leaving != vec3<f32>(0.0)) {
        let surface = surface_at(hit, ray);
        let facing = select(-surface.normal, surface.normal, dot(ray.direction, surface.normal) < 0.0);
        let shading = shading_normal(hit, surface, ray.direction, facing);
        let start = spawn_ray(hit, surface, facing, shading, event_point(hit, surface, facing), given.leaving).origin;
        let second = nearest_hit(Ray(start, given.leaving), given.root);
        out.point = surface.point;
        out.normal = surface.normal;
        out.start = start;
        out.again = select(second.t, NO_HIT, second.code == HIT_NOTHING);
        out.again_code = second.code;
        out.again_instance = second.instance;
    }
    output[row] = out;
}
