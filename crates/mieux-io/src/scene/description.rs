//! What a scene is, as plain data: whichever file it came from, and whoever renders it.
//!
//! Everything is SI: metres, radians, W/m² and W/(m² sr) per metre of wavelength where a spectrum is radiometric in kind
//! (its absolute scale is the file's own), inverse metres for coefficients. The world's frame is right-handed. Mitsuba scenes
//! have no units of length; theirs are taken as metres.

use std::path::PathBuf;

use super::transform::Transform;
use crate::mesh::TriangleMesh;

/// A scene, whole: meshes, grids and images have been read.
#[derive(Debug, Clone, PartialEq)]
pub struct Description {
    /// What to call it in a heading.
    pub title: String,
    /// What it shows, in a sentence; may be empty.
    pub about: String,
    /// From where it is seen.
    pub camera: Camera,
    /// Materials by what they are made of, which [`MediumKind::Material`] and grid components refer to by index.
    pub materials: Vec<MaterialChoice>,
    /// Media, which shapes and the camera refer to by index.
    pub media: Vec<Medium>,
    /// Light that comes from no shape. Shapes that shine say so themselves.
    pub lights: Vec<Light>,
    /// What stands in the scene, in the file's order.
    pub shapes: Vec<Shape>,
    /// Things that were repaired or left out, in the order they were met: sentences to show.
    pub notes: Vec<String>,
}

/// Place in a text file, for messages.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Place {
    /// The file.
    pub file: String,
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
}

/// A pinhole camera.
#[derive(Debug, Clone, PartialEq)]
pub struct Camera {
    /// From the camera's frame to the world's. The camera looks along its +z, its +y is up in the picture, and its +x points
    /// to the **left** of the picture (so that the frame is right-handed, as in Mitsuba).
    pub to_world: Transform,
    /// Field of view, radians, in (0, π).
    pub fov: f64,
    /// Which extent of the full picture (not of the crop) the field of view is across.
    pub fov_axis: FovAxis,
    /// Where the optical axis meets the picture, from its middle, as shares of width and height; +x right, +y down.
    pub principal_point: [f64; 2],
    /// Width and height of the whole picture, pixels.
    pub size: [u32; 2],
    /// The part that is rendered: left, top, width, height, pixels.
    pub crop: Option<[u32; 4]>,
    /// How samples are spread over pixels.
    pub filter: ReconstructionFilter,
    /// Nearest and farthest distance along the axis that is seen, metres, where the file says so.
    pub clip: Option<[f64; 2]>,
    /// The medium the camera is in, an index into [`Description::media`]; `None` is empty space, or whatever the shapes around
    /// it say.
    pub medium: Option<usize>,
    /// Samples per pixel the file asks for.
    pub spp: Option<u32>,
    /// Seed the file asks for.
    pub seed: Option<u64>,
    /// Most collisions and surface hits of a path that the file asks for; `None` for no limit.
    pub max_depth: Option<u32>,
}

/// What a field of view is measured across.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum FovAxis {
    /// The width.
    #[default]
    X,
    /// The height.
    Y,
    /// The shorter of both.
    Smaller,
    /// The longer of both.
    Larger,
    /// From corner to corner.
    Diagonal,
}

/// A filter over the picture; widths are in pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ReconstructionFilter {
    /// A pixel is the mean over itself.
    Box,
    /// Falls linearly to zero at this distance.
    Tent {
        /// Where it ends.
        radius: f64,
    },
    /// A Gaussian of this standard deviation, cut and shifted to reach zero at four of them.
    Gaussian {
        /// Standard deviation.
        stddev: f64,
    },
    /// Mitchell and Netravali's cubic, radius 2.
    Mitchell {
        /// Their B.
        b: f64,
        /// Their C.
        c: f64,
    },
    /// The Catmull-Rom cubic, radius 2.
    CatmullRom,
    /// The windowed sinc.
    Lanczos {
        /// Number of lobes, the radius.
        lobes: u32,
    },
}

