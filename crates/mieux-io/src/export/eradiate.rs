//! Eradiate (`eradiate`): particle properties in its format Aer-Core v2, as NetCDF. Everything is held: extinction, albedo
//! and phase function at every wavelength.
//!
//! The format has as many angles at every wavelength: those of the finest table stand for all.

use mieux_optics::phase::{PhaseFunction, Tabulated};

use super::text::{head, nanometres, stem};
use super::{ExportError, Format, Held, Loss, PhaseLoss, Phases, Subject, Written};
use crate::netcdf::{NetCdf, Variable};

/// Angles where no phase function is a table.
const PLAIN_ANGLES: usize = 721;

pub fn write(subject: &Subject) -> Result<Written, ExportError> {
    let Phases::All(phases) = &subject.phases else {
        return Err(ExportError::NoPhase { format: Format::Eradiate.name() });
    };
    let functions = phases.functions();
    let angles = finest(functions);
    let mut values = Vec::with_capacity(functions.len() * angles.len());
    let mut asymmetry = Vec::with_capacity(functions.len());
    let mut worst = 0.0f64;
    for function in functions {
        let at: Vec<f64> = angles.iter().map(|theta| function.value(theta.cos())).collect();
        let table = Tabulated::new(angles.clone(), at)?;
        worst = worst.max((table.asymmetry() - function.asymmetry()).abs() / (1.0 - function.asymmetry()));
        asymmetry.push(table.asymmetry());
        // The integral over the cosine is to be 2, not that over the sphere 1.
        let forward = table.bins().first().map(|ends| ends[0]);
        let normalised = forward.into_iter().chain(table.bins().iter().map(|ends| ends[1]));
        values.extend(normalised.map(|p| 4.0 * std::f64::consts::PI * p));
    }
    let sigma_t: Vec<f64> = subject.sigma_s.iter().zip(&subject.sigma_a).map(|(s, a)| s + a).collect();
    let albedo: Vec<f64> =
        subject.sigma_s.iter().zip(&sigma_t).map(|(s, t)| if *t > 0.0 { s / t } else { 0.0 }).collect();
    let held = Held {
        sigma_s: sigma_t.iter().zip(&albedo).map(|(t, w)| t * w).collect(),
        sigma_a: sigma_t.iter().zip(&albedo).map(|(t, w)| t * (1.0 - w)).collect(),
        asymmetry,
    };
    let loss = Loss::new(subject, &held);
    let phase = PhaseLoss {
        form: format!("its values at {} angles at every wavelength", angles.len()),
        total_variation: None,
        one_minus_asymmetry: Some(worst),
    };
    let remarks = vec![
        "ext is the extinction of the material as it is, at its own concentration; only element 11 of the phase matrix is \
         given"
            .into(),
        "Eradiate counts in SI whatever the scene is, so the scale is of no consequence here".into(),
    ];
    let how = "extinction in 1/m, single-scattering albedo, phase function (integral over the cosine 2)".to_owned();
    let lines = head(subject, "Eradiate (Aer-Core v2)", &how, &loss, &phase, &remarks);
    let bytes = data_set(subject, &lines, &angles, (sigma_t, albedo, values))?.to_bytes()?;
    let files = vec![(format!("{}.nc", stem(&subject.name)), bytes)];
    Ok(Written { files, form: how, held, loss, phase, remarks })
}

/// The angles (rad) of the table that has most.
fn finest(functions: &[PhaseFunction]) -> Vec<f64> {
    let tables = functions.iter().filter_map(|function| match function {
        PhaseFunction::Tabulated(table) => Some(table.grid().as_slice()),
        _ => None,
    });
    match tables.max_by_key(|angles| angles.len()) {
        Some(angles) => angles.to_vec(),
        None => {
            let step = std::f64::consts::PI / (PLAIN_ANGLES - 1) as f64;
            (0..PLAIN_ANGLES).map(|i| step * i as f64).collect()
        }
    }
}

type Values = (Vec<f64>, Vec<f64>, Vec<f64>);

