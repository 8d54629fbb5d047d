//@ use light/alias
// What eight uniforms one after the other draw of a table: those from 8 row / 2^24 on.
struct In {
    threshold: f32,
    alias_index: u32,
}

struct Out {
    first: vec4<u32>,
    last: vec4<u32>,
}

fn drawn(k: u32) -> u32 {
    let pick = alias_pick(f32(k) * 0x1p-24f, ${count}u);
    let entry = input[pick.index];
    return select(entry.alias_index, pick.index, pick.rest < entry.threshold);
}

fn run(row: u32) {
    let k = 8u * row;
    output[row] = Out(
        vec4<u32>(drawn(k), drawn(k + 1u), drawn(k + 2u), drawn(k + 3u)),
        vec4<u32>(drawn(k + 4u), drawn(k + 5u), drawn(k + 6u), drawn(k + 7u)),
    );
}
