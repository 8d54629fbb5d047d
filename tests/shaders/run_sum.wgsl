//@ use bind/settings
// The sum of a run's samples, and how they are spread, as step/refill takes them in.
const RUN_LENGTH: u32 = 8u;

alias In = f32;
alias Out = vec2<f32>;

fn run(row: u32) {
    var sum = Compensated();
    var spread = vec3<f32>(0.0);
    for (var i = row * RUN_LENGTH; i < min((row + 1u) * RUN_LENGTH, arrayLength(&input)); i++) {
        spread += squared_deviation(i - row * RUN_LENGTH, sum.sum, vec3<f32>(input[i]));
        sum = compensated_sum(sum, vec3<f32>(input[i]), settings.zero);
    }
    output[row] = vec2<f32>(sum.sum.x - sum.excess.x, spread.x);
}
