//! The picture as sums: any pixel can have any number of samples, and more can always be added.

use mieux_optics::spectrum::colour::luminance;

/// What can be wrong with the parts of a film.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum FilmError {
    /// The number of pixels is not width times height.
    #[error("{pixels} pixels cannot fill a film of {width} x {height}")]
    Size {
        /// Pixels across.
        width: u32,
        /// Pixels down.
        height: u32,
        /// Pixels given.
        pixels: usize,
    },
    /// A sum is not finite, a sum of squares negative, or sums without samples.
    #[error("pixel {index} holds impossible sums")]
    Sums {
        /// Which pixel, row by row.
        index: usize,
    },
    /// Not as many spectral sums as pixels and bins ask for, or one that is not finite, or a floor that is none.
    #[error("the film's spectra or its floor are impossible")]
    Spectra,
}

/// Samples whose mean counts as one when the error is judged. The first numbers of a path are spread evenly over every
/// four samples in a row (a Sobol sequence), so single samples are not independent, but groups nearly are: what is
/// left of the evenness between groups makes the true error smaller than the one given.
const GROUP: u64 = 4;

/// Sums over the samples of one pixel, in linear sRGB.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Pixel {
    /// Sum of each channel.
    pub sum: [f64; 3],
    /// Sum over complete groups of four samples of the square of each channel's mean in the group.
    pub sum_squares: [f64; 3],
    /// The same for the luminance.
    pub sum_squares_luminance: f64,
    /// Sum of each channel over the samples after the last complete group.
    pub open_group: [f64; 3],
    /// How many samples were taken.
    pub samples: u64,
}

impl Pixel {
    /// Adds a sample; the order of samples is part of the result's last bits.
    pub fn add(&mut self, rgb: [f64; 3]) {
        (0..3).for_each(|c| {
            self.sum[c] += rgb[c];
            self.open_group[c] += rgb[c];
        });
        self.samples += 1;
        if self.samples.is_multiple_of(GROUP) {
            let mean = self.open_group.map(|s| s / GROUP as f64);
            (0..3).for_each(|c| self.sum_squares[c] += mean[c] * mean[c]);
            self.sum_squares_luminance += luminance(mean).powi(2);
            self.open_group = [0.0; 3];
        }
    }

    /// Mean of each channel; 0 without samples.
    pub fn mean(&self) -> [f64; 3] {
        self.sum.map(|s| s / self.samples.max(1) as f64)
    }

    /// Variance of the mean of each channel; infinite below eight samples.
    pub fn variance_of_mean(&self) -> [f64; 3] {
        std::array::from_fn(|c| self.variance(self.sum[c] - self.open_group[c], self.sum_squares[c]))
    }

    /// Standard error of the luminance; infinite below eight samples.
    pub fn luminance_error(&self) -> f64 {
        self.variance(luminance(self.sum) - luminance(self.open_group), self.sum_squares_luminance).sqrt()
    }

    /// Variance of the mean over all samples, from the spread of the groups: `sum` over the samples in groups,
    /// `squares` over the groups.
    fn variance(&self, sum: f64, squares: f64) -> f64 {
        let groups = (self.samples / GROUP) as f64;
        if groups < 2.0 {
            return f64::INFINITY;
        }
        let sum = sum / GROUP as f64;
        let of_one_group = ((squares - sum * sum / groups) / (groups - 1.0)).max(0.0);
        of_one_group * GROUP as f64 / self.samples as f64
    }
}

/// Mean over pixels of the standard error of luminance over the luminance, or over `floor` where that is more.
pub(crate) fn relative_error<'a>(pixels: impl Iterator<Item = &'a Pixel>, floor: f64) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for pixel in pixels {
        let (error, scale) = (pixel.luminance_error(), luminance(pixel.mean()).max(floor));
        // What is black in a black picture has no relative error.
        sum += if error == 0.0 { 0.0 } else { error / scale };
        count += 1.0;
    }
    sum / f64::max(count, 1.0)
}

