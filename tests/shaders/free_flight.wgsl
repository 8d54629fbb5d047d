//@ use medium/free_flight
alias In = vec2<u32>;
alias Out = f32;

fn run(row: u32) {
    output[row] = optical_depth(input[row]);
}
