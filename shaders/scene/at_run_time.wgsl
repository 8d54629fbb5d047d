//@ use bind/settings
// Returns an index into a table in a form that no compiler takes for a constant. Mesa 22.3 keeps a list of the elements of uniform
// bindings that decide a branch and whose index is constant. The list has room for three bindings. For any further binding, Mesa
// writes over the memory behind the list. So every index that could turn out to be constant goes through this function (docs/dev/architecture.md).
fn at_run_time(index: u32) -> u32 {
    return index + settings.zero;
}
