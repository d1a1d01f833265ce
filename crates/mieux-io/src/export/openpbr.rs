//! OpenPBR (`openpbr2024`) in MaterialX: `open_pbr_surface` with volumetric transmission.
//!
//! Its volume is given by colours in [0, 1] at a depth: extinction is `-ln(transmission_color)/depth`, scattering
//! `transmission_scatter/depth`, absorption what is left. So scattering fits where the depth is at most the shortest
//! mean free path between scatterings, which is the depth taken here. What is lost is digits: absorption is a difference
//! of two nearly equal numbers in single precision.

use super::channels::PATH;
use super::text::{head, identifier, rounded, single, singles, stem, unit, xml_comment};
use super::{ExportError, Loss, PhaseLoss, Subject, Written};
use crate::quantity::{format_length, significant};

pub fn write(subject: &Subject) -> Result<Written, ExportError> {
    let colours = subject.channels()?;
    let strongest = colours.sigma_s.iter().copied().fold(0.0, f64::max);
    let depth = rounded(1.0 / (strongest * subject.metres_per_unit));
    let depth_m = depth * subject.metres_per_unit;
    let scatter = colours.sigma_s.map(|s| rounded(s * depth_m).min(1.0));
    let colour: [f64; 3] =
        std::array::from_fn(|c| rounded((-(colours.sigma_s[c] + colours.sigma_a[c]) * depth_m).exp()));
    let (sigma_s, sigma_a) = coefficients(colour, scatter, depth_m);
    let held = colours.held(sigma_s, sigma_a, colours.asymmetry);
    let loss = Loss::new(subject, &held);
    let phase = PhaseLoss::henyey_greenstein(colours.asymmetry);
    let (wavelength, index) = subject.index();
    let remarks = vec![
        format!("boundary: smooth dielectric, n = {} at {}", significant(index, 6), format_length(wavelength)),
        format!(
            "transmission_depth is {}, the shortest mean free path between scatterings, as transmission_scatter holds at \
             most 1; absorption is a difference, of which single precision keeps what is said above",
            format_length(depth_m)
        ),
    ];
    let how = format!("colours in [0, 1] per transmission_depth in scene units, {PATH}; {}", unit(subject));
    let id = identifier(&subject.name);
    let comment = xml_comment(&head(subject, "OpenPBR 1.1 in MaterialX 1.39", &how, &loss, &phase, &remarks));
    let text = format!(
        "<?xml version=\"1.0\"?>\n{comment}<materialx version=\"1.39\" colorspace=\"lin_rec709\">\n\
         \x20 <open_pbr_surface name=\"{id}_surface\" type=\"surfaceshader\">\n\
         \x20   <input name=\"base_weight\" type=\"float\" value=\"1\" />\n\
         \x20   <input name=\"specular_roughness\" type=\"float\" value=\"0\" />\n\
         \x20   <input name=\"specular_ior\" type=\"float\" value=\"{}\" />\n\
         \x20   <input name=\"transmission_weight\" type=\"float\" value=\"1\" />\n\
         \x20   <input name=\"transmission_color\" type=\"color3\" value=\"{}\" />\n\
         \x20   <input name=\"transmission_depth\" type=\"float\" value=\"{}\" />\n\
         \x20   <input name=\"transmission_scatter\" type=\"color3\" value=\"{}\" />\n\
         \x20   <input name=\"transmission_scatter_anisotropy\" type=\"float\" value=\"{}\" />\n\
         \x20 </open_pbr_surface>\n\
         \x20 <surfacematerial name=\"{id}\" type=\"material\">\n\
         \x20   <input name=\"surfaceshader\" type=\"surfaceshader\" nodename=\"{id}_surface\" />\n\
         \x20 </surfacematerial>\n\
         </materialx>\n",
        single(index),
        singles(colour, ", "),
        single(depth),
        singles(scatter, ", "),
        single(colours.asymmetry),
    );
    let files = vec![(format!("{}.openpbr.mtlx", stem(&subject.name)), text.into_bytes())];
    Ok(Written { files, form: how, held, loss, phase, remarks })
}

/// Scattering and absorption (1/m) as the graph of OpenPBR makes them: where a difference is negative, all three channels
/// are raised by as much.
fn coefficients(colour: [f64; 3], scatter: [f64; 3], depth_m: f64) -> ([f64; 3], [f64; 3]) {
    let sigma_s = scatter.map(|s| s / depth_m);
    let sigma_a: [f64; 3] = std::array::from_fn(|c| -colour[c].ln() / depth_m - sigma_s[c]);
    let least = sigma_a.iter().copied().fold(0.0, f64::min);
    (sigma_s, sigma_a.map(|a| a - least))
}

#[cfg(test)]
mod tests {
    use super::super::testing::{assert_colours_recovered, emulsion, numbers_after, text_of};
    use super::super::{Format, write};
    use super::*;

    #[test]
    fn the_graph_of_openpbr_gives_the_coefficients_back() {
        for scale in [1.0, 0.01] {
            let subject = Subject { metres_per_unit: scale, ..emulsion() };
            let written = write(Format::OpenPbr, &subject).unwrap();
            let text = text_of(&written);
            let three = |name: &str| -> [f64; 3] {
                numbers_after(&text, &format!("name=\"{name}\" type=\"color3\" value=")).try_into().unwrap()
            };
            let (colour, scatter) = (three("transmission_color"), three("transmission_scatter"));
            assert!(colour.iter().chain(&scatter).all(|v| (0.0..=1.0).contains(v)), "{colour:?} {scatter:?}");
            let depth = numbers_after(&text, "name=\"transmission_depth\" type=\"float\" value=")[0];
            // Per scene unit as the graph computes, and from there to 1/m.
            let sigma_s: Vec<f64> = scatter.iter().map(|s| s / depth / scale).collect();
            let sigma_a: Vec<f64> = colour.iter().zip(&scatter).map(|(c, s)| (-c.ln() - s) / depth / scale).collect();
            let g = numbers_after(&text, "name=\"transmission_scatter_anisotropy\" type=\"float\" value=")[0];
            assert_colours_recovered(&subject, &written, &sigma_s, &sigma_a, g);
        }
    }
}
