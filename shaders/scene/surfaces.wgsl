//@ use choice/crossings
//@ use choice/pose
//@ each primitive
//@ use geometry/${name}
//@ use bind/${name}s
//@ use choice/moved_${name}
//@ end
//@ use choice/faces
//@ each object
//@ use bind/${name}s
//@ end
// The hit record of a ray that hits a primitive.
fn surface_at(hit: Hit, ray: Ray) -> Surface {
    let pose = pose_at(hit.code, hit.instance);
    let to_hit = ray_to_hit(hit, pose, ray);
    let index = primitive_index(hit.code);
    switch primitive_kind(hit.code) {
        //@ each primitive
        ${case}: {
            let shape = ${name}_at(index, hit.instance);
            return ${name}_at_rest(in_pose(${name}_surface(to_hit.ray, to_hit.t, moved_${name}(shape, pose)), pose), shape);
        }
        //@ end
    }
}

// Returns the hit with its side, if it is on a body (scene/crossings).
fn sided_hit(hit: Hit, ray: Ray) -> Hit {
    return with_side(hit, pose_at(hit.code, hit.instance), ray);
}

// Index of the material of the primitive that was hit.
fn material_index(hit: Hit) -> u32 {
    let code = object_code(hit.code, hit.instance);
    let index = primitive_index(code);
    switch primitive_kind(code) {
        //@ each object
        ${case}: {
            return ${name}s[index].material;
        }
        //@ end
    }
}
