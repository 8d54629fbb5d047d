// What a ray meets first.
struct Hit {
    code: u32,
    t: f32,
    // Nodes and primitives looked at.
    steps: u32,
    //@ if mesh
    // The mesh that a triangle is part of.
    instance: u32,
    //@ end
}

const NO_INSTANCE: u32 = 0xffffffffu;

// Something that is part of no mesh.
fn hit_at(code: u32, t: f32) -> Hit {
    var hit: Hit;
    hit.code = code;
    hit.t = t;
    //@ if mesh
    hit.instance = NO_INSTANCE;
    //@ end
    return hit;
}
