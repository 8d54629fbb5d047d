// One line of the numerics probe's questions; the floats are chosen so that each surface_samples_light has one right value (src/gpu/probe.rs).
struct Trial {
    // Two floats whose sum and product both round, and their product as it is rounded.
    x: f32,
    y: f32,
    product: f32,
    // Within [-pi, pi].
    angle: f32,
    // Far outside it.
    far_angle: f32,
    // In [0.5, 1).
    log_of: f32,
    word: u32,
    // The bits of a NaN, an infinity or another number.
    special: u32,
    // The bits of a normal number whose 16th part is subnormal, and of a subnormal one.
    least: u32,
    subnormal: u32,
    // 0, and no compiler knows it.
    zero: u32,
    loops: u32,
    // Two points seen under nearly the same angle.
    p_x: f32,
    p_y: f32,
    q_x: f32,
    q_y: f32,
}

// What the driver makes of a trial: bits of floats where a name is a number's, so that nothing is flushed on the way out.
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
    // What comparisons and the tests by bits say of `special`, a bit each.
    said_of_special: u32,
    made_subnormal: u32,
    from_subnormal: u32,
    edge_sign: i32,
    // The state of a generator after all iterations of a loop.
    loop_state: u32,
}
