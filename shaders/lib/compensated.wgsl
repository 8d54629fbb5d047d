// Sums with what they have lost to rounding beside them: Kahan, "Pracniques: further remarks on reducing truncation errors",
// Communications of the ACM 8(1), 1965. Of n terms of one sign, sum - excess is off by 2 u and some n u² of it (Higham, "Accuracy and
// Stability of Numerical Algorithms", 2nd ed., section 4.3).

struct Compensated {
    sum: vec3<f32>,
    // What the sum is too large by.
    excess: vec3<f32>,
}

// The same floats, in a form that no compiler sees through: `zero` is 0, and comes from a uniform.
fn barrier(x: vec3<f32>, zero: u32) -> vec3<f32> {
    return bitcast<vec3<f32>>(bitcast<vec3<u32>>(x) ^ vec3<u32>(zero));
}

// Where a driver undoes it in spite of the barriers (src/gpu/probe.rs), the excess is 0 and the sum is a plain one.
fn compensated_sum(before: Compensated, term: vec3<f32>, zero: u32) -> Compensated {
    let added = term - before.excess;
    let sum = barrier(before.sum + added, zero);
    return Compensated(sum, barrier(sum - before.sum, zero) - added);
}
