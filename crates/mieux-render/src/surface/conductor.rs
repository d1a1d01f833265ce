//! Metals: how much they reflect.

/// Reflectance of unpolarised light at the surface of a conductor of the complex index `n + i k`, relative to the medium
/// before it, for the cosine of incidence.
pub fn conductor_reflectance(cosine: f64, n: f64, k: f64) -> f64 {
    let c2 = (cosine * cosine).clamp(0.0, 1.0);
    let s2 = 1.0 - c2;
    let difference = n * n - k * k - s2;
    let root = (difference * difference + 4.0 * n * n * k * k).sqrt();
    let a = (0.5 * (root + difference)).max(0.0).sqrt();
    let (cosine, sum) = (c2.sqrt(), root + c2);
    let across = (sum - 2.0 * a * cosine) / (sum + 2.0 * a * cosine);
    let (sum, middle) = (root * c2 + s2 * s2, 2.0 * a * cosine * s2);
    let ratio = if sum + middle > 0.0 { (sum - middle) / (sum + middle) } else { 1.0 };
    0.5 * across * (1.0 + ratio)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::dielectric_reflectance;

    #[test]
    fn without_absorption_it_is_a_dielectric_and_silver_shines() {
        for i in 0..=50 {
            let cosine = f64::from(i) / 50.0;
            let (metal, glass) = (conductor_reflectance(cosine, 1.5, 0.0), dielectric_reflectance(cosine, 1.5));
            assert!((metal - glass).abs() < 1e-12, "{cosine} {metal} {glass}");
            assert!((0.0..=1.0).contains(&conductor_reflectance(cosine, 0.05, 3.9)));
        }
        // ((n - 1)^2 + k^2) / ((n + 1)^2 + k^2)
        let expected = (0.95f64.powi(2) + 3.9f64.powi(2)) / (1.05f64.powi(2) + 3.9f64.powi(2));
        assert!((conductor_reflectance(1.0, 0.05, 3.9) - expected).abs() < 1e-12);
    }
}
