//@ use light/sky
//@ use sampler/independent
// A direction towards the sky, the cells in which it was drawn and is found; for the uniforms given, or the row's own.
struct In {
    u: vec3<f32>,
    columns: u32,
    rows: u32,
    padding0: u32,
    padding1: u32,
    padding2: u32,
}

struct Out {
    direction: vec3<f32>,
    pdf: f32,
    drawn: u32,
    found: u32,
    again: f32,
    padding: u32,
}

@group(0) @binding(21) var<storage, read> input: array<In>;
@group(0) @binding(22) var<storage, read_write> output: array<Out>;
@group(0) @binding(23) var<storage, read> cells: array<AliasEntry>;

fn run(row: u32) {
    var given = input[0];
    if ${keyed} {
        given.u = random4(row, 0u, 0u, 1u).xyz;
    } else {
        given = input[row];
    }
    let pick = alias_pick(given.u.z, given.columns * given.rows);
    let choice = alias_choice(pick, cells[pick.index]);
    let direction = sky_cell_direction(choice.index, given.columns, given.rows, given.u.xy);
    let found = sky_cell_at(direction, given.columns, given.rows);
    output[row] = Out(direction, choice.density, choice.index, found, cells[found].density, 0u);
}
