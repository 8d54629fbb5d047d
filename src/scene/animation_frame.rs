//! A frame of the animations of a glTF file, which is a time.

/// The frames of a second where none are given, as Blender has them.
pub const FPS: f64 = 24.0;

/// A frame of an animation. Frame 0 is at the time 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AnimationFrame {
    pub number: f64,
    /// The frames of a second.
    pub fps: f64,
}

impl AnimationFrame {
    /// Its time.
    pub fn seconds(&self) -> f64 {
        self.number / self.fps
    }
}
