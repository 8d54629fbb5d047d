// A row's samples and their squares added up in f32, one after the other; a dispatch goes on where the last one ended.
struct Out {
    sum: f32,
    squares: f32,
    next: u32,
    padding: u32,
}

// Samples of a row, after which it starts again.
const SAMPLES: u32 = ${samples}u;
// Of a dispatch: half of the loops that every driver allows.
const STEPS: u32 = 32768u;

alias In = f32;

fn run(row: u32) {
    var state = output[row];
    for (var i = 0u; i < STEPS; i++) {
        let x = input[row * SAMPLES + state.next % SAMPLES];
        state.sum += x;
        state.squares += x * x;
        state.next += 1u;
    }
    output[row] = state;
}
