//@ implements mark_of_run when truth
// Marks the run that has sample 0 of its pixel.
fn mark_of_run(path: ptr<function, Path>) -> u32 {
    return select(0u, FIRST_RUN, (*path).sample == 0u);
}

//@ without
// No channel is of sample 0.
fn mark_of_run(path: ptr<function, Path>) -> u32 {
    return 0u;
}
