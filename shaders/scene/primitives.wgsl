//@ use data/ray
//@ use data/hit
//@ use data/primitive
//@ each primitive
//@ use geometry/${name}
//@ use bind/${name}s
//@ end
// The scene's primitives by their codes, of just the kinds that the scene has.

// Distance to the primitive in front of the ray's origin, or NO_HIT.
fn primitive_distance(code: u32, ray: Ray) -> f32 {
    let index = primitive_index(code);
    switch primitive_kind(code) {
        //@ each primitive
        ${case}: {
            return ${name}_distance(ray, ${name}s[index]);
        }
        //@ end
    }
}

// Place among the scene's primitives.
fn primitive_order(code: u32) -> u32 {
    let index = primitive_index(code);
    switch primitive_kind(code) {
        //@ each primitive
        ${case}: {
            return ${name}s[index].order;
        }
        //@ end
    }
}
