@group(0) @binding(11) var<${space_of_frames}> frames: array<Frame${size_of_frames}>;
