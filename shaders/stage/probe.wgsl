//@ use bind/trials
//@ use bind/answers
// Probes the arithmetic of this driver that kernels may rely on. The host knows the correct answers (src/gpu/probe.rs). All
// inputs come from a uniform, so that no compiler computes a result in advance.
override WORKGROUP_SIZE: u32 = 64u;

// A barrier: the float as it is, in a form that no compiler can simplify: `zero` is 0.
fn barrier(x: f32, zero: u32) -> f32 {
    return bitcast<f32>(bitcast<u32>(x) ^ zero);
}

// The rounding error of x + y: Knuth, "The Art of Computer Programming", vol. 2, section 4.2.2.
fn sum_error(x: f32, y: f32) -> f32 {
    let sum = x + y;
    let part = sum - x;
    return (x - (sum - part)) + (y - part);
}

fn sum_error_barrier(x: f32, y: f32, zero: u32) -> f32 {
    let sum = barrier(x + y, zero);
    let part = barrier(sum - x, zero);
    return (x - (sum - part)) + (y - part);
}

// The rounding error of x y, from halves of 12 bits: Dekker, "A floating-point technique for extending the available
// precision", Numerische Mathematik 18, 1971.
fn product_error_barrier(x: f32, y: f32, zero: u32) -> f32 {
    let product = barrier(x * y, zero);
    let x_high = bitcast<f32>(bitcast<u32>(x) & 0xfffff000u);
    let y_high = bitcast<f32>(bitcast<u32>(y) & 0xfffff000u);
    let x_low = barrier(x - x_high, zero);
    let y_low = barrier(y - y_high, zero);
    let first = barrier(x_high * y_high - product, zero);
    let second = barrier(first + x_high * y_low, zero);
    return barrier(second + x_low * y_high, zero) + x_low * y_low;
}

fn classes_of(x: f32) -> u32 {
    return select(0u, 1u, x != x)
        | select(0u, 2u, x < 1.0)
        | select(0u, 4u, x >= 1.0)
        | select(0u, 8u, !(x >= 1.0))
        | select(0u, 16u, is_nan(x))
        | select(0u, 32u, is_infinite(x));
}

// The state of a generator after `loops` steps. No compiler finds a shortcut for this loop (ranqd1 of Press, Teukolsky,
// Vetterling and Flannery, "Numerical Recipes in C", 2nd ed., section 7.1).
fn state_after(loops: u32) -> u32 {
    var state = 1u;
    for (var i = 0u; i < loops; i++) {
        state = state * 1664525u + 1013904223u;
    }
    return state;
}

@compute @workgroup_size(WORKGROUP_SIZE)
fn probe(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= 64u {
        return;
    }
    let trial = trials[id.x];
    var answer: Answer;
    answer.sum_error = bitcast<u32>(sum_error(trial.x, trial.y));
    answer.sum_error_barrier = bitcast<u32>(sum_error_barrier(trial.x, trial.y, trial.zero));
    answer.product_error_barrier = bitcast<u32>(product_error_barrier(trial.x, trial.y, trial.zero));
    answer.fma_error = bitcast<u32>(fma(trial.x, trial.y, -trial.product));
    answer.contracted = bitcast<u32>(trial.x * trial.y - trial.product);
    answer.sine = bitcast<u32>(sin(trial.angle));
    answer.far_sine = bitcast<u32>(sin(trial.far_angle));
    answer.logarithm = bitcast<u32>(log(trial.log_of));
    answer.converted = bitcast<u32>(f32(trial.word));
    answer.uniform_of_32 = bitcast<u32>(f32(trial.word) * 0x1p-32f);
    answer.uniform_of_24 = bitcast<u32>(f32(trial.word >> 8u) * 0x1p-24f);
    answer.classes_of_special = classes_of(bitcast<f32>(trial.special));
    answer.made_subnormal = bitcast<u32>(bitcast<f32>(trial.least) * 0x1p-4f);
    answer.from_subnormal = bitcast<u32>(bitcast<f32>(trial.subnormal) * 0x1p24f);
    answer.edge_sign = i32(close_sign(trial.p_x, trial.p_y, trial.q_x, trial.q_y));
    // This is the only loop, and it comes last: a limit on loops would end every loop after it.
    answer.loop_state = state_after(trial.loops);
    answers[id.x] = answer;
}
