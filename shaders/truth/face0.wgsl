//@ use truth/word
//@ use choice/face_of_hit
// The number of the face of a mesh that is hit, from 1 in the order of the file; 0 is none.
fn face0_of(path: ptr<function, Path>) -> u32 {
    if !has_hit(path) {
        return 0u;
    }
    return face_of_hit(path);
}
