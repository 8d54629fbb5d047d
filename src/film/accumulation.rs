//! A film with what is known of its samples.

use super::Film;
use crate::samples::Samples;

/// A film that renders add samples to.
#[derive(Clone, Debug)]
pub struct Accumulation {
    pub film: Film,
    /// The samples that each pixel has. While a render goes on, those of the last complete snapshot.
    pub samples: Samples,
    /// How often a render until an error has compared the error with the requested one.
    pub checks: u32,
    /// The devices and drivers that have rendered it.
    pub devices: Vec<(String, String)>,
}

impl Accumulation {
    /// A film without samples.
    pub fn empty(film: Film) -> Accumulation {
        Accumulation { film, samples: Samples::default(), checks: 0, devices: Vec::new() }
    }

    /// Removes all samples.
    pub fn clear(&mut self) {
        self.film.clear();
        (self.samples, self.checks) = (Samples::default(), 0);
    }
}

/// Adds devices to those that are known, each once.
pub fn add_devices(known: &mut Vec<(String, String)>, more: &[(String, String)]) {
    for device in more {
        if !known.contains(device) {
            known.push(device.clone());
        }
    }
}
