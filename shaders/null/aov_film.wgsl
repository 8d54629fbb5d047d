//@ use data/window
// The film has no channel beside the radiance.
fn add_aov(pixel: u32, run: RunRecord) {
}
