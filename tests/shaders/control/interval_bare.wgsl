// Wrong on purpose: what lies behind the origin counts.
const NO_INTERVAL: vec2<f32> = vec2<f32>(1.0, 0.0);

fn interval_ahead(crossings: vec2<f32>) -> vec2<f32> {
    return select(NO_INTERVAL, crossings, crossings.x < crossings.y);
}
