// The interval of a ray inside a closed shape: the distances at which it begins and ends, 0 <= x < y.

// The empty interval: the ray misses the shape, or the shape is behind its origin.
const NO_INTERVAL: vec2<f32> = vec2<f32>(1.0, 0.0);

// Whether it is neither empty nor one that begins at WALK_CUT.
fn is_interval(inside: vec2<f32>) -> bool {
    return inside.x >= 0.0 && inside.x <= inside.y;
}

// The part of the interval between a line's two crossings that lies in front of the origin. A NaN fails the comparison.
fn interval_ahead(crossings: vec2<f32>) -> vec2<f32> {
    let interval = vec2<f32>(max(crossings.x, 0.0), crossings.y);
    return select(NO_INTERVAL, interval, interval.x < interval.y);
}

// The distance at which the ray has travelled the length `distance` inside the shape, if it does so before it leaves and
// before `limit`; NO_HIT otherwise.
fn collision_within(inside: vec2<f32>, distance: f32, limit: f32) -> f32 {
    let t = inside.x + distance;
    return select(NO_HIT, t, t < min(inside.y, limit));
}

// The length that the ray travels inside the shape up to distance t.
fn length_within(inside: vec2<f32>, t: f32) -> f32 {
    return max(min(inside.y, t) - inside.x, 0.0);
}
