//! pbrt-v4 (`pbrt4`): a named homogeneous medium with `sigma_s` and `sigma_a` as spectra and one `g`, its smooth boundary,
//! and a small scene to see it in.

use super::text::{commented, head, nanometres, rounded, single, stem, unit};
use super::{ExportError, Held, Loss, PhaseLoss, Subject, Written};
use crate::quantity::{format_length, significant};

/// Vacuum wavelengths at which pbrt samples, nm: spectra are zero beyond their last value.
const SAMPLED: [f64; 2] = [360.0, 830.0];

pub fn write(subject: &Subject) -> Result<Written, ExportError> {
    let g = rounded(subject.mean_asymmetry());
    let held = Held {
        sigma_s: subject.scattering_for(g).into_iter().map(rounded).collect(),
        sigma_a: subject.sigma_a.iter().copied().map(rounded).collect(),
        asymmetry: vec![g; subject.grid.len()],
    };
    let loss = Loss::new(subject, &held);
    let phase = PhaseLoss::henyey_greenstein(g);
    let (wavelength, index) = subject.index();
    let remarks = vec![
        format!("boundary: smooth dielectric, n = {} at {}", significant(index, 6), format_length(wavelength)),
        "beyond the first and the last wavelength the spectra go on as constants".into(),
        "these are full coefficients with a g of their own; the presets of pbrt (Skin1, Wholemilk and so on) are reduced \
         ones, in 1/mm, for g = 0"
            .into(),
    ];
    let how = format!("sigma_s and sigma_a in 1/m times `scale`, over wavelength in nm; {}", unit(subject));
    let name = stem(&subject.name);
    let comment = commented(&head(subject, "pbrt-v4", &how, &loss, &phase, &remarks), "#");
    let medium = format!(
        "{comment}MakeNamedMedium \"{name}\"\n    \"string type\" \"homogeneous\"\n    \"spectrum sigma_s\" [ {} ]\n    \
         \"spectrum sigma_a\" [ {} ]\n    \"float g\" {}\n    \"float scale\" {}\n\n\
         MakeNamedMaterial \"{name}-boundary\"\n    \"string type\" \"dielectric\"\n    \"float eta\" {}\n",
        spectrum(subject, &held.sigma_s),
        spectrum(subject, &held.sigma_a),
        single(g),
        single(subject.metres_per_unit),
        single(index),
    );
    Ok(Written {
        files: vec![
            (format!("{name}.pbrt"), medium.into_bytes()),
            (format!("{name}-scene.pbrt"), scene(subject, &name).into_bytes()),
        ],
        form: how,
        held,
        loss,
        phase,
        remarks,
    })
}

/// Wavelengths and values by turns.
fn spectrum(subject: &Subject, values: &[f64]) -> String {
    let mut points: Vec<(f64, f64)> = subject.grid.iter().map(nanometres).zip(values.iter().copied()).collect();
    if let (Some(&(first, before)), Some(&(last, after))) = (points.first(), points.last()) {
        if first > SAMPLED[0] {
            points.insert(0, (SAMPLED[0], before));
        }
        if last < SAMPLED[1] {
            points.push((SAMPLED[1], after));
        }
    }
    points.into_iter().map(|(w, v)| format!("{} {}", single(w), single(v))).collect::<Vec<_>>().join("  ")
}

/// A ball of the material, four centimetres across, in even daylight.
fn scene(subject: &Subject, name: &str) -> String {
    let units = |metres: f64| single(metres / subject.metres_per_unit);
    format!(
        "# A ball of 4 cm across: pbrt {name}-scene.pbrt\n\
         LookAt 0 0 {}  0 0 0  0 1 0\n\
         Camera \"perspective\" \"float fov\" 30\n\
         Film \"rgb\" \"string filename\" \"{name}.exr\" \"integer xresolution\" 128 \"integer yresolution\" 128\n\
         Sampler \"independent\" \"integer pixelsamples\" 64\n\
         # Paths end by themselves: many scatterings are what is to be seen.\n\
         Integrator \"volpath\" \"integer maxdepth\" 100000\n\
         WorldBegin\n\
         Include \"{name}.pbrt\"\n\
         LightSource \"infinite\" \"spectrum L\" \"stdillum-D65\"\n\
         AttributeBegin\n    MediumInterface \"{name}\" \"\"\n    NamedMaterial \"{name}-boundary\"\n    \
         Shape \"sphere\" \"float radius\" {}\nAttributeEnd\n",
        units(0.1),
        units(0.02),
    )
}

#[cfg(test)]
mod tests {
    use super::super::testing::{assert_recovered, emulsion, text_of};
    use super::super::{Format, Kept, write};
    use super::*;

    fn numbers(text: &str, key: &str) -> Vec<f64> {
        let at = text.find(key).unwrap() + key.len();
        let words = text[at..].split_whitespace().skip_while(|w| *w == "[");
        words.map_while(|w| w.parse().ok()).collect()
    }

    #[test]
    fn what_pbrt_reads_is_the_material() {
        for kept in [Kept::Reduced, Kept::Scattering] {
            let subject = Subject { metres_per_unit: 0.01, kept, ..emulsion() };
            let written = write(Format::Pbrt, &subject).unwrap();
            let text = text_of(&written);
            let scale = numbers(&text, "\"float scale\"")[0];
            let inside = |key: &str| -> Vec<f64> {
                let all = numbers(&text, key);
                let values: Vec<f64> = all.chunks(2).map(|pair| pair[1] * scale / 0.01).collect();
                assert_eq!((all[0], all[all.len() - 2]), (360.0, 830.0));
                values[1..values.len() - 1].to_vec()
            };
            let (sigma_s, sigma_a) = (inside("\"spectrum sigma_s\""), inside("\"spectrum sigma_a\""));
            let g = numbers(&text, "\"float g\"")[0];
            assert_recovered(&subject, &written, &sigma_s, &sigma_a, &vec![g; sigma_s.len()]);
            let (reduced, scattering) = (written.loss.reduced.largest, written.loss.sigma_s.largest);
            match kept {
                Kept::Reduced => assert!(reduced < 1e-6 && scattering > 1e-3, "{reduced} {scattering}"),
                Kept::Scattering => assert!(scattering < 1e-6 && reduced > 1e-3, "{reduced} {scattering}"),
            }
        }
    }

    #[test]
    fn isotropic_scattering_is_reduced_scattering() {
        let subject = Subject { isotropic: true, kept: Kept::Scattering, ..emulsion() };
        let written = write(Format::Pbrt, &subject).unwrap();
        assert_eq!(numbers(&text_of(&written), "\"float g\""), [0.0]);
        assert!(written.loss.reduced.largest < 1e-6);
    }
}
