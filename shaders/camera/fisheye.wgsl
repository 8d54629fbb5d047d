//@ alternative round_lens when !projection.calibrated_fisheye
// Fisheye lenses. The distance of an angle t is, equidistant: t; equisolid: 2 sin(t/2); stereographic: 2 tan(t/2); orthographic: sin t.
const MODEL: u32 = ${fisheye}u;
const EQUIDISTANT: u32 = 0u;
const EQUISOLID: u32 = 1u;
const STEREOGRAPHIC: u32 = 2u;

// The distance of an angle, and its derivative.
fn lens_distance(angle: f32) -> vec2<f32> {
    let whole = circle_point(angle * TURNS_OF_RADIAN);
    let half = circle_point(0.5 * angle * TURNS_OF_RADIAN);
    if MODEL == EQUIDISTANT {
        return vec2<f32>(angle, 1.0);
    }
    if MODEL == EQUISOLID {
        return vec2<f32>(2.0 * half.y, half.x);
    }
    if MODEL == STEREOGRAPHIC {
        return vec2<f32>(2.0 * half.y / half.x, 1.0 / (half.x * half.x));
    }
    return whole.yx;
}

// The angle of a distance, or -1 where there is none.
fn lens_angle(r: f32) -> f32 {
    if MODEL == EQUIDISTANT {
        return select(-1.0, r, r <= 3.14159265);
    }
    if MODEL == EQUISOLID {
        return select(-1.0, 2.0 * angle_of(0.5 * r, sqrt(max(1.0 - 0.25 * r * r, 0.0))), r <= 2.0);
    }
    if MODEL == STEREOGRAPHIC {
        return 2.0 * angle_of(0.5 * r, 1.0);
    }
    return select(-1.0, angle_of(r, sqrt(max(1.0 - r * r, 0.0))), r <= 1.0);
}
