//@ use data/path
// No medium ends a flight.
fn end_of_flight(path: ptr<function, Path>, limit: f32, steps: ptr<function, u32>) -> f32 {
    return limit;
}
