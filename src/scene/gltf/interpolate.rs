//! Values between the keys of an animation, as glTF 2.0 has them in its appendix C, in f64.

use super::channels::Interpolation;

/// Where a time is among keys.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Position {
    /// At a key, or before the first or after the last one, where the value rests.
    At(usize),
    /// Between this key and the next one: the share of the way, and the seconds from one to the other.
    Between { key: usize, share: f64, seconds: f64 },
}

/// Where a time is among the times of keys.
///
/// # Errors
/// What is wrong with the times, in words.
pub fn locate(times: impl Iterator<Item = f64>, time: f64) -> Result<Position, String> {
    let (mut before, mut after, mut last) = (None, None, f64::NEG_INFINITY);
    for (key, at) in times.enumerate() {
        if !at.is_finite() || at < last {
            return Err(format!("expected finite times that increase, found {at} at key {key}"));
        }
        if at <= time {
            before = Some((key, at));
        } else if after.is_none() {
            after = Some(at);
        }
        last = at;
    }
    match (before, after) {
        (Some((key, at)), Some(next)) if at < time => {
            let seconds = next - at;
            Ok(Position::Between { key, share: (time - at) / seconds, seconds })
        }
        (Some((key, _)), _) => Ok(Position::At(key)),
        (None, Some(_)) => Ok(Position::At(0)),
        (None, None) => Err("expected at least one key".to_owned()),
    }
}

/// The value at a position among the keys. `element` reads the elements of the sampler's output: one for each key, or of a cubic spline three, the tangent towards
/// the key, its value, and the tangent from it. Rotations are unit quaternions.
pub fn value<E>(
    interpolation: Interpolation,
    position: Position,
    is_rotation: bool,
    element: impl Fn(usize) -> Result<Vec<f64>, E>,
) -> Result<Vec<f64>, E> {
    let is_cubic = interpolation == Interpolation::CubicSpline;
    let of_key = |key: usize| element(if is_cubic { 3 * key + 1 } else { key });
    let found = match (position, interpolation) {
        (Position::At(key), _) | (Position::Between { key, .. }, Interpolation::Step) => of_key(key)?,
        (Position::Between { key, share, .. }, Interpolation::Linear) => {
            let (from, to) = (of_key(key)?, of_key(key + 1)?);
            if is_rotation { slerp(from, to, share) } else { linear(&from, &to, share) }
        }
        (Position::Between { key, share, seconds }, Interpolation::CubicSpline) => {
            let [from, leaving] = [of_key(key)?, element(3 * key + 2)?];
            let [arriving, to] = [element(3 * key + 3)?, of_key(key + 1)?];
            hermite([&from, &leaving, &arriving, &to], share, seconds)
        }
    };
    Ok(if is_rotation { normalised(found) } else { found })
}

fn linear(from: &[f64], to: &[f64], share: f64) -> Vec<f64> {
    from.iter().zip(to).map(|(a, b)| (1.0 - share) * a + share * b).collect()
}

/// The rotation between two, along the shorter arc.
fn slerp(from: Vec<f64>, to: Vec<f64>, share: f64) -> Vec<f64> {
    let (from, to) = (normalised(from), normalised(to));
    let dot: f64 = from.iter().zip(&to).map(|(a, b)| a * b).sum();
    // A quaternion and its negative are one rotation.
    let sign = if dot < 0.0 { -1.0 } else { 1.0 };
    // The arc from the chord: the arccosine of the dot product is not exact where they are alike.
    let chord: f64 = from.iter().zip(&to).map(|(a, b)| (a - sign * b) * (a - sign * b)).sum::<f64>().sqrt();
    let angle = 2.0 * (0.5 * chord).min(1.0).asin();
    let sine = angle.sin();
    let (of_from, of_to) = match sine > 0.0 {
        true => (((1.0 - share) * angle).sin() / sine, (share * angle).sin() / sine),
        false => (1.0 - share, share),
    };
    from.iter().zip(&to).map(|(a, b)| of_from * a + sign * of_to * b).collect()
}

