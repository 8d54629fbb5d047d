//@ use data/path
// Nothing moves.
fn begin_time(path: ptr<function, Path>) {
}
