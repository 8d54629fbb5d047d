//@ use choice/delta_lights
//@ use choice/pose
//@ use choice/faces
//@ each single
//@ use geometry/${name}
//@ use bind/${name}s
//@ use choice/moved_${name}
//@ end
//@ each object
//@ use bind/${name}s
//@ end
// The scene's primitives by their codes; only the kinds that the scene has.

// Distance to the primitive in front of the ray's origin, or NO_HIT. Faces of meshes are tested in pairs (scene/face_pairs).
fn primitive_distance(code: u32, pose: Pose, ray: Ray) -> f32 {
    let index = primitive_index(code);
    switch primitive_kind(code) {
        //@ each single
        ${case}: {
            return ${name}_distance(ray, moved_${name}(${name}s[index], pose));
        }
        //@ end
        //@ each paired
        ${case}: {
            return NO_HIT;
        }
        //@ end
    }
}

// Index in the scene's order of the object that was hit.
fn primitive_order(hit: Hit) -> u32 {
    let code = object_code(hit.code, hit.instance);
    let index = primitive_index(code);
    switch primitive_kind(code) {
        //@ each object
        ${case}: {
            return place_of(${name}s[index].order);
        }
        //@ end
    }
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
    return order < other || (order == other && part_number(candidate) < part_number(hit));
}
