//@ use filter/${filter}
struct Out {
    point: vec2<f32>,
    weight: f32,
    padding: u32,
}

alias In = vec2<f32>;

fn run(row: u32) {
    let u = input[row];
    var weight = 1.0;
    //@ if signed
    weight = filter_weight(u);
    //@ end
    output[row] = Out(filter_point(u), weight, 0u);
}
