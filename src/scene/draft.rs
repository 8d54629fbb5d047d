//! A mesh while its file is being read, and the checks that turn it into a `Mesh`.

use glam::{DVec3, Vec2, Vec3, Vec4};

use crate::shape::mesh::{Mesh, UVS_IGNORED};

/// The memory that all meshes of a scene may take: 70 million triangles, with half as many vertices. A device that binds the most
/// bytes that wgpu grants, 2^31 - 1, cannot hold the hierarchy of more.
pub const MOST_BYTES: usize = 5 << 29;
/// A vertex with a normal and texture coordinates.
const VERTEX: usize = size_of::<DVec3>() + size_of::<Vec3>() + size_of::<Vec2>();
/// A triangle and the number of its face.
const TRIANGLE: usize = size_of::<[u32; 3]>() + size_of::<u32>();
/// The largest coordinate, as in the scene file.
pub const LARGEST: f64 = 1e100;

const WHITE: [u16; 3] = [u16::MAX; 3];

pub fn too_large() -> String {
    format!(
        "the meshes of the scene, and the images that it makes, take more than {} MiB, which is more than a device can hold",
        MOST_BYTES >> 20
    )
}

/// The contents of a file, unchecked.
#[derive(Default)]
pub struct Draft {
    /// The bytes that are left for vertices and triangles.
    pub room: usize,
    pub positions: Vec<DVec3>,
    /// One for every vertex, NaN if the file gives none; or empty.
    pub normals: Vec<Vec3>,
    /// One for every vertex, NaN if the file gives none; or empty.
    pub uvs: Vec<Vec2>,
    /// Further sets of texture coordinates, each with one for every vertex.
    further_uvs: Vec<Vec<Vec2>>,
    /// One for every vertex, or empty.
    tangents: Vec<Vec4>,
    /// One for every vertex that has been added, or empty. Where the file gives none it is white.
    pub colours: Vec<[u16; 3]>,
    /// One for every vertex that has been added, or empty. Where the file gives none it is 1.
    alphas: Vec<u16>,
    triangles: Vec<[u32; 3]>,
    /// The face that each triangle is part of.
    faces: Vec<u32>,
    /// The notes about the file.
    pub warnings: Vec<String>,
    /// Where the first normal or pair of texture coordinates is that is no finite numbers, and what was found there.
    pub bad_normal: Option<String>,
    pub bad_uv: Option<String>,
    /// The number of faces so far, including those without triangles.
    pub face_count: u32,
}

impl Draft {
    /// An empty draft, which may take `room` bytes.
    pub fn new(room: usize) -> Draft {
        Draft { room, ..Draft::default() }
    }

    /// The bytes that its vertices and triangles take.
    pub fn taken(&self) -> usize {
        VERTEX * self.positions.len() + TRIANGLE * self.triangles.len()
    }

    /// The number of vertices that there is room for.
    pub fn most_vertices(&self) -> usize {
        self.room / VERTEX
    }

    fn take_room(&mut self, bytes: usize) -> Result<(), String> {
        self.room = self.room.checked_sub(bytes).ok_or_else(too_large)?;
        Ok(())
    }

    /// Reserves memory for about this many triangles.
    pub fn reserve(&mut self, triangles: usize) {
        let triangles = triangles.min(self.room / TRIANGLE);
        self.triangles.reserve(triangles);
        self.faces.reserve(triangles);
    }

    /// Adds the file's next face as a fan of triangles around its first corner. A face with fewer than three corners
    /// has no triangles.
    pub fn face(&mut self, corners: &[u32]) -> Result<(), String> {
        let face = self.face_count;
        self.face_count = face.checked_add(1).ok_or("it has more than 2^32 - 1 faces")?;
        let Some((&first, rest)) = corners.split_first() else { return Ok(()) };
        self.take_room(TRIANGLE * rest.len().saturating_sub(1))?;
        for pair in rest.windows(2) {
            if let &[second, third] = pair {
                self.triangles.push([first, second, third]);
                self.faces.push(face);
            }
        }
        Ok(())
    }

    /// Adds a vertex and returns its number.
    pub fn vertex(&mut self, position: DVec3) -> Result<u32, String> {
        let number = self.positions.len();
        self.take_room(VERTEX)?;
        self.positions.push(position);
        Ok(number as u32)
    }

    /// Adds the colours of the vertices from `first` on; vertices before them without a colour are white.
    pub fn colour(&mut self, first: usize, colours: impl Iterator<Item = [u16; 3]>) -> Result<(), String> {
        self.take_room(size_of_val(&WHITE) * (self.positions.len() - self.colours.len()))?;
        self.colours.resize(first, WHITE);
        self.colours.extend(colours);
        Ok(())
    }

