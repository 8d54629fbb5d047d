//@ use data/window
// The film has no channel but radiance.
fn add_aov(pixel: u32, run: RunRecord) {
}
