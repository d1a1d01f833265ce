//! What happens where a ray meets a surface.

mod diffuse;
mod fresnel;
mod interior;

pub use diffuse::cosine_hemisphere;
pub use fresnel::{dielectric_reflectance, reflect, refract};
pub use interior::{Crossing, Interior};