/// A picture under exposure: `width` x `height` pixels, row by row from the top left. Each pixel keeps its own samples,
/// so neighbouring errors are independent.
#[derive(Debug, Clone, PartialEq)]
pub struct Film {
    width: u32,
    height: u32,
    pixels: Vec<Pixel>,
    bins: usize,
    spectra: Vec<f64>,
    floor: Option<f64>,
}

impl Film {
    /// An unexposed film of `[width, height]` pixels.
    pub fn new([width, height]: [u32; 2]) -> Self {
        let pixels = vec![Pixel::default(); width as usize * height as usize];
        Self { width, height, pixels, bins: 0, spectra: Vec::new(), floor: None }
    }

    /// An unexposed film that also keeps the radiance in `bins` of wavelength.
    pub fn with_bins(resolution: [u32; 2], bins: usize) -> Self {
        let film = Self::new(resolution);
        Self { bins, spectra: vec![0.0; bins * film.pixels.len()], ..film }
    }

    /// A film from its parts, as [`Self::pixels`] gave them.
    ///
    /// # Errors
    /// [`FilmError`] for a wrong number of pixels or impossible sums.
    pub fn from_parts([width, height]: [u32; 2], pixels: Vec<Pixel>) -> Result<Self, FilmError> {
        if pixels.len() as u64 != u64::from(width) * u64::from(height) {
            return Err(FilmError::Size { width, height, pixels: pixels.len() });
        }
        for (index, pixel) in pixels.iter().enumerate() {
            let sums = pixel.sum_squares.iter().chain([&pixel.sum_squares_luminance]);
            let possible = pixel.sum.iter().chain(&pixel.open_group).all(|s| s.is_finite())
                && sums.clone().all(|s| s.is_finite() && *s >= 0.0)
                && (pixel.samples > 0 || *pixel == Pixel::default());
            if !possible {
                return Err(FilmError::Sums { index });
            }
        }
        Ok(Self { width, height, pixels, bins: 0, spectra: Vec::new(), floor: None })
    }

    /// The film with spectral sums, as [`Self::spectra`] gave them.
    ///
    /// # Errors
    /// [`FilmError::Spectra`] unless there are `bins` finite sums for every pixel.
    pub fn with_spectra(self, bins: usize, spectra: Vec<f64>) -> Result<Self, FilmError> {
        if Some(spectra.len()) != self.pixels.len().checked_mul(bins) || spectra.iter().any(|s| !s.is_finite()) {
            return Err(FilmError::Spectra);
        }
        Ok(Self { bins, spectra, ..self })
    }

    /// The film with the floor of its relative errors, as [`Self::floor`] gave it.
    ///
    /// # Errors
    /// [`FilmError::Spectra`] for a floor below 0 or not finite.
    pub fn with_floor(self, floor: Option<f64>) -> Result<Self, FilmError> {
        match floor {
            Some(f) if !(f >= 0.0 && f.is_finite()) => Err(FilmError::Spectra),
            _ => Ok(Self { floor, ..self }),
        }
    }

    /// Bins of wavelength, 0 without spectra: equal widths over the range of the observer.
    pub fn bins(&self) -> usize {
        self.bins
    }

    /// Sums over the samples of the mean radiance in each bin, pixel by pixel.
    pub fn spectra(&self) -> &[f64] {
        &self.spectra
    }

    /// The luminance below which errors count as relative to it, fixed once every pixel has been looked at: 1 % of the
    /// picture's mean at that time.
    pub fn floor(&self) -> Option<f64> {
        self.floor
    }

    /// Takes pixel (`x`, `y`) from a film of the same size.
    ///
    /// # Panics
    /// Where the films differ in size or the place lies outside.
    pub fn take(&mut self, other: &Self, x: u32, y: u32) {
        let at = y as usize * self.width as usize + x as usize;
        self.pixels[at] = other.pixels[at];
        self.spectrum_mut(x, y).copy_from_slice(other.spectrum(x, y));
    }

    pub(crate) fn set_floor(&mut self) {
        let mean = self.pixels.iter().map(|p| luminance(p.mean())).sum::<f64>() / self.pixels.len().max(1) as f64;
        self.floor = Some((0.01 * mean).max(0.0));
    }

