//! What one particle does to light, as it is tabulated and written down.

use std::f64::consts::PI;
use std::io::{self, Write};

use mieux_io::quantity::{Angles, format_length};
use mieux_io::table::{Table, exact};
use mieux_optics::Complex64;
use mieux_optics::mie::{Directions, Mueller, SphereScattering};
use serde::Serialize;

use super::{JobError, Mie, Particle};

/// What one particle does to light.
#[derive(Debug, Clone, PartialEq)]
pub struct MieSheet {
    /// What was asked.
    pub job: Mie,
    /// Outer radius, m.
    pub radius: f64,
    /// Cross sections and asymmetry.
    pub scattering: SphereScattering,
    /// Backscattering cross section as radars have it, m^2: 4 pi times the differential one.
    pub backscattering: f64,
    /// Over the angles that were asked for.
    pub directional: Option<Directional>,
}

/// What is seen from every angle, one value of each per angle.
#[derive(Debug, Clone, PartialEq)]
pub struct Directional {
    /// Scattering angles, degrees; 0 is forward.
    pub degrees: Vec<f64>,
    /// Amplitudes `[S1, S2]`.
    pub amplitudes: Vec<[Complex64; 2]>,
    /// Mueller matrix, normalised so that `p11` is the phase function, 1/sr.
    pub mueller: Vec<Mueller>,
}

impl Directional {
    fn column(&self, element: impl Fn(&Mueller) -> f64) -> Vec<f64> {
        self.mueller.iter().map(element).collect()
    }

    /// Degree of linear polarisation of what unpolarised light becomes, -1 to 1; NaN where nothing is scattered.
    pub fn polarisation(&self) -> Vec<f64> {
        // 0 - x is never the -0 that looks odd in a table.
        self.column(|m| 0.0 - m.p12 / m.p11)
    }
}

impl MieSheet {
    pub(super) fn compute(job: Mie, particle: &Particle) -> Result<Self, JobError> {
        let coefficients = particle.coefficients()?;
        let directional = |angles: Angles| {
            let directions = Directions::new(angles.cosines());
            Ok::<_, JobError>(Directional {
                degrees: angles.degrees().collect(),
                amplitudes: coefficients.amplitudes(&directions)?,
                mueller: coefficients.mueller(&directions)?,
            })
        };
        Ok(Self {
            radius: particle.radius(),
            scattering: coefficients.scattering()?,
            backscattering: coefficients.backscattering(),
            directional: job.angles.map(directional).transpose()?,
            job,
        })
    }

    /// A cross section over the geometric one of the whole particle.
    pub fn efficiency(&self, cross_section: f64) -> f64 {
        cross_section / (PI * self.radius * self.radius)
    }

    /// The particle and its surroundings in a line: "sphere of radius 500 nm, n = 1.5+0.01i, in n = 1.33 at 550 nm".
    pub fn title(&self) -> String {
        let Mie { radius, wavelength, host, particle, layers, .. } = &self.job;
        let length = |m: f64| format_length(m);
        let mut text = format!("sphere of radius {}, n = {particle}", length(radius.metres()));
        match layers.as_slice() {
            [] => {}
            [coat] => text += &format!(", coated to {}, n = {}", length(coat.radius.metres()), coat.index),
            layers => text += &format!(", in {} layers to {}", layers.len(), length(self.radius)),
        }
        text + &format!(", in n = {host} at {}", length(wavelength.metres()))
    }

    /// Names, units and values of what is one number.
    fn values(&self) -> Vec<(&'static str, &'static str, f64)> {
        let s = &self.scattering;
        let mut values = vec![
            ("c_ext", "m2", s.extinction),
            ("c_sca", "m2", s.scattering),
            ("c_abs", "m2", s.absorption),
            ("q_ext", "", self.efficiency(s.extinction)),
            ("q_sca", "", self.efficiency(s.scattering)),
            ("q_abs", "", self.efficiency(s.absorption)),
            ("q_back", "", self.efficiency(self.backscattering)),
            ("g", "", s.asymmetry),
            ("size_parameter", "", s.size_parameter.re),
        ];
        if s.size_parameter.im != 0.0 {
            values.push(("size_parameter_im", "", s.size_parameter.im));
        }
        values
    }

    fn head(&self) -> Table {
        let mut table = Table::new(self.title());
        for (i, layer) in self.job.layers.iter().enumerate() {
            table =
                table.with_metadata(format!("layer {}", i + 1), format!("to {}, n = {}", layer.radius, layer.index));
        }
        table.with_metadata("scattering_definition", self.job.definition.name())
    }

