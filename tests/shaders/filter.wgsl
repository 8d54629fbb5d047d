//@ use filter/${filter}
struct Out {
    point: vec2<f32>,
    weight: f32,
    padding: u32,
}

@group(0) @binding(21) var<storage, read> input: array<vec2<f32>>;
@group(0) @binding(22) var<storage, read_write> output: array<Out>;

fn run(row: u32) {
    let u = input[row];
    var weight = 1.0;
    //@ if signed
    weight = filter_weight(u);
    //@ end
    output[row] = Out(filter_point(u), weight, 0u);
}
