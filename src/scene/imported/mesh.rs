//! Meshes that no file has as the scene needs them: shapes of Mitsuba as triangles, and meshes that are changed.

use std::f64::consts::TAU;

use glam::{DAffine3, DVec3, Vec2, Vec3};

use crate::scene::draft::{Draft, MOST_BYTES};
use crate::shape::mesh::Mesh;

/// The edges around a sphere, a disk or a cylinder, and half of them from pole to pole.
pub const AROUND: u32 = 128;

/// Adds a vertex with a normal and texture coordinates, v downwards as Mitsuba has it.
fn vertex(mesh: &mut Mesh, position: DVec3, normal: DVec3, u: f64, v: f64) -> u32 {
    mesh.positions.push(position);
    mesh.normals.push(normal.as_vec3());
    mesh.uvs.push(Vec2::new(u as f32, 1.0 - v as f32));
    mesh.positions.len() as u32 - 1
}

fn quad(mesh: &mut Mesh, [a, b, c, d]: [u32; 4]) {
    for triangle in [[a, b, c], [a, c, d]] {
        let spans = |i: u32, j: u32| mesh.positions.get(i as usize) != mesh.positions.get(j as usize);
        let [i, j, k] = triangle;
        if spans(i, j) && spans(j, k) && spans(k, i) {
            mesh.faces.push(mesh.triangles.len() as u32);
            mesh.triangles.push(triangle);
        }
    }
}

/// Adds the square from -1 to 1 in the plane of x and y, with u along x, or along y.
fn square(mesh: &mut Mesh, u_is_y: bool, place: &dyn Fn(DVec3) -> DVec3) {
    let normal = place(DVec3::Z) - place(DVec3::ZERO);
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    let corners = corners.map(|(x, y): (f64, f64)| {
        let (u, v) = if u_is_y { (y, x) } else { (x, y) };
        vertex(mesh, place(DVec3::new(x, y, 0.0)), normal, 0.5 + 0.5 * u, 0.5 + 0.5 * v)
    });
    quad(mesh, corners);
}

/// A grid of `AROUND` columns around the z axis, over this share of a turn: `at` gives position and normal for the direction and the row.
fn turned(rows: u32, turn: f64, at: &dyn Fn(DVec3, f64) -> (DVec3, DVec3)) -> Mesh {
    let mut mesh = Mesh::default();
    for row in 0..=rows {
        for column in 0..=AROUND {
            let (u, v) = (f64::from(column) / f64::from(AROUND), f64::from(row) / f64::from(rows));
            // The last column of a whole turn is where the first is, to the last bit.
            let (position, normal) = at(around((u * turn) % 1.0), v);
            vertex(&mut mesh, position, normal, u, v);
        }
    }
    let number = |row: u32, column: u32| row * (AROUND + 1) + column;
    for row in 0..rows {
        for column in 0..AROUND {
            let low = [number(row + 1, column), number(row + 1, column + 1)];
            quad(&mut mesh, [number(row, column), low[0], low[1], number(row, column + 1)]);
        }
    }
    mesh
}

pub fn rectangle() -> Mesh {
    let mut mesh = Mesh::default();
    square(&mut mesh, false, &|p| p);
    mesh
}

/// The cube from -1 to 1. Each face shows a whole image, with the axes that Mitsuba gives it.
pub fn cube() -> Mesh {
    let mut mesh = Mesh::default();
    for (x, y, z) in [
        (DVec3::X, DVec3::Z, DVec3::NEG_Y),
        (DVec3::NEG_Z, DVec3::NEG_X, DVec3::Y),
        (DVec3::NEG_Z, DVec3::Y, DVec3::X),
        (DVec3::Z, DVec3::Y, DVec3::NEG_X),
        (DVec3::X, DVec3::Y, DVec3::Z),
        (DVec3::X, DVec3::NEG_Y, DVec3::NEG_Z),
    ] {
        square(&mut mesh, true, &|p| z + p.x * x + p.y * y + p.z * z);
    }
    mesh
}

