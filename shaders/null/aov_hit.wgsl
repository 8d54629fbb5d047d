//@ use data/path
// The film has no channel of the surface that camera rays hit.
fn record_hit(path: ptr<function, Path>) {
}
