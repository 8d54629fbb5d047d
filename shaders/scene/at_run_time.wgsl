//@ use bind/settings
// Returns an index into a table in a form that no compiler takes for a constant. Mesa 22.3 keeps a list of the elements of uniform
// bindings that decide a branch and whose index is constant. The list has room for three bindings. For any further binding, Mesa
// writes over the memory behind the list. So every index that could turn out to be constant goes through this function (docs/dev/architecture.md).
fn at_run_time(index: u32) -> u32 {
    return index + settings.zero;
}

// The number of turns of a loop, which no compiler unrolls. Compilers inline each call, so a large function that is needed for several inputs
// stands in a loop, with one turn for each. The results are the members of a struct, in the order of the turns. Each turn moves them down and
// puts its own in the last place: `results = Results(results.second, results.third, own)`. An array that a loop fills would be in slow memory
// on GPUs (docs/dev/gpu-kernels.md).
fn turns_of_loop(count: u32) -> u32 {
    return count + settings.zero;
}
