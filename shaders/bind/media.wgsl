@group(0) @binding(17) var<${space_of_media}> media: array<Medium${size_of_media}>;
