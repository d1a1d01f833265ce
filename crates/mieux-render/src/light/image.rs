//! Surroundings from a picture: latitude and longitude.

use std::f64::consts::{PI, TAU};

use glam::{DMat3, DVec3};
use mieux_optics::spectrum::Sampled;

use super::LightError;

/// Most channels of a picture of surroundings.
pub const MOST_CHANNELS: usize = 16;

/// Brightness over direction, in channels that each have a spectrum.
///
/// In its own frame the first row is about +z, the last about -z, and the middle of the picture's width looks to -x: a pixel
/// at the shares (u, v) of width and height holds the light from (sin(pi v) cos(2 pi u), sin(pi v) sin(2 pi u), cos(pi v)).
#[derive(Debug, Clone, PartialEq)]
pub struct SkyImage {
    size: [usize; 2],
    channels: Vec<Sampled>,
    data: Vec<f32>,
    /// From the scene's frame to the picture's.
    to_own: DMat3,
    /// Cumulative chances of the rows, and of the pixels within each row.
    rows: Vec<f64>,
    pixels: Vec<f64>,
}

impl SkyImage {
    /// Takes width and height, a spectrum per channel (at most [`MOST_CHANNELS`]), the values (channels fastest, rows from the
    /// top), and the matrix (rotation, perhaps mirrored) from the picture's own frame to the scene's.
    ///
    /// # Errors
    /// [`LightError::Image`] for sizes that do not agree, values that are not finite or negative, a picture that is black or a
    /// matrix that is no rotation.
    pub fn new(
        size: [usize; 2],
        channels: Vec<Sampled>,
        data: Vec<f32>,
        to_scene: [[f64; 3]; 3],
    ) -> Result<Self, LightError> {
        let refuse = |reason: String| Err(LightError::Image { reason });
        let [width, height] = size;
        let count = width.checked_mul(height).and_then(|n| n.checked_mul(channels.len()));
        if width == 0
            || height == 0
            || channels.is_empty()
            || channels.len() > MOST_CHANNELS
            || count != Some(data.len())
        {
            return refuse(format!(
                "{width} x {height} pixels of {} channels with {} values",
                channels.len(),
                data.len()
            ));
        }
        if let Some(i) = data.iter().position(|v| !(*v >= 0.0 && v.is_finite())) {
            let pixel = i / channels.len();
            return refuse(format!("the value of pixel ({}, {}) is {}", pixel % width, pixel / width, data[i]));
        }
        let matrix = DMat3::from_cols_array_2d(&to_scene);
        let off = matrix.transpose() * matrix - DMat3::IDENTITY;
        if off.to_cols_array().iter().any(|v| v.is_nan() || v.abs() >= 1e-6) {
            return refuse(format!("its matrix {to_scene:?} is no rotation"));
        }
        let mut image = Self {
            size,
            channels,
            data,
            to_own: matrix.transpose(),
            rows: vec![],
            pixels: Vec::with_capacity(width * height),
        };
        let mut sum = 0.0;
        for y in 0..height {
            let sine = (PI * (y as f64 + 0.5) / height as f64).sin();
            let mut row = 0.0;
            for x in 0..width {
                row += sine * image.around(x, y);
                image.pixels.push(row);
            }
            image.pixels[y * width..].iter_mut().for_each(|p| *p /= if row > 0.0 { row } else { 1.0 });
            sum += row;
            image.rows.push(sum);
        }
        if !(sum > 0.0 && sum.is_finite()) {
            return refuse("it is black".into());
        }
        image.rows.iter_mut().for_each(|r| *r /= sum);
        Ok(image)
    }

    /// The spectrum of each channel.
    pub fn channels(&self) -> &[Sampled] {
        &self.channels
    }

    fn brightness(&self, x: usize, y: usize) -> f64 {
        let n = self.channels.len();
        let at = (y * self.size[0] + x) * n;
        self.data[at..at + n].iter().map(|v| f64::from(*v)).sum::<f64>() / n as f64
    }

