//! What happens where a ray meets a surface.

mod conductor;
mod diffuse;
mod fresnel;
mod interior;
mod microfacet;

pub use conductor::conductor_reflectance;
pub use diffuse::cosine_hemisphere;
pub use fresnel::{dielectric_reflectance, reflect, refract};
pub use interior::{Crossing, Interior};
pub use microfacet::Microfacets;
