//@ relies on sine
// Angles to the last digits. WGSL promises 4096 ulp for atan2 and an absolute 7e-5 for acos, and drivers use that up; a
// solid angle that is a sum of such angles less pi has no digits at all where it is small.

// The angle in [0, pi] of the point (x, y), y >= 0: halved three times by tan(t/2) = y / (x + r), then the arc tangent's
// series, whose first term left out, t^11/11 with t <= tan(pi/16), is 9e-9 of the sum. Off by some 8 units of roundoff.
fn angle_of(y: f32, x: f32) -> f32 {
    let size = abs(x);
    let half = y / (size + length(vec2<f32>(x, y)));
    let quarter = half / (1.0 + sqrt(1.0 + half * half));
    let eighth = quarter / (1.0 + sqrt(1.0 + quarter * quarter));
    let s = eighth * eighth;
    let angle = 8.0 * eighth * (1.0 + s * (-1.0 / 3.0 + s * (0.2 + s * (-1.0 / 7.0 + s * (1.0 / 9.0)))));
    let acute = select(angle, 0.0, y == 0.0);
    return select(acute, 3.14159265358979 - acute, x < 0.0);
}

// Sine and 1 - cosine of an angle in [0, pi]; both with their digits where the angle is small, for which WGSL promises
// an absolute error only. The series' next terms are below 1e-9 of the sums.
fn sine_and_rise(angle: f32) -> vec2<f32> {
    let s = angle * angle;
    let series = vec2<f32>(
        angle * (1.0 - s * (1.0 / 6.0 - s * (1.0 / 120.0))),
        s * (0.5 - s * (1.0 / 24.0 - s * (1.0 / 720.0))),
    );
    let half = sin(0.5 * angle);
    return select(vec2<f32>(sin(angle), 2.0 * half * half), series, angle < 0.125);
}