    /// The sums of a pixel's spectrum.
    pub(crate) fn spectrum(&self, x: u32, y: u32) -> &[f64] {
        let at = (y as usize * self.width as usize + x as usize) * self.bins;
        &self.spectra[at..at + self.bins]
    }

    pub(crate) fn spectrum_mut(&mut self, x: u32, y: u32) -> &mut [f64] {
        let at = (y as usize * self.width as usize + x as usize) * self.bins;
        &mut self.spectra[at..at + self.bins]
    }

    /// Width and height in pixels.
    pub fn resolution(&self) -> [u32; 2] {
        [self.width, self.height]
    }

    /// The pixels, row by row from the top left.
    pub fn pixels(&self) -> &[Pixel] {
        &self.pixels
    }

    pub(crate) fn pixel_mut(&mut self, x: u32, y: u32) -> &mut Pixel {
        &mut self.pixels[y as usize * self.width as usize + x as usize]
    }

    /// The pixel in column `x` and row `y`; `None` outside.
    pub fn pixel(&self, x: u32, y: u32) -> Option<&Pixel> {
        (x < self.width).then(|| self.pixels.get(y as usize * self.width as usize + x as usize)).flatten()
    }

    /// Fewest and most samples in any pixel.
    pub fn samples(&self) -> (u64, u64) {
        self.pixels.iter().fold((u64::MAX, 0), |(low, high), p| (low.min(p.samples), high.max(p.samples)))
    }

    /// Samples in all pixels together.
    pub fn total_samples(&self) -> u64 {
        self.pixels.iter().map(|p| p.samples).sum()
    }

    /// Mean over pixels of the relative error of luminance: its standard error over the pixel's luminance, or over
    /// 1 % of the picture's mean luminance where the pixel is darker than that. Infinite if a pixel has fewer than
    /// eight samples, 0 for a black picture.
    pub fn noise(&self) -> f64 {
        if self.samples().0 < 2 * GROUP {
            return f64::INFINITY;
        }
        let count = self.pixels.len() as f64;
        let mean = self.pixels.iter().map(|p| luminance(p.mean())).sum::<f64>() / count;
        if mean <= 0.0 {
            return 0.0;
        }
        relative_error(self.pixels.iter(), 0.01 * mean)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mean_and_error_of_known_samples() {
        let mut film = Film::new([2, 1]);
        assert_eq!(film.noise(), f64::INFINITY);
        for value in [0.0, 1.0, 1.0, 2.0, 2.0, 3.0, 3.0, 4.0] {
            film.pixel_mut(0, 0).add([value; 3]);
            film.pixel_mut(1, 0).add([2.0; 3]);
        }
        let pixel = film.pixel(0, 0).unwrap();
        assert_eq!(pixel.mean(), [2.0; 3]);
        assert_eq!(pixel.variance_of_mean(), [1.0; 3]);
        assert!((pixel.luminance_error() - 1.0).abs() < 1e-12);
        assert!((film.noise() - 0.25).abs() < 1e-6);
        assert!(film.pixel(2, 0).is_none() && film.pixel(0, 1).is_none());
        assert_eq!(film.samples(), (8, 8));
        // A further sample, not yet in a group, only adds to the number of samples.
        film.pixel_mut(0, 0).add([2.0; 3]);
        assert!((film.pixels()[0].variance_of_mean()[0] - 8.0 / 9.0).abs() < 1e-12);
    }

    #[test]
    fn parts_make_the_same_film_or_an_error() {
        let mut film = Film::new([3, 2]);
        film.pixel_mut(2, 1).add([0.1, 0.2, 0.3]);
        let again = Film::from_parts(film.resolution(), film.pixels().to_vec()).unwrap();
        assert_eq!(film, again);
        assert!(matches!(Film::from_parts([3, 3], film.pixels().to_vec()), Err(FilmError::Size { .. })));
        let mut pixels = film.pixels().to_vec();
        pixels[0].sum[1] = f64::NAN;
        assert_eq!(Film::from_parts([3, 2], pixels), Err(FilmError::Sums { index: 0 }));
    }
}