    /// Adds the alphas of the vertices from `first` on; vertices before them without one have 1.
    pub fn add_alphas(&mut self, first: usize, alphas: impl Iterator<Item = u16>) -> Result<(), String> {
        self.take_room(size_of::<u16>() * (self.positions.len() - self.alphas.len()))?;
        self.alphas.resize(first, u16::MAX);
        self.alphas.extend(alphas);
        Ok(())
    }

    /// Adds a further set of texture coordinates, with one for every vertex.
    pub fn add_uvs(&mut self, uvs: impl Iterator<Item = Vec2>) -> Result<(), String> {
        self.take_room(size_of::<Vec2>() * self.positions.len())?;
        let set: Vec<Vec2> = uvs.collect();
        let bad = set.iter().enumerate().find(|(_, uv)| !uv.is_finite());
        if let Some((vertex, uv)) = bad.filter(|_| self.bad_uv.is_none()) {
            self.bad_uv = Some(format!("expected finite texture coordinates, found {uv} at vertex {vertex}"));
        }
        self.further_uvs.push(set);
        Ok(())
    }

    /// Adds tangents for all vertices.
    pub fn add_tangents(&mut self, tangents: impl Iterator<Item = Vec4>) -> Result<(), String> {
        self.take_room(size_of::<Vec4>() * self.positions.len())?;
        self.tangents.extend(tangents);
        Ok(())
    }

    /// Whether any of its triangles has corners at three positions.
    pub fn has_area(&self) -> bool {
        self.triangles.iter().any(|triangle| self.spans_area(triangle))
    }

    fn spans_area(&self, triangle: &[u32; 3]) -> bool {
        let [a, b, c] = triangle.map(|corner| self.positions.get(corner as usize));
        a != b && b != c && c != a
    }

    /// Checks the faces and makes the mesh.
    pub fn finish(mut self) -> Result<Mesh, String> {
        if self.face_count == 0 {
            return Err("it has no faces: expected at least one of three corners or more".to_owned());
        }
        let mut warnings = std::mem::take(&mut self.warnings);
        self.check_faces()?;
        warnings.extend(self.leave_out_flat_faces()?);
        self.leave_out_unused_vertices();
        self.complete();
        let normals = self.take_normals();
        warnings.extend(normals.is_err().then(|| {
            let missing = || "some corners have no normal, or one of length 0".to_owned();
            let reason = self.bad_normal.take().unwrap_or_else(missing);
            format!("{reason}: all normals are ignored, and the mesh is flat-shaded")
        }));
        let uvs = self.take_uvs();
        warnings.extend(uvs.is_err().then(|| {
            let missing = || "some corners have no texture coordinates".to_owned();
            let reason = self.bad_uv.take().unwrap_or_else(missing);
            format!("{reason}: {UVS_IGNORED}")
        }));
        let tangents = self.take_tangents();
        warnings.extend(tangents.is_err().then(|| {
            "some corners have a TANGENT without a length or a sign: all are ignored, and MikkTSpace computes them"
                .to_owned()
        }));
        self.leave_out_white();
        Ok(Mesh {
            colours: self.colours,
            alphas: self.alphas,
            positions: self.positions,
            triangles: self.triangles,
            normals: normals.unwrap_or_default(),
            uvs: uvs.unwrap_or_default(),
            further_uvs: self.further_uvs,
            tangents: tangents.unwrap_or_default(),
            faces: self.faces,
            warnings,
        })
    }

    /// Checks that every corner is a vertex with finite coordinates.
    fn check_faces(&self) -> Result<(), String> {
        let count = self.positions.len();
        for (triangle, &face) in self.triangles.iter().zip(&self.faces) {
            for &corner in triangle {
                match self.positions.get(corner as usize) {
                    Some(p) if p.abs().cmple(DVec3::splat(LARGEST)).all() => {}
                    Some(DVec3 { x, y, z }) => {
                        return Err(format!(
                            "face {face} (counted from 0): expected finite coordinates of at most {LARGEST:e} in \
                             magnitude, found ({x}, {y}, {z}) at vertex {corner}"
                        ));
                    }
                    None => {
                        return Err(format!(
                            "face {face} (counted from 0): there is no vertex {corner}; the file has {count} \
                             vertices, counted from 0"
                        ));
                    }
                }
            }
        }
        Ok(())
    }

    /// Leaves out triangles with two corners at the same position. Returns a warning about faces that have no triangle left.
    fn leave_out_flat_faces(&mut self) -> Result<Option<String>, String> {
        let is_kept: Vec<bool> = self.triangles.iter().map(|triangle| self.spans_area(triangle)).collect();
        retain(&mut self.triangles, &is_kept);
        retain(&mut self.faces, &is_kept);
        if self.triangles.is_empty() {
            return Err(format!("none of its {} faces has an area", self.face_count));
        }
        let (mut left_out, mut first, mut next) = (0, None, 0);
        for face in self.faces.iter().copied().chain([self.face_count]) {
            if next < face {
                left_out += face - next;
                first = first.or(Some(next));
            }
            next = face.saturating_add(1);
        }
        Ok(first.map(|first| {
            let (have, were) = if left_out == 1 { ("has", "was") } else { ("have", "were") };
            format!(
                "{left_out} of {} faces {have} no area and {were} left out, the first is face {first} (counted from 0)",
                self.face_count
            )
        }))
    }

