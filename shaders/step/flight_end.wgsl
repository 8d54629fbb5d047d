//@ implements flight_end when medium & pane
//@ use step/flight
// The distance at which a medium scatters the path, or `limit` if none does before. It adds its steps. A flight that takes too many is cut
// where the path crosses media.
fn end_of_flight(path: ptr<function, Path>, limit: f32, steps: ptr<function, u32>) -> f32 {
    let nearest = nearest_collision(path, limit);
    *steps += nearest.steps;
    return select(nearest.t, limit, nearest.t == WALK_CUT);
}

//@ without
// No medium ends a flight.
fn end_of_flight(path: ptr<function, Path>, limit: f32, steps: ptr<function, u32>) -> f32 {
    return limit;
}
