// The bits of a float, and of one that says where its neighbour is sought.
struct In {
    x: u32,
    toward: u32,
}

struct Out {
    nan: u32,
    infinite: u32,
    next: u32,
    padding: u32,
}

fn run(row: u32) {
    let x = bitcast<f32>(input[row].x);
    let next = next_float(x, bitcast<f32>(input[row].toward));
    output[row] = Out(u32(is_nan(x)), u32(is_infinite(x)), bitcast<u32>(next), 0u);
}
