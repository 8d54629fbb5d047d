//@ use data/path
//@ use data/window
// The film has no channel but radiance.
fn record_aov(run: ptr<function, RunRecord>, path: ptr<function, Path>) {
}

fn clear_aov(path: ptr<function, Path>) {
}
