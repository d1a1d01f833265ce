//! Shapes: bodies with an inside, and surfaces without.

use mieux_io::scene::description::{Description, Finish, Geometry, Shape};
use mieux_optics::spectrum::Sampled;
use mieux_render::DVec3;
use mieux_render::geometry::{Accelerator, Mesh, Ray, cuboid, disk, sphere};
use mieux_render::medium::Medium;
use mieux_render::scene::{Body, Finish as Rendered, Surface};

use super::spectra::{Kind, sampled};
use super::{JobError, fault, flat, media};

/// Facets of a sphere from pole to pole: its radius is off by four parts in a hundred thousand.
const RINGS: u32 = 256;
/// Corners of a disk.
const CORNERS: u32 = 720;

/// What stands in a scene.
pub(super) struct Solids {
    pub(super) bodies: Vec<Body>,
    pub(super) surfaces: Vec<Surface>,
}

/// A body before its medium is known: that may depend on what is around it.
struct Solid<'a> {
    shape: &'a Shape,
    mesh: Mesh,
    volume: f64,
}

pub(super) fn stage(
    description: &Description,
    materials: &[Medium],
    notes: &mut Vec<String>,
) -> Result<Solids, JobError> {
    let (mut solids, mut surfaces) = (Vec::new(), Vec::new());
    for shape in &description.shapes {
        let mesh = mesh(shape)?;
        match &shape.finish {
            Finish::Dielectric { .. } | Finish::Null => {
                if shape.emission.is_some() {
                    notes.push(format!("`{}` shines and lets light through: it does not shine here", shape.name));
                }
                if matches!(shape.finish, Finish::Null) && shape.interior.is_none() {
                    continue;
                }
                let volume = mesh.signed_volume();
                let mesh = if volume < 0.0 { mesh.turned() } else { mesh };
                solids.push(Solid { shape, mesh, volume: volume.abs() });
            }
            finish => surfaces.push(surface(shape, mesh, finish)?),
        }
    }
    Ok(Solids { bodies: bodies(solids, description, materials)?, surfaces })
}

/// Bodies, the larger first; the smaller wins unless the file says otherwise.
fn bodies(mut solids: Vec<Solid<'_>>, description: &Description, materials: &[Medium]) -> Result<Vec<Body>, JobError> {
    solids.sort_by(|a, b| b.volume.total_cmp(&a.volume));
    let mut bodies: Vec<Body> = Vec::with_capacity(solids.len());
    for (rank, solid) in solids.into_iter().enumerate() {
        let shape = solid.shape;
        let around = || -> Result<Sampled, JobError> {
            let inside = bodies.iter().rev().find(|body| contains(&body.mesh, corner(&solid.mesh)));
            inside.map_or_else(|| flat(1.0), |body| Ok(body.medium.n.clone()))
        };
        let (n, roughness) = match &shape.finish {
            Finish::Dielectric { interior, roughness, .. } => {
                (interior.as_ref().map(|n| sampled(n, Kind::Matter)).transpose()?, *roughness)
            }
            _ => (Some(around()?), 0.0),
        };
        let medium = match shape.interior {
            Some(index) => {
                let medium = description.media.get(index);
                let medium = medium.ok_or_else(|| fault(&shape.place, format!("there is no medium {index}")))?;
                media::stage(medium, materials, n)?
            }
            None => Medium::clear(flat(0.0)?, n.map_or_else(|| flat(1.5), Ok)?)
                .ok_or_else(|| fault(&shape.place, "its index is not finite"))?,
        };
        if !solid.mesh.is_closed() {
            return Err(fault(
                &shape.place,
                format!(
                    "`{}` has an inside, but its surface is not closed: every edge must be shared by two triangles",
                    shape.name
                ),
            ));
        }
        // Lower numbers win in files.
        let priority = shape.priority.map_or(rank as i32, |p| 1_000_000 - p);
        bodies.push(Body { name: shape.name.clone(), mesh: solid.mesh, medium, priority, roughness });
    }
    Ok(bodies)
}

fn corner(mesh: &Mesh) -> DVec3 {
    let v = mesh.vertices()[mesh.triangles()[0][0] as usize];
    DVec3::new(f64::from(v[0]), f64::from(v[1]), f64::from(v[2]))
}

