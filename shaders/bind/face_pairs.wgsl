@group(0) @binding(31) var<storage, read> face_pairs: array<FacePair>;
