//@ implements filter_value when !filter.gauss & !filter.mitchell
// The tent (1 - |x|) (1 - |y|) around the middle of a pixel.
fn filter_value(at: vec2<f32>) -> f32 {
    let height = max(1.0 - abs(at), vec2<f32>(0.0));
    return height.x * height.y;
}
