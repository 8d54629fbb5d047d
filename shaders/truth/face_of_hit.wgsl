//@ implements face_of_hit when mesh
//@ use choice/faces
// The number of the face that a path has hit, from 1; 0 if it is no face.
fn face_of_hit(path: ptr<function, Path>) -> u32 {
    let code = (*path).status;
    return select(0u, part_number(path_hit(path)) + 1u, primitive_kind(code) == KIND_TRIANGLE);
}

//@ without
// There are no meshes.
fn face_of_hit(path: ptr<function, Path>) -> u32 {
    return 0u;
}
