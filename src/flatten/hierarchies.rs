//! The hierarchies of meshes that a scene was flattened with. If it is flattened again, those of the same meshes are taken from here.

use std::sync::Arc;

use super::meshes::Hierarchy;
use crate::bvh::Quality;
use crate::scene::{Mesh, Scene};

#[derive(Default)]
pub struct Hierarchies {
    kept: Vec<Kept>,
    /// How many have been built since the start.
    pub built: usize,
}

struct Kept {
    /// The mesh is kept as long as its hierarchy, so that no other mesh gets its address.
    mesh: Arc<Mesh>,
    quality: Quality,
    hierarchy: Arc<Hierarchy>,
}

impl Hierarchies {
    /// Drops the hierarchies of meshes that the scene does not have.
    pub fn keep_those_of(&mut self, scene: &Scene) {
        self.kept.retain(|kept| scene.meshes.values().any(|mesh| Arc::ptr_eq(mesh, &kept.mesh)));
    }

    /// The hierarchy of a mesh of the scene. Builds it if it is not there.
    pub fn of(
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
    use crate::flatten::{flatten, flatten_again};
    use crate::options::RenderOptions;

    /// A scene that is flattened again has the tables of the first time, and only new meshes and qualities are built.
    #[test]
    fn a_scene_that_is_flattened_again_has_its_hierarchies() {
        let load = || Scene::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/instances.ron")).unwrap();
        let (scene, mut hierarchies) = (load(), Hierarchies::default());
        let medium = RenderOptions::default();
        let best = RenderOptions { build: Quality::Best, ..RenderOptions::default() };
        let mut built = |scene: &Scene, options: &RenderOptions| {
            let again = flatten_again(scene, (16, 9), options, &mut hierarchies).unwrap();
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