    /// Removes vertices that no triangle uses. They may have any coordinates, and would enlarge the bounds.
    fn leave_out_unused_vertices(&mut self) {
        let mut is_used = vec![false; self.positions.len()];
        for &corner in self.triangles.as_flattened() {
            if let Some(is_used) = is_used.get_mut(corner as usize) {
                *is_used = true;
            }
        }
        if is_used.iter().all(|&is_used| is_used) {
            return;
        }
        let mut count = 0;
        let new_number = |&is_used: &bool| {
            count += u32::from(is_used);
            count.saturating_sub(1)
        };
        let numbers: Vec<u32> = is_used.iter().map(new_number).collect();
        for corner in self.triangles.as_flattened_mut() {
            *corner = numbers.get(*corner as usize).copied().unwrap_or_default();
        }
        retain(&mut self.positions, &is_used);
        retain(&mut self.normals, &is_used);
        retain(&mut self.uvs, &is_used);
        self.further_uvs.iter_mut().for_each(|set| retain(set, &is_used));
        retain(&mut self.tangents, &is_used);
        retain(&mut self.colours, &is_used);
        retain(&mut self.alphas, &is_used);
    }

    /// Gives the last vertices what they lack and others have.
    fn complete(&mut self) {
        fn complete<T: Clone>(values: &mut Vec<T>, count: usize, missing: T) {
            values.resize(if values.is_empty() { 0 } else { count }, missing);
        }
        let count = self.positions.len();
        complete(&mut self.normals, count, Vec3::NAN);
        complete(&mut self.uvs, count, Vec2::NAN);
        self.further_uvs.iter_mut().for_each(|set| set.resize(count, Vec2::NAN));
        complete(&mut self.tangents, count, Vec4::NAN);
        complete(&mut self.colours, count, WHITE);
        complete(&mut self.alphas, count, u16::MAX);
    }

    /// The normals with length 1; none if the file has none; an error if some are missing or have no length.
    fn take_normals(&mut self) -> Result<Vec<Vec3>, ()> {
        let mut normals = std::mem::take(&mut self.normals);
        for normal in &mut normals {
            // In f64 the length of an f32 vector neither overflows nor underflows.
            let unit = normal.as_dvec3().normalize();
            if !unit.is_finite() {
                return Err(());
            }
            *normal = unit.as_vec3();
        }
        Ok(normals)
    }

    /// Exporters write white colours and alphas of 1, too.
    fn leave_out_white(&mut self) {
        if self.alphas.iter().all(|alpha| *alpha == u16::MAX) {
            self.alphas = Vec::new();
        }
        if self.colours.iter().all(|colour| *colour == WHITE) {
            self.colours = Vec::new();
        }
    }

    fn take_uvs(&mut self) -> Result<Vec<Vec2>, ()> {
        let uvs = std::mem::take(&mut self.uvs);
        let is_finite = |uv: &Vec2| uv.is_finite();
        if uvs.iter().chain(self.further_uvs.iter().flatten()).all(is_finite) {
            return Ok(uvs);
        }
        self.further_uvs = Vec::new();
        Err(())
    }

    /// The tangents with length 1; none if the file has none; an error if one has no length or no sign.
    fn take_tangents(&mut self) -> Result<Vec<Vec4>, ()> {
        let mut tangents = std::mem::take(&mut self.tangents);
        for tangent in &mut tangents {
            let unit = tangent.truncate().as_dvec3().normalize();
            if !unit.is_finite() || !tangent.w.is_finite() || tangent.w == 0.0 {
                return Err(());
            }
            *tangent = unit.as_vec3().extend(tangent.w.signum());
        }
        Ok(tangents)
    }
}

fn retain<T>(values: &mut Vec<T>, is_used: &[bool]) {
    let mut is_used = is_used.iter();
    values.retain(|_| is_used.next().copied().unwrap_or(false));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vertices_and_triangles_take_room() {
        let mut draft = Draft::new(3 * VERTEX + TRIANGLE);
        for _ in 0..3 {
            assert!(draft.vertex(DVec3::ZERO).is_ok());
        }
        assert_eq!(draft.face(&[0, 1]), Ok(()));
        assert_eq!(draft.face(&[0, 1, 2]), Ok(()));
        assert!(draft.face(&[0, 1, 2]).unwrap_err().contains("2560 MiB"));
        assert!(draft.vertex(DVec3::ZERO).is_err());
        let mut draft = Draft::new(2 * TRIANGLE);
        assert!(draft.face(&[0, 1, 2, 3, 4]).is_err());
    }
}
