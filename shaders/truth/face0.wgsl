//@ implements face0 when truth & mesh
//@ use truth/word
//@ use choice/faces
// The number of the face of a mesh that is hit, from 1 in the order of the file.
fn face0_of(path: ptr<function, Path>) -> u32 {
    if !has_hit(path) || primitive_kind((*path).status) != KIND_TRIANGLE {
        return 0u;
    }
    return face_number(primitive_index((*path).status)) + 1u;
}

//@ without
// There are no meshes.
fn face0_of(path: ptr<function, Path>) -> u32 {
    return 0u;
}
