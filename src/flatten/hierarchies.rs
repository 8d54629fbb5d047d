//! A cache of the meshes' hierarchies, for a scene that is flattened again.

use std::sync::Arc;

use glam::Vec3;

use super::cuts;
use super::pairs::{Pair, pairs};
use crate::bvh::{self, Bounds, Bvh, Quality};
use crate::data::{HIT_NOTHING, KIND_TRIANGLE, PRIMITIVE_BIT, primitive_code};
use crate::scene::{Mesh, Scene};

/// The hierarchy of a mesh, and the pairs of faces that are its leaves, in the order in which nodes name them.
pub struct Hierarchy {
    pub bvh: Bvh,
    pub pairs: Vec<Pair>,
}

impl Hierarchy {
    pub fn over(mesh: &Mesh, positions: &[Vec3], quality: Quality) -> Hierarchy {
        let pairs = pairs(&mesh.triangles, positions);
        let uncut = pairs.iter().map(|pair| pair.bounds(&mesh.triangles, positions)).zip(0..).collect();
        let boxes = match quality {
            Quality::Best => cuts::boxes(uncut, cuts::MOST_LEAVES, &pairs, &mesh.triangles, positions),
            _ => uncut,
        };
        let coded = boxes.into_iter().map(|(bounds, pair)| (bounds, primitive_code(KIND_TRIANGLE, pair)));
        let (bounds, codes): (Vec<Bounds>, Vec<u32>) = coded.unzip();
        let mut bvh = bvh::build(&bounds, &codes, quality);
        let mut in_order = Vec::with_capacity(pairs.len());
        let mut indices = vec![None; pairs.len()];
        let children = bvh.nodes.iter_mut().flat_map(|node| &mut node.children).chain([&mut bvh.root]);
        for code in children.filter(|code| **code != HIT_NOTHING && **code & PRIMITIVE_BIT != 0) {
            let pair = (*code ^ primitive_code(KIND_TRIANGLE, 0)) as usize;
            let index = *indices[pair].get_or_insert_with(|| {
                in_order.push(pairs[pair]);
                in_order.len() as u32 - 1
            });
            *code = primitive_code(KIND_TRIANGLE, index);
        }
        Hierarchy { bvh, pairs: in_order }
    }
}

#[derive(Default)]
pub struct Hierarchies {
    kept: Vec<Kept>,
    /// The number of hierarchies built so far.
    pub built: usize,
}

struct Kept {
    /// The mesh lives as long as its hierarchy, so that no other mesh gets its address.
    mesh: Arc<Mesh>,
    quality: Quality,
    hierarchy: Arc<Hierarchy>,
}

impl Hierarchies {
    /// Drops the hierarchies of meshes that the scene does not have.
    pub fn retain(&mut self, scene: &Scene) {
        self.kept.retain(|kept| scene.meshes.values().any(|mesh| Arc::ptr_eq(mesh, &kept.mesh)));
    }

    /// Returns the hierarchy of a mesh of the scene, and builds it if it is not in the cache.
    pub fn get_or_build(
        &mut self,
        scene: &Scene,
        mesh: &Mesh,
        quality: Quality,
        build: impl FnOnce() -> Hierarchy,
    ) -> Arc<Hierarchy> {
        let is_same = |other: &Arc<Mesh>| std::ptr::eq(Arc::as_ptr(other), mesh);
        if let Some(kept) = self.kept.iter().find(|kept| is_same(&kept.mesh) && kept.quality == quality) {
            return Arc::clone(&kept.hierarchy);
        }
        let hierarchy = Arc::new(build());
        self.built += 1;
        if let Some(mesh) = scene.meshes.values().find(|mesh| is_same(mesh)) {
            self.kept.push(Kept { mesh: Arc::clone(mesh), quality, hierarchy: Arc::clone(&hierarchy) });
        }
        hierarchy
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::flatten::{flatten, flatten_with};
    use crate::options::RenderOptions;

    /// A scene that is flattened again has the tables of the first time, and only new meshes and qualities are built.
    #[test]
    fn a_scene_that_is_flattened_again_has_its_hierarchies() {
        let load = || Scene::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/instances.ron")).unwrap();
        let (scene, mut hierarchies) = (load(), Hierarchies::default());
        let medium = RenderOptions::default();
        let best = RenderOptions { build: Quality::Best, ..RenderOptions::default() };
        let mut built = |scene: &Scene, options: &RenderOptions| {
            let again = flatten_with(scene, (16, 9), options, Some(&mut hierarchies)).unwrap();
            let first = flatten(scene, (16, 9), options).unwrap();
            assert!(again.nodes == first.nodes && again.meshes == first.meshes);
            assert_eq!(again.settings.root, first.settings.root);
            (hierarchies.built, hierarchies.kept.len())
        };
        let meshes = scene.meshes.len();
        assert!(meshes > 1);
        assert_eq!(built(&scene, &medium), (meshes, meshes));
        assert_eq!(built(&scene, &medium), (meshes, meshes));
        assert_eq!(built(&scene, &best), (2 * meshes, 2 * meshes));
        // A scene with other meshes finds none of its hierarchies, and the old ones are dropped.
        assert_eq!(built(&load(), &medium), (3 * meshes, meshes));
    }
}