/// A quantity over wavelength.
#[derive(Debug, Clone, PartialEq)]
pub enum Spectrum {
    /// The same at all wavelengths.
    Constant(f64),
    /// Wavelength in vacuum in metres, ascending, and value; linear between, and zero outside for what shines (see `outside`).
    Sampled {
        /// Nodes.
        nodes: Vec<(f64, f64)>,
        /// What holds beyond the first and the last node.
        outside: Outside,
    },
    /// Linear sRGB, to be upsampled.
    Rgb {
        /// Red, green, blue.
        rgb: [f64; 3],
        /// What kind of quantity it is.
        kind: RgbKind,
    },
    /// Planck's radiance, W/(m² sr) per **nanometre** as in Mitsuba, times the scale.
    Blackbody {
        /// Kelvin.
        temperature: f64,
        /// Factor.
        scale: f64,
    },
    /// CIE D65, normalised as in Mitsuba: relative power divided by the CIE Y integral of D65 so that its luminance is 1.
    D65 {
        /// Factor.
        scale: f64,
    },
}

/// What holds beyond the nodes of a sampled spectrum.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outside {
    /// Nothing: Mitsuba's rule.
    Zero,
    /// The value at the nearest end: for refractive indices and coefficients of our own files.
    Nearest,
}

/// What an sRGB triple stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RgbKind {
    /// Between 0 and 1 at every wavelength.
    Reflectance,
    /// At least 0: coefficients, indices.
    Unbounded,
    /// Light: under it, white stays white (times D65).
    Illuminant,
}

/// Light from outside the shapes.
#[derive(Debug, Clone, PartialEq)]
pub enum Light {
    /// From everywhere far away.
    Environment {
        /// Radiance, the same in every direction.
        radiance: Spectrum,
    },
    /// From far away, by a picture of all directions.
    EnvironmentImage(EnvironmentImage),
    /// From one place, alike in all directions.
    Point {
        /// Metres.
        position: [f64; 3],
        /// W/sr.
        intensity: Spectrum,
        /// The medium the lamp is in, where the file says so.
        medium: Option<usize>,
    },
    /// From one place, in a cone.
    Spot {
        /// Metres.
        position: [f64; 3],
        /// Unit vector along which the beam goes.
        direction: [f64; 3],
        /// W/sr on the axis.
        intensity: Spectrum,
        /// No light beyond this angle from the axis, radians.
        cutoff: f64,
        /// Up to this angle the intensity is full; to `cutoff` it falls linearly with the angle. Radians.
        beam_width: f64,
        /// The medium the lamp is in, where the file says so.
        medium: Option<usize>,
    },
    /// From one direction far away.
    Directional {
        /// Unit vector along which the light goes.
        direction: [f64; 3],
        /// On a surface across it, W/m².
        irradiance: Spectrum,
    },
    /// The sky of the Earth by day. +z is up unless `to_world` turns it.
    Sky(Sky),
    /// The plain surroundings that materials are shown in when nothing else is said.
    Studio,
}

/// Radiance from every direction as a picture.
///
/// Columns go around, rows from the top to the bottom of the sphere. In its own frame +y is up and direction
/// `(sin φ sin θ, cos θ, -cos φ sin θ)` is seen at column `φ / 2π` and row `θ / π` as shares of width and height: the middle
/// of the picture is +z, as in Mitsuba.
#[derive(Debug, Clone, PartialEq)]
pub struct EnvironmentImage {
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Linear sRGB, rows from the top; an illuminant.
    pub rgb: Vec<[f32; 3]>,
    /// Factor on all values.
    pub scale: f64,
    /// From its frame to the world's; only its rotation counts.
    pub to_world: Transform,
    /// Where it was read from.
    pub path: PathBuf,
}

/// Sun and sky.
#[derive(Debug, Clone, PartialEq)]
pub struct Sky {
    /// Height of the sun over the horizon, radians.
    pub sun_elevation: f64,
    /// From the +x axis towards +y, radians.
    pub sun_azimuth: f64,
    /// How hazy it is.
    pub haze: Haze,
    /// Of the ground, for the light it sends back up.
    pub ground_albedo: Spectrum,
    /// Whether the disk of the sun is there too.
    pub sun: bool,
    /// Factor on all radiance.
    pub scale: f64,
    /// From the sky's frame, in which +z is up, to the world's.
    pub to_world: Transform,
}

