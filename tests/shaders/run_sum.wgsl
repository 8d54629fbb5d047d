//@ use bind/settings
//@ use lib/compensated
// The sum of a run's samples, as step/refill takes them in.
const RUN_LENGTH: u32 = 8u;

@group(0) @binding(21) var<storage, read> input: array<f32>;
@group(0) @binding(22) var<storage, read_write> output: array<f32>;

fn run(row: u32) {
    var sum = Compensated();
    for (var i = row * RUN_LENGTH; i < min((row + 1u) * RUN_LENGTH, arrayLength(&input)); i++) {
        sum = compensated_sum(sum, vec3<f32>(input[i]), settings.zero);
    }
    output[row] = sum.sum.x - sum.excess.x;
}
