// The inputs of one trial of the numerics probe. The floats are chosen so that each answer has one correct value (src/gpu/probe.rs).
struct Trial {
    // Two floats whose sum and product are both rounded, and their rounded product.
    x: f32,
    y: f32,
    product: f32,
    // Within [-pi, pi].
    angle: f32,
    // Far outside [-pi, pi].
    far_angle: f32,
    // In [0.5, 1).
    log_of: f32,
    word: u32,
    // The bits of a NaN, an infinity or another number.
    special: u32,
    // The bits of a normal number whose 16th part is subnormal, and the bits of a subnormal number.
    least: u32,
    subnormal: u32,
    // 0. No compiler knows its value.
    zero: u32,
    loops: u32,
    // Two points in nearly the same direction from the origin.
    p_x: f32,
    p_y: f32,
    q_x: f32,
    q_y: f32,
}

// What the driver computes for a trial. Floats are stored as their bits, so that nothing is flushed on the way out.
struct Answer {
    sum_error: u32,
    sum_error_barrier: u32,
    product_error_barrier: u32,
    fma_error: u32,
    contracted: u32,
    sine: u32,
    far_sine: u32,
    logarithm: u32,
    converted: u32,
    uniform_of_32: u32,
    uniform_of_24: u32,
    // The results of comparisons and bit tests of `special`, one bit each.
    classes_of_special: u32,
    made_subnormal: u32,
    from_subnormal: u32,
    edge_sign: i32,
    // The state of a generator after all iterations of a loop.
    loop_state: u32,
}
