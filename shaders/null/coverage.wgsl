//@ use data/dimension
//@ use data/hit
//@ use data/path
//@ use data/ray
//@ use data/surface
// All surfaces stop all light.
fn begin_walk(path: ptr<function, Path>, block: u32) {
}
