//@ use data/path
const MOST_STEPS_OF_MEDIA: u32 = 0u;

// Nothing lies between the path and what its ray met.
fn cross_media(path: ptr<function, Path>) -> u32 {
    return 0u;
}
