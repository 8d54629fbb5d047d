// The nearest hit of a ray.
struct Hit {
    code: u32,
    t: f32,
    // The number of nodes and primitives that the walk has visited.
    steps: u32,
    // For a triangle: the instance of its mesh.
    instance: u32,
}

const NO_INSTANCE: u32 = 0xffffffffu;

// A hit without an instance: on a primitive that is not part of a mesh, or on nothing.
fn hit_at(code: u32, t: f32) -> Hit {
    var hit: Hit;
    hit.code = code;
    hit.t = t;
    hit.instance = NO_INSTANCE;
    return hit;
}