/// How much aerosol is in the air.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Haze {
    /// Turbidity: 1 is pure air, 3 a clear day, 10 haze.
    Turbidity(f64),
    /// Vertical optical thickness of aerosol at 550 nm.
    AerosolOpticalThickness(f64),
}

/// Something in the scene.
#[derive(Debug, Clone, PartialEq)]
pub struct Shape {
    /// From the file, or by kind and number.
    pub name: String,
    /// What it looks like in its own frame.
    pub geometry: Geometry,
    /// From its frame to the world's.
    pub to_world: Transform,
    /// Whether normals are turned over, so that inside is outside.
    pub flip_normals: bool,
    /// What its surface does.
    pub finish: Finish,
    /// The medium behind the surface, an index into [`Description::media`]; `None` is empty space.
    pub interior: Option<usize>,
    /// The medium before the surface; `None` is whatever it stands in.
    pub exterior: Option<usize>,
    /// Whether the file says what is inside or outside at all: a surface that says nothing does not change the medium.
    pub changes_medium: bool,
    /// Radiance on the side of the normal.
    pub emission: Option<Spectrum>,
    /// Where solids overlap, the one with the lower number is there (nested dielectrics).
    pub priority: Option<i32>,
    /// Where the file says so.
    pub place: Place,
}

/// Forms, in their own frame.
#[derive(Debug, Clone, PartialEq)]
pub enum Geometry {
    /// Triangles.
    Mesh(TriangleMesh),
    /// About `centre`; normals point out.
    Sphere {
        /// Metres.
        centre: [f64; 3],
        /// Metres.
        radius: f64,
    },
    /// The unit disk in the plane z = 0; its normal is +z.
    Disk,
    /// The square from -1 to 1 in the plane z = 0; its normal is +z.
    Rectangle,
    /// The cube from -1 to 1 along every axis; normals point out.
    Cube,
    /// Round and open at its ends.
    Cylinder {
        /// Middle of one end.
        from: [f64; 3],
        /// Middle of the other.
        to: [f64; 3],
        /// Metres.
        radius: f64,
    },
}

/// What a surface does to light.
#[derive(Debug, Clone, PartialEq)]
pub enum Finish {
    /// Lambert's.
    Diffuse {
        /// Between 0 and 1.
        reflectance: Spectrum,
        /// Whether its back is the same; if not, the back is black.
        two_sided: bool,
    },
    /// A metal with index n + i k.
    Conductor {
        /// Real part.
        n: Spectrum,
        /// Imaginary part, at least 0.
        k: Spectrum,
        /// GGX width; 0 is a mirror.
        roughness: f64,
        /// Whether its back is the same; if not, the back is black.
        two_sided: bool,
    },
    /// A boundary between two refracting media.
    Dielectric {
        /// Refractive index behind the surface; `None` takes the interior medium's.
        interior: Option<Spectrum>,
        /// Refractive index before it; `None` takes the exterior medium's, or 1.
        exterior: Option<Spectrum>,
        /// GGX width; 0 is smooth.
        roughness: f64,
    },
    /// A thin pane in one surface: reflects and passes without bending.
    ThinDielectric {
        /// Index of the pane relative to what surrounds it.
        n: Spectrum,
    },
    /// Nothing: light passes as if no surface were there.
    Null,
}

/// A material by what it is made of.
#[derive(Debug, Clone, PartialEq)]
pub struct MaterialChoice {
    /// Built-in name or path of a recipe file; `None` is the material that was asked for.
    pub recipe: Option<String>,
    /// Inputs of the recipe and their values as written.
    pub set: Vec<(String, f64)>,
    /// Where the file says so.
    pub place: Place,
}

/// What fills space.
#[derive(Debug, Clone, PartialEq)]
pub struct Medium {
    /// From the file, or by number.
    pub name: String,
    /// What it is.
    pub kind: MediumKind,
    /// Where the file says so.
    pub place: Place,
}

