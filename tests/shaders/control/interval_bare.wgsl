// Wrong on purpose: what lies behind the origin counts.
fn interval_ahead(crossings: vec2<f32>) -> vec2<f32> {
    return select(NO_INTERVAL, crossings, crossings.x < crossings.y);
}
