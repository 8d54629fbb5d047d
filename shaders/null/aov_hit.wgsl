//@ use data/path
// The film has no channel of the surface that camera rays hit.
fn note_hit(path: ptr<function, Path>) {
}
