//! Writes grids as OpenVDB files, without compression (version 224).

use std::collections::{BTreeMap, BTreeSet};

/// A grid whose voxels in these boxes are active, from the first to the last, inclusive.
pub struct TestGrid<'a> {
    pub boxes: &'a [[[i32; 3]; 2]],
    pub background: f32,
    /// The rows of the matrix that takes (i, j, k, 1), as a row, to the space of the medium.
    pub map: [[f64; 4]; 4],
    pub value: &'a dyn Fn([i32; 3]) -> f32,
}

/// The map of voxels of this size, of which number 0 is at `origin`.
pub fn scaled(size: f64, origin: [f64; 3]) -> [[f64; 4]; 4] {
    let [x, y, z] = origin;
    [[size, 0.0, 0.0, 0.0], [0.0, size, 0.0, 0.0], [0.0, 0.0, size, 0.0], [x, y, z, 1.0]]
}

fn text(out: &mut Vec<u8>, text: &str) {
    out.extend((text.len() as u32).to_le_bytes());
    out.extend(text.bytes());
}

/// The corner of the block of `size` voxels along an edge around a voxel.
fn corner(voxel: [i32; 3], size: i32) -> [i32; 3] {
    voxel.map(|x| x.div_euclid(size) * size)
}

/// A mask with the bits of the children of this size at these corners, in a node of `across` children along an edge.
fn mask(children: &BTreeSet<[i32; 3]>, node: [i32; 3], size: i32, across: i32) -> Vec<u8> {
    let mut bits = vec![0; (across * across * across / 8) as usize];
    for child in children.iter().filter(|child| corner(**child, size * across) == node) {
        let [x, y, z] = [0, 1, 2].map(|axis| (child[axis] - node[axis]) / size);
        let bit = (x * across + y) * across + z;
        bits[(bit / 8) as usize] |= 1 << (bit % 8);
    }
    bits
}

/// The bytes of a file with these grids, by their names.
pub fn vdb(grids: &[(&str, TestGrid<'_>)]) -> Vec<u8> {
    let mut out = 0x5644_4220u64.to_le_bytes().to_vec();
    out.extend([224u32, 10, 0].iter().flat_map(|x| x.to_le_bytes()));
    out.push(1);
    out.extend([b'0'; 36]);
    out.extend(0u32.to_le_bytes());
    out.extend((grids.len() as u32).to_le_bytes());
    for (name, grid) in grids {
        [*name, "Tree_float_5_4_3", ""].iter().for_each(|own| text(&mut out, own));
        let offsets = out.len();
        out.extend([0; 24]);
        let begin = out.len() as u64;
        let blocks = add_grid(&mut out, grid);
        let ends = [begin, blocks, out.len() as u64];
        out[offsets..offsets + 24].copy_from_slice(&ends.map(u64::to_le_bytes).concat());
    }
    out
}

/// Adds a grid. Returns where its values begin.
fn add_grid(out: &mut Vec<u8>, grid: &TestGrid<'_>) -> u64 {
    let mut leaves = BTreeMap::<[i32; 3], (Vec<f32>, Vec<u8>)>::new();
    for [first, last] in grid.boxes {
        let along = |axis: usize| first[axis]..=last[axis];
        let voxels = along(0).flat_map(|x| along(1).flat_map(move |y| along(2).map(move |z| [x, y, z])));
        for voxel in voxels {
            let at = corner(voxel, 8);
            let (values, active) = leaves.entry(at).or_insert((vec![grid.background; 512], vec![0; 64]));
            let [x, y, z] = [0, 1, 2].map(|axis| voxel[axis] - at[axis]);
            let index = (x * 64 + y * 8 + z) as usize;
            values[index] = (grid.value)(voxel);
            active[index / 8] |= 1 << (index % 8);
        }
    }
    // No compression, no metadata, an affine map, one buffer.
    out.extend([0u32, 0].iter().flat_map(|x| x.to_le_bytes()));
    text(out, "AffineMap");
    out.extend(grid.map.as_flattened().iter().flat_map(|x| x.to_le_bytes()));
    out.extend(1u32.to_le_bytes());
    let corners = |size: i32| leaves.keys().map(|leaf| corner(*leaf, size)).collect::<BTreeSet<_>>();
    let (top, middle, low) = (corners(4096), corners(128), corners(8));
    let plain = |out: &mut Vec<u8>, count: usize| {
        // All values follow.
        out.push(6);
        out.extend((0..count).flat_map(|_| grid.background.to_le_bytes()));
    };
    out.extend(grid.background.to_le_bytes());
    out.extend([0, top.len() as u32].iter().flat_map(|x| x.to_le_bytes()));
    let nodes = |of: &BTreeSet<[i32; 3]>, parent: [i32; 3], size: i32| {
        let mut own: Vec<_> = of.iter().copied().filter(|node| corner(*node, size) == parent).collect();
        own.sort_unstable();
        own
    };
    let mut order = Vec::new();
    for root in &top {
        out.extend(root.iter().flat_map(|x| x.to_le_bytes()));
        out.extend(mask(&middle, *root, 128, 32));
        out.extend([0; 4096]);
        plain(out, 32768);
        for node in nodes(&middle, *root, 4096) {
            out.extend(mask(&low, node, 8, 16));
            out.extend([0; 512]);
            plain(out, 4096);
            for leaf in nodes(&low, node, 128) {
                out.extend(&leaves[&leaf].1);
                order.push(leaf);
            }
        }
    }
    let begin = out.len() as u64;
    for leaf in order {
        let (values, active) = &leaves[&leaf];
        out.extend(active);
        out.push(6);
        out.extend(values.iter().flat_map(|x| x.to_le_bytes()));
    }
    begin
}
