// Sums with a term for their rounding error: Kahan, "Pracniques: further remarks on reducing truncation errors",
// Communications of the ACM 8(1), 1965. For n terms of one sign, the relative error of sum - excess is 2 u plus a multiple of n
// u² (Higham, "Accuracy and Stability of Numerical Algorithms", 2nd ed., section 4.3).

struct Compensated {
    sum: vec3<f32>,
    // The rounding error: the sum is too large by this.
    excess: vec3<f32>,
}

// A barrier: the floats as they are, in a form that no compiler can simplify: `zero` is 0 and comes from a uniform.
fn barrier(x: vec3<f32>, zero: u32) -> vec3<f32> {
    return bitcast<vec3<f32>>(bitcast<vec3<u32>>(x) ^ vec3<u32>(zero));
}

// If a driver simplifies it in spite of the barriers (src/gpu/probe.rs), the excess is 0 and the sum is a plain sum.
fn compensated_sum(before: Compensated, term: vec3<f32>, zero: u32) -> Compensated {
    let added = term - before.excess;
    let sum = barrier(before.sum + added, zero);
    return Compensated(sum, barrier(sum - before.sum, zero) - added);
}
