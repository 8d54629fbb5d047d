//! Planted errors, which a comparison of renders must find.

use gpu_rt::scene::Scene;

pub use super::kernel::Fault;
use super::kernel::Overlay;
use super::render::{Change, Request, Shot, render_with, same_expectation, worst_difference};

/// False alarms of a comparison of two images.
pub const ALPHA: f64 = 1e-6;

/// The kernels with all of these changes.
pub fn changed(changes: &[Fault<'_>]) -> Overlay {
    Overlay::new(changes)
}

/// Kernels that hold several errors, so that they are compiled once. An error is there in renders with its seed, and its text names that condition
/// `FAULT`. Beside the kernels are the seeds.
pub fn by_seed(changes: &[Fault<'_>], faults: &[Fault<'_>]) -> (Overlay, Vec<u32>) {
    let seeds: Vec<u32> = (1000..).take(faults.len()).collect();
    let texts: Vec<String> = faults
        .iter()
        .zip(&seeds)
        .map(|((_, _, by), seed)| {
            assert!(by.contains("FAULT"), "{by} does not say when it is there");
            by.replace("FAULT", &format!("(settings.seed == {seed}u)"))
        })
        .collect();
    let faults = faults.iter().zip(&texts).map(|((module, part, _), by)| (*module, *part, by.as_str()));
    (changed(&changes.iter().copied().chain(faults).collect::<Vec<_>>()), seeds)
}

/// Asserts that two renders have one expectation.
pub fn agree(name: &str, a: &Shot, b: &Shot, rounding: f64) {
    same_expectation(a, b, rounding, ALPHA).unwrap_or_else(|error| panic!("{name}: {error}"));
}

/// Asserts that two renders have not one expectation.
pub fn differ(name: &str, a: &Shot, b: &Shot, rounding: f64) {
    let worst = worst_difference(a, b, rounding);
    println!("{name}: {:.1} standard errors, {}", worst.z, worst.tile);
    assert!(same_expectation(a, b, rounding, ALPHA).is_err(), "{name} is not found");
}

/// Asserts that each of these errors changes the expectation of a scene.
pub fn are_found(name: &str, scene: &Scene, expected: &Shot, request: &Request, faults: &[Fault<'_>], rounding: f64) {
    let (overlay, seeds) = by_seed(&[], faults);
    let samples = request.samples.clone().unwrap_or(0..scene.render.samples);
    let mut faults = faults.iter();
    let change = Change { library: Some(&overlay), ..Change::default() };
    render_with(scene, request, seeds.into_iter().map(|seed| (seed, samples.clone())), &change, |shot| {
        let (module, _, by) = faults.next().expect("one for each seed");
        differ(&format!("{name}, {module}: {by}"), expected, &shot, rounding);
    });
}
