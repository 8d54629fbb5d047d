// The nearest hit of a ray.
struct Hit {
    code: u32,
    t: f32,
    // The number of nodes and primitives that the walk has visited.
    steps: u32,
    // For a triangle: the instance of its mesh. For a convex body: FAR_SIDE if the ray comes from outside and has passed the near side.
    instance: u32,
}

const NO_INSTANCE: u32 = 0xffffffffu;
const FAR_SIDE: u32 = 0xfffffffeu;

// A hit without an instance: on a primitive that is not part of a mesh, or on nothing.
fn hit_at(code: u32, t: f32) -> Hit {
    var hit: Hit;
    hit.code = code;
    hit.t = t;
    hit.instance = NO_INSTANCE;
    return hit;
}
