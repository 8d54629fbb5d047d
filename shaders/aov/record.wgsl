//@ implements aov_record when aov
// The sums of `--aov` of a finished run.
fn record_aov(run: ptr<function, RunRecord>, path: ptr<function, Path>) {
    (*run).aov = (*path).aov;
}

fn clear_aov(path: ptr<function, Path>) {
    (*path).aov = array<f32, ${path_sums}>();
}

//@ without
// The film has no channel but radiance.
fn record_aov(run: ptr<function, RunRecord>, path: ptr<function, Path>) {
}

fn clear_aov(path: ptr<function, Path>) {
}