/// What a medium is.
#[expect(clippy::large_enum_variant, reason = "a scene has few media")]
#[derive(Debug, Clone, PartialEq)]
pub enum MediumKind {
    /// Everywhere the same, from a recipe.
    Material {
        /// Index into [`Description::materials`].
        material: usize,
        /// Factor on all coefficients.
        density: f64,
    },
    /// Everywhere the same, by its numbers.
    Homogeneous(Optics),
    /// By its numbers at density 1, with a density in space; nothing outside the grid.
    Grid {
        /// At density 1 and, where `albedo` is a grid, with that albedo in place of its own.
        optics: Optics,
        /// Factor on extinction.
        density: Grid,
        /// Single scattering albedo in space.
        albedo: Option<Grid>,
        /// Factor on emission in space.
        emission: Option<Grid>,
    },
    /// Several materials with a density each in space: their coefficients add.
    Mixture(Vec<Component>),
}

/// One of several materials in a space.
#[derive(Debug, Clone, PartialEq)]
pub struct Component {
    /// Index into [`Description::materials`].
    pub material: usize,
    /// Factor on its coefficients.
    pub density: Grid,
}

/// Coefficients of a medium.
#[derive(Debug, Clone, PartialEq)]
pub struct Optics {
    /// How much it scatters and absorbs.
    pub coefficients: Coefficients,
    /// Factor on the coefficients.
    pub scale: f64,
    /// Refractive index, real part; `Constant(1.0)` unless given.
    pub index: Spectrum,
    /// Where scattered light goes.
    pub phase: Phase,
    /// Emitted radiance per unit of path, W/(m³ sr), where it shines.
    pub emission: Option<Spectrum>,
}

/// Two ways to say the same.
#[derive(Debug, Clone, PartialEq)]
pub enum Coefficients {
    /// Extinction in inverse metres and the share of it that scatters.
    ExtinctionAlbedo {
        /// 1/m.
        extinction: Spectrum,
        /// Between 0 and 1.
        albedo: Spectrum,
    },
    /// Both in inverse metres.
    ScatteringAbsorption {
        /// 1/m.
        scattering: Spectrum,
        /// 1/m.
        absorption: Spectrum,
    },
}

/// Values in a box.
#[derive(Debug, Clone, PartialEq)]
pub struct Grid {
    /// Numbers of cells along x, y, z.
    pub dims: [usize; 3],
    /// x fastest, then y, then z.
    pub values: Vec<f32>,
    /// From the unit cube `[0, 1]³`, which the cells fill, to the world.
    pub to_world: Transform,
    /// Between the cells' middles.
    pub filter: GridFilter,
}

/// How a grid is read between the middles of its cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum GridFilter {
    /// The cell's own value.
    Nearest,
    /// Linear along each axis between cell middles, and level beyond the outermost.
    #[default]
    Trilinear,
}

/// Phase functions. Cosines are of the angle between the directions before and after: 1 is straight on.
#[derive(Debug, Clone, PartialEq)]
pub enum Phase {
    /// Alike everywhere.
    Isotropic,
    /// Henyey and Greenstein's.
    HenyeyGreenstein {
        /// Mean cosine, in (-1, 1).
        g: f64,
    },
    /// Of things much smaller than the wavelength.
    Rayleigh,
    /// A table, linear in the cosine, which need not be normalised.
    Tabulated {
        /// Ascending from -1 to 1.
        cosines: Vec<f64>,
        /// At least 0, as many.
        values: Vec<f64>,
    },
    /// A table for each of several wavelengths; linear between them, the nearest outside.
    TabulatedSpectral {
        /// Metres, ascending.
        wavelengths: Vec<f64>,
        /// Ascending from -1 to 1.
        cosines: Vec<f64>,
        /// At least 0; for each wavelength one for each cosine.
        values: Vec<Vec<f64>>,
    },
    /// One or the other.
    Blend {
        /// Share of `b`.
        weight: BlendWeight,
        /// With weight 0.
        a: Box<Phase>,
        /// With weight 1.
        b: Box<Phase>,
    },
}

/// Share of the second of two phase functions.
#[derive(Debug, Clone, PartialEq)]
pub enum BlendWeight {
    /// The same everywhere, 0 to 1.
    Constant(f64),
    /// In space.
    Grid(Grid),
}
