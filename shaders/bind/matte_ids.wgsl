// The ids of each object's mattes, by the object's number.
@group(0) @binding(36) var<storage, read> matte_ids: array<array<u32, ${matte_kinds}>>;
