// Angles, sines and cosines with full precision. WGSL only promises 4096 ulp for atan2, an absolute error of 7e-5 for acos, and
// of 2^-11 for sin and cos within [-pi, pi] (section 15.7.4), and drivers make use of that. With such angles, a small solid
// angle that is their sum minus pi has no correct digits, and points on a circle do not lie on it.

// The angle in [0, pi] of the point (x, y), y >= 0. It is halved three times by tan(t/2) = y / (x + r). The rest is the
// series of the arc tangent. The first term that it leaves out, t^11/11 with t <= tan(pi/16), is 9e-9 of the sum. The result
// is off by some 8 units of roundoff where quotients and roots are rounded correctly, and by 28 where they are as WGSL allows.
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

const TURNS_OF_RADIAN: f32 = 0.159154943;

// The point on the unit circle that lies `turns` turns from (1, 0) towards (0, 1), for fewer than 2^29 turns. Whole
// quarter turns are subtracted without rounding. The polynomials are minimax on the rest, [-pi/4, pi/4], with relative
// errors of 3.8e-9 and 1.2e-10 (own fit).
fn circle_point(turns: f32) -> vec2<f32> {
    let quarters = round(4.0 * turns);
    let angle = (4.0 * turns - quarters) * 1.57079633;
    let s = angle * angle;
    let sine = angle + angle * s * (-0.16666655 + s * (8.33216e-3 - s * 1.9515e-4));
    let cosine = 1.0 - s * (0.5 - s * (4.16666457e-2 - s * (1.38873163e-3 - s * 2.44331566e-5)));
    let quarter = i32(quarters);
    let within_half = select(vec2<f32>(cosine, sine), vec2<f32>(-sine, cosine), (quarter & 1) != 0);
    return select(within_half, -within_half, (quarter & 2) != 0);
}

// Sine and 1 - cosine of an angle in [0, pi], from half the angle. Both keep their precision for small angles.
fn sine_and_rise(angle: f32) -> vec2<f32> {
    let half = circle_point(angle * 0.0795774715);
    return 2.0 * half.y * half;
}
