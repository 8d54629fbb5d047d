//! Warnings about the objects of a scene after their transforms: sizes that f32 does not resolve, surfaces that coincide, and light that is lost.
//!
//! The search runs while the hierarchies are built, in O(n log n). Of each kind it reports the worst case, and the number of the others.
//! Lengths are in scene units. Positions are relative to the camera, along the axes of render space.

mod behind;
mod coincident;
mod duplicates;
mod lost_lights;
mod search;
mod sizes;
mod within;

pub use search::Search;

/// The warnings, each with a location in the file, the number and a remedy.
pub fn warnings(search: &Search<'_>) -> Vec<String> {
    let mut found = sizes::search(search);
    found.push(duplicates::search(search));
    found.extend(coincident::search(search));
    // They follow rays to one point.
    if search.view.film.least_angle().is_some() {
        found.extend(lost_lights::search(search));
        found.push(behind::search(search));
    }
    found.into_iter().filter_map(|worst| worst.text(search.scene)).collect()
}
