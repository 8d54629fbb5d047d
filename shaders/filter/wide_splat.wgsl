//@ implements splat_filter when !filter.box
//@ use choice/filter_value
// Wider filters: a pixel is drawn by the absolute value of its filter at the point.

// Filters reach at most two pixels from the middle of theirs.
const REACH: i32 = 2;

fn choose_pixel(at: vec2<f32>, u: vec2<f32>) -> TargetPixel {
    let column = i32(floor(at.x));
    let row = i32(floor(at.y));
    var target_pixel = TargetPixel(column, row, 0.0);
    var sum = 0.0;
    var rest = u.x;
    for (var i = 0; i < 25; i++) {
        let x = column - REACH + i % 5;
        let y = row - REACH + i / 5;
        let value = filter_value(at - vec2<f32>(f32(x) + 0.5, f32(y) + 0.5));
        sum += abs(value);
        let share = select(0.0, abs(value) / sum, value != 0.0);
        if rest < share {
            target_pixel = TargetPixel(x, y, sign(value));
            rest /= share;
        } else {
            rest = min((rest - share) / (1.0 - share), 1.0 - 0x1p-24f);
        }
    }
    target_pixel.weight *= sum;
    return target_pixel;
}