fn around(share: f64) -> DVec3 {
    let (sin, cos) = (TAU * share).sin_cos();
    DVec3::new(cos, sin, 0.0)
}

/// The part of a unit sphere between two shares of the way from the pole at +z to that at -z, over a share of a turn.
pub fn sphere(from: f64, to: f64, turn: f64) -> Mesh {
    turned(AROUND / 2, turn, &|around, v| {
        let (sin, cos) = match from + v * (to - from) {
            0.0 => (0.0, 1.0),
            1.0 => (0.0, -1.0),
            share => (0.5 * TAU * share).sin_cos(),
        };
        let p = sin * around + cos * DVec3::Z;
        (p, p)
    })
}

/// A disk of radius 1 with a hole, over a share of a turn, which is u. v is 1 on the inner edge and 0 on the outer one.
pub fn disk(hole: f64, turn: f64) -> Mesh {
    turned(1, turn, &|around, v| ((hole + v * (1.0 - hole)) * around, DVec3::Z))
}

/// The side of a cylinder of radius 1 from z = 0 to 1, over a share of a turn.
pub fn cylinder(turn: f64) -> Mesh {
    turned(1, turn, &|around, v| (around + (1.0 - v) * DVec3::Z, around))
}

/// A mesh with its transform in its vertices. Normals decide what is outside; without them the order of corners does.
pub fn transformed(mesh: &mut Mesh, by: &DAffine3) {
    for position in &mut mesh.positions {
        *position = by.transform_point3(*position);
    }
    if mesh.normals.is_empty() {
        return;
    }
    let of_normals = by.matrix3.inverse().transpose();
    for normal in &mut mesh.normals {
        *normal = (of_normals * normal.as_dvec3()).normalize_or(DVec3::Z).as_vec3();
    }
    if by.matrix3.determinant() < 0.0 {
        mesh.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
    }
}

/// Turns the inside out.
pub fn flip(mesh: &mut Mesh) {
    mesh.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
    mesh.normals.iter_mut().for_each(|normal| *normal = -*normal);
}

/// Transforms the texture coordinates, whose v is downwards as Mitsuba has it.
pub fn to_uv(mesh: &mut Mesh, by: &DAffine3) {
    if *by == DAffine3::IDENTITY {
        return;
    }
    for uv in &mut mesh.uvs {
        let seen = by.transform_point3(DVec3::new(f64::from(uv.x), 1.0 - f64::from(uv.y), 0.0));
        *uv = Vec2::new(seen.x as f32, (1.0 - seen.y) as f32);
    }
}

/// The mesh of those faces of another that are kept.
pub fn part(mesh: &Mesh, is_kept: impl Fn(u32) -> bool) -> Result<Mesh, String> {
    let mut draft = Draft::new(MOST_BYTES);
    draft.positions.clone_from(&mesh.positions);
    draft.normals.clone_from(&mesh.normals);
    draft.uvs.clone_from(&mesh.uvs);
    let triangles = mesh.triangles.iter().enumerate().filter(|(number, _)| is_kept(mesh.face(*number)));
    triangles.into_iter().try_for_each(|(_, triangle)| draft.face(triangle))?;
    draft.finish()
}

/// Gives a mesh without normals those of its faces, each by its angle at the vertex.
pub fn smooth(mesh: &mut Mesh) {
    let mut sums = vec![DVec3::ZERO; mesh.positions.len()];
    let at = |corner: u32| mesh.positions.get(corner as usize).copied().unwrap_or_default();
    for triangle in &mesh.triangles {
        let corners = triangle.map(at);
        for (number, own) in triangle.iter().enumerate() {
            let [p, q, r] = [corners[number], corners[(number + 1) % 3], corners[(number + 2) % 3]];
            let (a, b) = (q - p, r - p);
            let weight = a.angle_between(b);
            if let (Some(sum), true) = (sums.get_mut(*own as usize), weight.is_finite()) {
                *sum += weight * a.cross(b).normalize_or_zero();
            }
        }
    }
    mesh.normals = sums.into_iter().map(|sum| sum.normalize_or(DVec3::Z).as_vec3()).collect::<Vec<Vec3>>();
}