/// Whether a closed mesh is around a point: a ray from it leaves once more than it enters.
fn contains(mesh: &Mesh, point: DVec3) -> bool {
    let accelerator = Accelerator::new([mesh]);
    let mut ray = Ray { origin: point, direction: DVec3::new(0.137, 0.2913, 0.9467).normalize() };
    let (mut exclude, mut depth) = (Accelerator::NONE, 0);
    while let Some(hit) = accelerator.intersect(&ray, f64::INFINITY, exclude) {
        depth += if accelerator.normals(&hit).0.dot(ray.direction) > 0.0 { 1 } else { -1 };
        (ray.origin, exclude) = (ray.at(hit.t), hit.triangle);
    }
    depth > 0
}

fn surface(shape: &Shape, mesh: Mesh, finish: &Finish) -> Result<Surface, JobError> {
    let matter = |spectrum: &_| sampled(spectrum, Kind::Matter);
    let finish = match finish {
        Finish::Diffuse { reflectance, two_sided } => {
            Rendered::Diffuse { reflectance: matter(reflectance)?, both_sides: *two_sided }
        }
        Finish::Conductor { n, k, roughness, .. } => {
            Rendered::Conductor { n: matter(n)?, k: matter(k)?, roughness: *roughness }
        }
        Finish::ThinDielectric { n } => Rendered::ThinPane { n: matter(n)? },
        Finish::Dielectric { .. } | Finish::Null => return Err(fault(&shape.place, "it has an inside")),
    };
    let emission = shape.emission.as_ref().map(|e| sampled(e, Kind::Light)).transpose()?;
    Ok(Surface { name: shape.name.clone(), mesh, finish, emission })
}

/// The triangles of a shape in the world's frame.
fn mesh(shape: &Shape) -> Result<Mesh, JobError> {
    let wrong = |e: mieux_render::geometry::GeometryError| fault(&shape.place, format!("`{}`: {e}", shape.name));
    if let Some(round) = placed_sphere(shape) {
        return round.map_err(wrong);
    }
    let own = match &shape.geometry {
        Geometry::Mesh(mesh) => Mesh::new(mesh.positions.clone(), mesh.triangles.clone(), mesh.normals.clone()),
        Geometry::Sphere { centre, radius } => sphere(*centre, *radius, RINGS),
        Geometry::Disk => disk([0.0; 3], 1.0, CORNERS),
        Geometry::Rectangle => rectangle(),
        Geometry::Cube => cuboid([-1.0; 3], [1.0; 3]),
        Geometry::Cylinder { .. } => {
            return Err(fault(&shape.place, format!("`{}`: cylinders are not supported; use a mesh", shape.name)));
        }
    }
    .map_err(wrong)?;
    let m = &shape.to_world;
    let placed = own.mapped(|p| m.point(p), |n| normal(shape, n)).map_err(wrong)?;
    let mirrored = m.determinant() < 0.0;
    Ok(if mirrored != shape.flip_normals { placed.turned() } else { placed })
}

/// A sphere that its frame leaves one, and whose inside is inside.
fn placed_sphere(shape: &Shape) -> Option<Result<Mesh, mieux_render::geometry::GeometryError>> {
    let Geometry::Sphere { centre, radius } = &shape.geometry else { return None };
    let m = &shape.to_world;
    let column = |j: usize| DVec3::new(m.0[0][j], m.0[1][j], m.0[2][j]);
    let (a, b, c) = (column(0), column(1), column(2));
    let scale = a.length();
    let alike = |x: f64, y: f64| (x - y).abs() <= 1e-9 * scale;
    let square = [a.dot(b), b.dot(c), c.dot(a)].iter().all(|d| d.abs() <= 1e-9 * scale * scale);
    let turned = (m.determinant() < 0.0) != shape.flip_normals;
    (square && alike(b.length(), scale) && alike(c.length(), scale) && !turned)
        .then(|| sphere(m.point(*centre), radius * scale, RINGS))
}

fn rectangle() -> Result<Mesh, mieux_render::geometry::GeometryError> {
    let corners = vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
    Mesh::new(corners, vec![[0, 1, 2], [0, 2, 3]], None)
}

/// Normals turn with the inverse transposed, which is the matrix of cofactors up to a factor.
fn normal(shape: &Shape, n: [f64; 3]) -> [f64; 3] {
    let m = &shape.to_world;
    let column = |j: usize| DVec3::new(m.0[0][j], m.0[1][j], m.0[2][j]);
    let (a, b, c) = (column(0), column(1), column(2));
    let turned = b.cross(c) * n[0] + c.cross(a) * n[1] + a.cross(b) * n[2];
    turned.to_array()
}
