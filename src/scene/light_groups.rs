//! The groups of lights, which `--aov lights` writes apart.

use std::collections::BTreeSet;

use super::findings::Findings;
use super::model::Scene;
use crate::aov::{BACKGROUND, REST};
use crate::source::ValuePath;

/// The most groups beside that of the background.
const MOST: usize = 8;
/// The most bytes of a name: channels of EXR files are named by it.
const LONGEST: usize = 200;

/// Calls `visitor` with every group that a material or a light without size names, and the path of what names it.
fn visit(scene: &Scene, visitor: &mut dyn FnMut(&ValuePath, &str)) {
    let materials = scene.top();
    let materials = materials.field("materials");
    for (name, material) in &scene.materials {
        if let Some(group) = material.light_group() {
            visitor(&materials.key(name).variant(material.name()), group);
        }
    }
    scene.visit_objects(&mut |at, object| {
        if let Some(group) = object.light_group() {
            visitor(at, group);
        }
    });
}

/// The names of the groups in order, that of the background too.
pub fn names(scene: &Scene) -> Vec<String> {
    let mut names = BTreeSet::from([BACKGROUND.to_string()]);
    visit(scene, &mut |_, name| {
        names.insert(name.to_string());
    });
    names.into_iter().collect()
}

/// Refuses names that no layer can have, and too many groups.
pub(super) fn check(scene: &Scene, findings: &mut Findings) {
    let mut known = BTreeSet::from([BACKGROUND.to_string()]);
    visit(scene, &mut |at, name| {
        let at = at.field("light_group");
        let is_name = !name.is_empty() && name.len() <= LONGEST && name != REST;
        if !is_name || name.contains(|c: char| c.is_control() || ".,:=\"".contains(c)) {
            let expected = format!("a name of 1 to {LONGEST} bytes other than \"{REST}\", without any of . , : =");
            findings.refuse(at.unexpected(expected));
        } else if known.insert(name.to_string()) && known.len() == MOST + 2 {
            let message = format!("expected at most {MOST} light groups beside \"{BACKGROUND}\", found one more");
            findings.refuse(at.error(message));
        }
    });
}
