//@ use data/ray
//@ use data/hit
//@ use data/primitive
//@ use choice/delta_lights
//@ use choice/pose
//@ each primitive
//@ use geometry/${name}
//@ use bind/${name}s
//@ use choice/moved_${name}
//@ end
//@ if mesh
//@ use bind/instances
//@ use scene/at_run_time
//@ use scene/meshes
//@ end
// The scene's primitives by their codes; only the kinds that the scene has.

// Distance to the primitive in front of the ray's origin, or NO_HIT. Faces of meshes are tested in pairs (scene/face_pairs).
fn primitive_distance(code: u32, pose: Pose, ray: Ray) -> f32 {
    let index = primitive_index(code);
    switch primitive_kind(code) {
        //@ each primitive
        ${case}: {
            return ${name}_distance(ray, moved_${name}(${name}s[index], pose));
        }
        //@ end
        //@ if mesh
        default: {
            return NO_HIT;
        }
        //@ end
    }
}

// Index in the scene's order of primitives; for a triangle, that of its instance.
fn primitive_order(hit: Hit) -> u32 {
    let index = primitive_index(hit.code);
    switch primitive_kind(hit.code) {
        //@ each primitive
        ${case}: {
            return place_of(${name}s[index].order);
        }
        //@ end
        //@ if mesh
        default: {
            return place_of(instances[at_run_time(hit.instance)].order);
        }
        //@ end
    }
}

// A number that distinguishes the parts of one object: for a triangle, its face's number in its file.
fn part_number(hit: Hit) -> u32 {
    var number = 0u;
    //@ if mesh
    if primitive_kind(hit.code) == KIND_TRIANGLE {
        number = face_number(primitive_index(hit.code));
    }
    //@ end
    return number;
}

// Whether a hit wins against another one at the same distance: by the primitives' order in the scene, and within a mesh by
// the faces' numbers in its file.
fn comes_before(candidate: Hit, hit: Hit) -> bool {
    // The end of a shadow ray is no primitive.
    if is_delta_light(hit.code) {
        return false;
    }
    let order = primitive_order(candidate);
    let other = primitive_order(hit);
    //@ if mesh
    if order == other {
        return face_number(primitive_index(candidate.code)) < face_number(primitive_index(hit.code));
    }
    //@ end
    return order < other;
}