/// The cubic with these values and tangents at its ends. Tangents are per second.
fn hermite([from, leaving, arriving, to]: [&[f64]; 4], t: f64, seconds: f64) -> Vec<f64> {
    let (t2, t3) = (t * t, t * t * t);
    let of_from = 2.0 * t3 - 3.0 * t2 + 1.0;
    let of_leaving = seconds * (t3 - 2.0 * t2 + t);
    let of_to = 3.0 * t2 - 2.0 * t3;
    let of_arriving = seconds * (t3 - t2);
    let tangents = leaving.iter().zip(arriving).map(|(a, b)| of_leaving * a + of_arriving * b);
    from.iter().zip(to).zip(tangents).map(|((a, b), tangents)| of_from * a + of_to * b + tangents).collect()
}

/// A quaternion of length 1. One of length 0 stays as it is.
fn normalised(quaternion: Vec<f64>) -> Vec<f64> {
    let length = quaternion.iter().map(|x| x * x).sum::<f64>().sqrt();
    if length > 0.0 { quaternion.into_iter().map(|x| x / length).collect() } else { quaternion }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_1_SQRT_2, PI};

    use super::*;

    /// f64 values of magnitude 1 after some ten roundings of 1.1e-16.
    const ROUNDING: f64 = 4e-15;

    fn at(interpolation: Interpolation, times: &[f64], elements: &[Vec<f64>], time: f64) -> Vec<f64> {
        let position = locate(times.iter().copied(), time).unwrap();
        let element = |index| elements.get(index).cloned().ok_or(format!("there is no element {index}"));
        value(interpolation, position, elements[0].len() == 4, element).unwrap()
    }

    /// The largest difference of two values.
    fn difference(a: &[f64], b: &[f64]) -> f64 {
        assert_eq!(a.len(), b.len());
        a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    }

    /// Steps, lines and both ends, at times that f64 has exactly.
    #[test]
    fn values_step_or_follow_lines_and_rest_outside_of_the_keys() {
        let (times, values) = ([0.5, 1.0, 2.0], [vec![1.0, 0.0, 0.0], vec![2.0, 8.0, 0.0], vec![4.0, 0.0, -8.0]]);
        for (time, stepped, linear) in [
            (-3.0, [1.0, 0.0, 0.0], [1.0, 0.0, 0.0]),
            (0.5, [1.0, 0.0, 0.0], [1.0, 0.0, 0.0]),
            (0.75, [1.0, 0.0, 0.0], [1.5, 4.0, 0.0]),
            (1.0, [2.0, 8.0, 0.0], [2.0, 8.0, 0.0]),
            (1.25, [2.0, 8.0, 0.0], [2.5, 6.0, -2.0]),
            (2.0, [4.0, 0.0, -8.0], [4.0, 0.0, -8.0]),
            (f64::INFINITY, [4.0, 0.0, -8.0], [4.0, 0.0, -8.0]),
        ] {
            assert_eq!(at(Interpolation::Step, &times, &values, time), stepped, "{time}");
            assert_eq!(at(Interpolation::Linear, &times, &values, time), linear, "{time}");
        }
        // Another time, by a thousandth of a frame of 1/24 s, is another value.
        let moved = at(Interpolation::Linear, &times, &values, 0.75 + 1.0 / 24e3);
        assert!(difference(&moved, &[1.5, 4.0, 0.0]) > 1e-4);
    }

    /// Rotations about z by closed form: the angle is linear in time, on the shorter arc whichever sign the second key has.
    #[test]
    fn rotations_take_the_shorter_arc_at_a_constant_speed() {
        let about_z = |degrees: f64| {
            let (sin, cos) = (0.5 * degrees * PI / 180.0).sin_cos();
            vec![0.0, 0.0, sin, cos]
        };
        let negative = |q: Vec<f64>| q.iter().map(|x| -x).collect::<Vec<_>>();
        let same = |a: &[f64], b: &[f64]| difference(a, b).min(difference(a, &negative(b.to_vec())));
        for (from, to) in [(0.0, 90.0), (10.0, -150.0), (20.0, 20.0 + 1e-7), (-5.0, -5.0), (0.0, 179.0)] {
            for sign in [1.0, -1.0] {
                let to_key = if sign > 0.0 { about_z(to) } else { negative(about_z(to)) };
                for share in [0.0, 0.1, 0.5, 0.9] {
                    let found = at(Interpolation::Linear, &[0.0, 2.0], &[about_z(from), to_key.clone()], 2.0 * share);
                    let expected = about_z(from + share * (to - from));
                    // The angle of 179 degrees loses a digit: its sine is that of 1 degree at half the angle of the quaternions.
                    assert!(same(&found, &expected) < ROUNDING, "{from} {to} {sign} {share}: {found:?} {expected:?}");
                    // The longer arc, and the chord instead of the arc, are found.
                    if to == 90.0 && share == 0.1 {
                        let longer = about_z(from + share * (to - 360.0 - from));
                        let chord = normalised(linear(&about_z(from), &about_z(to), share));
                        assert!(same(&found, &longer) > 0.1 && same(&found, &chord) > 1e-3);
                    }
                }
            }
        }
        // A quarter turn about z, then about x: at its middle a turn about their bisector.
        let (z, x) = (vec![0.0, 0.0, FRAC_1_SQRT_2, FRAC_1_SQRT_2], vec![FRAC_1_SQRT_2, 0.0, 0.0, FRAC_1_SQRT_2]);
        let middle = at(Interpolation::Linear, &[0.0, 1.0], &[z, x], 0.5);
        // (x + z)/2 + 1 cos, normalised: the sum of both is (s, 0, s, 2s) with s = 1/√2.
        let length = 6.0_f64.sqrt();
        assert!(difference(&middle, &[1.0 / length, 0.0, 1.0 / length, 2.0 / length]) < ROUNDING);
    }

    /// The cubic x³ - 2x on keys at 1 and 3, whose tangents are its derivatives, is itself between them.
    #[test]
    fn cubic_splines_follow_cubics() {
        let (cubic, slope) = (|x: f64| x * x * x - 2.0 * x, |x: f64| 3.0 * x * x - 2.0);
        let one = |x: f64| vec![x; 3];
        // A tangent towards the first key, and one from the last, have no effect.
        let elements = [7.0, cubic(1.0), slope(1.0), slope(3.0), cubic(3.0), -7.0].map(one);
        for x in [0.0, 1.0, 1.25, 2.0, 2.75, 3.0, 9.0] {
            let found = at(Interpolation::CubicSpline, &[1.0, 3.0], &elements, x);
            // Values up to 21, so 21 times the rounding of 1.
            assert!(difference(&found, &one(cubic(x.clamp(1.0, 3.0)))) < 21.0 * ROUNDING, "{x}: {found:?}");
        }
        // Tangents that are not scaled by the segment's two seconds are found, and so are those in the other order.
        let half = [7.0, cubic(1.0), 0.5 * slope(1.0), 0.5 * slope(3.0), cubic(3.0), -7.0].map(one);
        let turned = [slope(1.0), cubic(1.0), 7.0, -7.0, cubic(3.0), slope(3.0)].map(one);
        for wrong in [half, turned] {
            let found = at(Interpolation::CubicSpline, &[1.0, 3.0], &wrong, 1.25);
            assert!(difference(&found, &one(cubic(1.25))) > 0.1, "{found:?}");
        }
        // Rotations are unit quaternions.
        let [rest, from, to] = [[0.0; 4], [0.0, 0.0, 0.0, 1.0], [1.0, 0.0, 0.0, 0.0]];
        let turn = [rest, from, rest, rest, to, rest].map(Vec::from);
        let found = at(Interpolation::CubicSpline, &[0.0, 1.0], &turn, 0.5);
        assert!(difference(&found, &[FRAC_1_SQRT_2, 0.0, 0.0, FRAC_1_SQRT_2]) < ROUNDING, "{found:?}");
    }

    #[test]
    fn keys_in_no_order_are_refused() {
        let found = |times: &[f64]| locate(times.iter().copied(), 0.5).unwrap_err();
        assert_eq!(found(&[]), "expected at least one key");
        assert_eq!(found(&[0.0, 2.0, 1.0]), "expected finite times that increase, found 1 at key 2");
        assert_eq!(found(&[0.0, f64::NAN]), "expected finite times that increase, found NaN at key 1");
        assert_eq!(found(&[0.0, f64::INFINITY]), "expected finite times that increase, found inf at key 1");
        // Two keys at one time are a jump: the later one counts from then on.
        assert_eq!(locate([0.0, 0.5, 0.5, 1.0].into_iter(), 0.5), Ok(Position::At(2)));
    }
}
