//@ implements walker when alpha | varying
// The sample whose ray is walked, and the block of random numbers for that ray.
struct Walker {
    pixel: u32,
    sample: u32,
    dimension: u32,
}
var<private> walker: Walker;

// Sets the sample of the rays that are walked next. `block` is the block of random numbers for such a ray at the path's event.
fn begin_walk(path: ptr<function, Path>, block: u32) {
    walker = Walker((*path).pixel, (*path).sample, bounce_dimension((*path).depth, block));
}

//@ without
// No ray needs random numbers on its way.
fn begin_walk(path: ptr<function, Path>, block: u32) {
}