fn data_set(
    subject: &Subject,
    lines: &[String],
    angles: &[f64],
    (ext, ssa, phase): Values,
) -> Result<NetCdf, ExportError> {
    let (count, wavelengths) = (angles.len(), subject.grid.len());
    // From backward to forward, as cosines rise.
    let repeated = |f: &dyn Fn(f64) -> f64| -> Vec<f64> {
        (0..wavelengths).flat_map(|_| angles.iter().rev().map(|theta| f(*theta))).collect()
    };
    let phase: Vec<f64> = phase.chunks(count).flat_map(|row| row.iter().rev().copied()).collect();
    let variables = [
        Variable::new("w", &["w"], subject.grid.iter().map(nanometres).collect())
            .with("standard_name", "wavelength")
            .with("long_name", "wavelength")
            .with("units", "nm"),
        Variable::words("phamat", &["phamat"], &["11"])
            .with("standard_name", "component")
            .with("long_name", "phase matrix component"),
        Variable::new("theta", &["w", "iangle"], repeated(&f64::to_degrees))
            .with("standard_name", "scattering_angle")
            .with("long_name", "scattering angle")
            .with("units", "deg"),
        Variable::new("mu", &["w", "iangle"], repeated(&f64::cos))
            .with("standard_name", "cos_scattering_angle")
            .with("long_name", "scattering angle cosine")
            .with("units", "dimensionless"),
        Variable::new("ext", &["w"], ext)
            .with("standard_name", "extinction_coefficient")
            .with("long_name", "extinction coefficient")
            .with("units", "1 / m"),
        Variable::new("ssa", &["w"], ssa)
            .with("standard_name", "single_scattering_albedo")
            .with("long_name", "single-scattering albedo")
            .with("units", "dimensionless"),
        Variable::new("phase", &["phamat", "w", "iangle"], phase)
            .with("standard_name", "phase_matrix")
            .with("long_name", "phase matrix")
            .with("units", "1 / sr")
            .with("comment", "integral normalized to 2"),
    ];
    let mut set = NetCdf::new()
        .with_attribute("Conventions", "CF-1.10")
        .with_attribute("title", subject.title.as_str())
        .with_attribute("source", subject.source.as_str())
        .with_attribute("comment", lines.join("\n"))
        .with_dimension("w", wavelengths)
        .with_dimension("phamat", 1)
        .with_dimension("iangle", count);
    for variable in variables {
        set = set.with_variable(variable)?;
    }
    Ok(set)
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use mieux_optics::phase::SpectralPhase;
    use netcdf3::FileReader;

    use super::super::testing::{assert_recovered, emulsion, lobe};
    use super::super::write;
    use super::*;

    #[test]
    fn everything_is_read_back() {
        let mut subject = emulsion();
        let functions: Vec<PhaseFunction> = subject.asymmetry.iter().map(|g| lobe(*g)).collect();
        subject.asymmetry = functions.iter().map(PhaseFunction::asymmetry).collect();
        subject.phases = Phases::All(SpectralPhase::new(subject.grid.clone(), functions).unwrap());
        let written = write(Format::Eradiate, &subject).unwrap();
        let bytes = written.files[0].1.clone();
        let mut reader = FileReader::open_seek_read("memory", Box::new(Cursor::new(bytes))).unwrap();
        let mut read = |name: &str| reader.read_var_f64(name).unwrap();
        let (w, mu, ext, ssa, phase) = (read("w"), read("mu"), read("ext"), read("ssa"), read("phase"));
        let count = mu.len() / w.len();
        let mut asymmetry = Vec::new();
        for (mu, p) in mu.chunks(count).zip(phase.chunks(count)) {
            let (mut total, mut first) = (0.0, 0.0);
            for i in 1..count {
                let (a, b) = (mu[i - 1], mu[i]);
                assert!(b > a);
                total += 0.5 * (b - a) * (p[i - 1] + p[i]);
                first += (b - a) * (p[i - 1] * (2.0 * a + b) + p[i] * (a + 2.0 * b)) / 6.0;
            }
            assert!((total - 2.0).abs() < 1e-9, "{total}");
            asymmetry.push(first / total);
        }
        let sigma_s: Vec<f64> = ext.iter().zip(&ssa).map(|(t, w)| t * w).collect();
        let sigma_a: Vec<f64> = ext.iter().zip(&ssa).map(|(t, w)| t * (1.0 - w)).collect();
        assert_recovered(&subject, &written, &sigma_s, &sigma_a, &asymmetry);
        assert!(written.loss.reduced.largest < 2e-3 && written.loss.sigma_a.largest < 1e-9);
        assert!(matches!(write(Format::Eradiate, &emulsion()), Err(ExportError::NoPhase { .. })));
    }
}
