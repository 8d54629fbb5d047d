//@ use scene/primitives
//@ use scene/surfaces
//@ use bind/materials
//@ use choice/colour
// The colour of the primitive that a ray is aimed at, where it meets it.
struct In {
    origin: vec3<f32>,
    code: u32,
    direction: vec3<f32>,
    padding: u32,
}

struct Out {
    colour: vec3<f32>,
    t: f32,
}

fn run(row: u32) {
    let given = input[row];
    let ray = Ray(given.origin, given.direction);
    let t = primitive_distance(given.code, Pose(), ray);
    var out = Out(vec3<f32>(-1.0), t);
    if t != NO_HIT {
        let surface = surface_at(hit_at(given.code, t), ray);
        out.colour = surface_colour(materials[surface.material], hit_at(given.code, t), surface);
    }
    output[row] = out;
}
