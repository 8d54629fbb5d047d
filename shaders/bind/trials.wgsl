@group(0) @binding(25) var<uniform> trials: array<Trial, 64>;
