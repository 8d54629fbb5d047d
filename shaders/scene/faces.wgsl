//@ implements faces when mesh
//@ use geometry/triangle
//@ use scene/at_run_time
// Faces of meshes are parts of objects, which are the instances of the meshes.

// The code of the object that a primitive is part of: of a face, that of the instance. Without an instance, a face is that of a mesh alone.
fn object_code(code: u32, instance: u32) -> u32 {
    let of_mesh = PRIMITIVE_BIT | (KIND_INSTANCE << PRIMITIVE_KIND_SHIFT) | at_run_time(instance);
    return select(code, of_mesh, primitive_kind(code) == KIND_TRIANGLE);
}

// A number that distinguishes the parts of one object: of a face, its number in the file.
fn part_number(hit: Hit) -> u32 {
    if primitive_kind(hit.code) == KIND_TRIANGLE {
        return face_number(primitive_index(hit.code));
    }
    return 0u;
}

// A point in the object's space, by the coordinates that its surface has for it.
fn point_in_object(hit: Hit, local: vec3<f32>) -> vec3<f32> {
    if primitive_kind(hit.code) == KIND_TRIANGLE {
        return mesh_point(primitive_index(hit.code), local);
    }
    return local;
}

//@ without
// Each primitive is an object.
fn object_code(code: u32, instance: u32) -> u32 {
    return code;
}

fn part_number(hit: Hit) -> u32 {
    return 0u;
}

fn point_in_object(hit: Hit, local: vec3<f32>) -> vec3<f32> {
    return local;
}