    /// Brightness of a pixel as interpolation smears it.
    fn around(&self, x: usize, y: usize) -> f64 {
        let [width, height] = self.size;
        let mut sum = 0.0;
        for (dy, wy) in [(0, 0.25), (1, 0.5), (2, 0.25)] {
            for (dx, wx) in [(width - 1, 0.25), (0, 0.5), (1, 0.25)] {
                sum += wx * wy * self.brightness((x + dx) % width, (y + dy).saturating_sub(1).min(height - 1));
            }
        }
        sum
    }

    /// Shares of width and height at which the light from a direction lies.
    fn place(&self, direction: DVec3) -> [f64; 2] {
        let own = self.to_own * direction;
        let u = own.y.atan2(own.x) / TAU;
        [u - u.floor(), own.z.clamp(-1.0, 1.0).acos() / PI]
    }

    /// The channels in a direction, linear between the middles of pixels; returns how many there are.
    pub(crate) fn values(&self, direction: DVec3, values: &mut [f64; MOST_CHANNELS]) -> usize {
        let ([width, height], [u, v], n) = (self.size, self.place(direction), self.channels.len());
        let (x, y) = (u * width as f64 - 0.5, (v * height as f64 - 0.5).clamp(0.0, (height - 1) as f64));
        let (left, top) = (x.floor(), y.floor());
        let (tx, ty) = (x - left, y - top);
        let columns =
            [(left as i64).rem_euclid(width as i64) as usize, (left as i64 + 1).rem_euclid(width as i64) as usize];
        let rows = [top as usize, (top as usize + 1).min(height - 1)];
        values[..n].fill(0.0);
        for (row, wy) in rows.into_iter().zip([1.0 - ty, ty]) {
            for (column, wx) in columns.into_iter().zip([1.0 - tx, tx]) {
                let at = (row * width + column) * n;
                for (value, channel) in values.iter_mut().zip(&self.data[at..at + n]) {
                    *value += wx * wy * f64::from(*channel);
                }
            }
        }
        n
    }

    /// Density of [`Self::sample`] per solid angle.
    pub(super) fn density(&self, direction: DVec3) -> f64 {
        let ([width, height], [u, v]) = (self.size, self.place(direction));
        let (x, y) = (((u * width as f64) as usize).min(width - 1), ((v * height as f64) as usize).min(height - 1));
        let step = |sums: &[f64], i: usize| sums[i] - if i > 0 { sums[i - 1] } else { 0.0 };
        let chance = step(&self.rows, y) * step(&self.pixels[y * width..(y + 1) * width], x);
        let sine = (PI * v).sin().max(1e-9);
        chance * (width * height) as f64 / (2.0 * PI * PI * sine)
    }

    /// A direction towards bright pixels from two uniform numbers.
    pub(super) fn sample(&self, [a, b]: [f64; 2]) -> DVec3 {
        let [width, height] = self.size;
        let (y, v) = pick(&self.rows, a);
        let (x, u) = pick(&self.pixels[y * width..(y + 1) * width], b);
        let theta = PI * (y as f64 + v) / height as f64;
        let (sin_phi, cos_phi) = (TAU * (x as f64 + u) / width as f64).sin_cos();
        let (sine, cosine) = theta.sin_cos();
        self.to_own.transpose() * DVec3::new(sine * cos_phi, sine * sin_phi, cosine)
    }
}

/// Where a uniform number falls among cumulative chances, and what is left of it.
fn pick(sums: &[f64], xi: f64) -> (usize, f64) {
    let i = sums.partition_point(|&s| s <= xi).min(sums.len() - 1);
    let before = if i > 0 { sums[i - 1] } else { 0.0 };
    let step = sums[i] - before;
    (i, if step > 0.0 { ((xi - before) / step).clamp(0.0, 1.0 - f64::EPSILON) } else { 0.5 })
}
