//@ use step/film
// Adds runs to the film.

struct Row {
    sum: array<f32, 3>,
    pixel: u32,
    counts: u32,
    rays: u32,
    spread: array<f32, 3>,
}

@group(0) @binding(21) var<storage, read> input: array<Row>;
@group(0) @binding(22) var<storage, read_write> output: array<u32>;

fn run(row: u32) {
    let it = input[row];
    let sum = vec3<f32>(it.sum[0], it.sum[1], it.sum[2]);
    let spread = vec3<f32>(it.spread[0], it.spread[1], it.spread[2]);
    add_run(it.pixel, it.counts, it.rays, sum, spread);
    output[row] = row;
}