    /// Cross sections, efficiencies and asymmetry: one row.
    ///
    /// # Errors
    /// Never; the table checks the lengths of its columns.
    pub fn table(&self) -> Result<Table, JobError> {
        let mut table = self.head();
        for (name, unit, value) in self.values() {
            table = table.with_column(name, unit, vec![value])?;
        }
        Ok(table)
    }

    /// Phase function, polarisation and amplitudes, one row per angle, below the values of [`MieSheet::table`] as
    /// remarks; `None` when no angles were asked for.
    ///
    /// # Errors
    /// Never; the table checks the lengths of its columns.
    pub fn angle_table(&self) -> Result<Option<Table>, JobError> {
        let Some(d) = &self.directional else { return Ok(None) };
        let mut table = self.head();
        for (name, unit, value) in self.values() {
            let key = if unit.is_empty() { name.to_owned() } else { format!("{name}_{unit}") };
            table = table.with_metadata(key, exact(value));
        }
        table = table.with_metadata("of the Mueller matrix", "p11 = p22 = phase, p21 = p12, p44 = p33, p43 = -p34");
        let amplitude = |part: fn(&[Complex64; 2]) -> f64| d.amplitudes.iter().map(part).collect::<Vec<_>>();
        let columns = [
            ("angle", "deg", d.degrees.clone()),
            ("phase", "1/sr", d.column(|m| m.p11)),
            ("p12", "1/sr", d.column(|m| m.p12)),
            ("p33", "1/sr", d.column(|m| m.p33)),
            ("p34", "1/sr", d.column(|m| m.p34)),
            ("polarisation", "", d.polarisation()),
            ("s1_re", "", amplitude(|s| s[0].re)),
            ("s1_im", "", amplitude(|s| s[0].im)),
            ("s2_re", "", amplitude(|s| s[1].re)),
            ("s2_im", "", amplitude(|s| s[1].im)),
        ];
        for (name, unit, values) in columns {
            table = table.with_column(name, unit, values)?;
        }
        Ok(Some(table))
    }

    /// As JSON, a line per key. Complex numbers are `[re, im]`; the size parameter is a plain number in a lossless host.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn write_json(&self, out: impl Write) -> io::Result<()> {
        let (s, mut json) = (&self.scattering, Lines { out, first: true });
        json.entry("wavelength_m", &self.job.wavelength.metres())?;
        json.entry("radius_m", &self.radius)?;
        match s.size_parameter {
            Complex64 { re, im: 0.0 } => json.entry("size_parameter", &re)?,
            Complex64 { re, im } => json.entry("size_parameter", &[re, im])?,
        }
        let plain = |(name, ..): &(&str, &str, f64)| !name.starts_with("size_parameter");
        for (name, unit, value) in self.values().into_iter().filter(plain) {
            json.entry(if unit.is_empty() { name.to_owned() } else { format!("{name}_{unit}") }.as_str(), &value)?;
        }
        json.entry("scattering_definition", &self.job.definition)?;
        if let Some(d) = &self.directional {
            let amplitude = |i: usize| d.amplitudes.iter().map(|s| [s[i].re, s[i].im]).collect::<Vec<_>>();
            json.entry("angle_deg", &d.degrees)?;
            json.entry("s1", &amplitude(0))?;
            json.entry("s2", &amplitude(1))?;
            for name in ["phase_per_sr", "p11", "p22"] {
                json.entry(name, &d.column(|m| m.p11))?;
            }
            for name in ["p12", "p21"] {
                json.entry(name, &d.column(|m| m.p12))?;
            }
            for name in ["p33", "p44"] {
                json.entry(name, &d.column(|m| m.p33))?;
            }
            json.entry("p34", &d.column(|m| m.p34))?;
            json.entry("p43", &d.column(|m| 0.0 - m.p34))?;
        }
        json.end()
    }
}

/// Writes an object one key at a time, so that millions of angles need no second copy in memory.
struct Lines<W> {
    out: W,
    first: bool,
}

impl<W: Write> Lines<W> {
    fn entry(&mut self, key: &str, value: &impl Serialize) -> io::Result<()> {
        self.out.write_all(if self.first { b"{\n  " } else { b",\n  " })?;
        self.first = false;
        serde_json::to_writer(&mut self.out, key)?;
        self.out.write_all(b": ")?;
        Ok(serde_json::to_writer(&mut self.out, value)?)
    }

    fn end(mut self) -> io::Result<()> {
        self.out.write_all(b"\n}\n")
    }
}
