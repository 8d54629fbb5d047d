//@ use bind/settings
// An index into a table, in a form that no compiler knows. Mesa 22.3 keeps a list of the elements of uniform bindings that
// decide a branch and whose index it knows. The list has room for three bindings. For any further binding, Mesa writes over the
// memory behind the list. So every index that could turn out to be constant goes through this function (docs/architecture.md).
fn at_run_time(index: u32) -> u32 {
    return index + settings.zero;
}
