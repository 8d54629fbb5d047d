//@ use data/path
// No medium scatters paths.
const MOST_STEPS_OF_MEDIA: u32 = 0u;

fn cross_media(path: ptr<function, Path>, iterations: u32) -> u32 {
    return iterations;
}
