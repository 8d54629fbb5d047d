//@ use scene/sky
// What eight uniforms one after the other draw of a list of sums: those from 8 row / 2^24 on.
struct Out {
    index: array<vec4<u32>, 2>,
    rest: array<vec4<f32>, 2>,
}

alias In = u32;

fn run(row: u32) {
    var out = Out();
    for (var i = 0u; i < 8u; i++) {
        let draw = draw_sky(input[0], ${count}u, f32(8u * row + i) * 0x1p-24f);
        out.index[i / 4u][i % 4u] = draw.index;
        out.rest[i / 4u][i % 4u] = draw.rest;
    }
    output[row] = out;
}
