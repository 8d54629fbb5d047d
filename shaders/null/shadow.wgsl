//@ use data/path
// No light is sampled.
fn trace_shadow(path: ptr<function, Path>, iterations: u32) -> u32 {
    return iterations;
}
