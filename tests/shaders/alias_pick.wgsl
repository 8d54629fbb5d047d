//@ use light/alias
// What a uniform picks of a table of so many entries.
struct In {
    u: f32,
    count: u32,
}

struct Out {
    index: u32,
    rest: f32,
}

fn run(row: u32) {
    let pick = alias_pick(input[row].u, input[row].count);
    output[row] = Out(pick.index, pick.rest);
}
