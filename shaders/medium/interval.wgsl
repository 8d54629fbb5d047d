//@ use data/surface
// The part of a ray within a closed shape: the distances at which it begins and ends, 0 <= x < y.

// No part: the ray misses the shape or has it behind.
const NO_INTERVAL: vec2<f32> = vec2<f32>(1.0, 0.0);

// Of the line's crossings, the part in front of the origin. A NaN fails the comparison.
fn interval_ahead(crossings: vec2<f32>) -> vec2<f32> {
    let interval = vec2<f32>(max(crossings.x, 0.0), crossings.y);
    return select(NO_INTERVAL, interval, interval.x < interval.y);
}

// The distance at which the way inside has a length, if that is nearer than `limit`; else NO_HIT.
fn collision_within(inside: vec2<f32>, way: f32, limit: f32) -> f32 {
    let t = inside.x + way;
    return select(NO_HIT, t, t < min(inside.y, limit));
}

// The length of the way inside up to distance t.
fn way_within(inside: vec2<f32>, t: f32) -> f32 {
    return max(min(inside.y, t) - inside.x, 0.0);
}
