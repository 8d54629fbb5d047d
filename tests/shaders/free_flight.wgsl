//@ use medium/free_flight
@group(0) @binding(21) var<storage, read> input: array<vec2<u32>>;
@group(0) @binding(22) var<storage, read_write> output: array<f32>;

fn run(row: u32) {
    output[row] = optical_depth(input[row]);
}
