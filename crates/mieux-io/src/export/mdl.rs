//! NVIDIA's Material Definition Language 1.7 (`mdl17`): `df::anisotropic_vdf` in a `material_volume`, coefficients in 1/m.

use super::channels::PATH;
use super::text::{commented, head, identifier, single, unit};
use super::{ExportError, Loss, PhaseLoss, Subject, Written};
use crate::quantity::{format_length, significant};

pub fn write(subject: &Subject) -> Result<Written, ExportError> {
    let colours = subject.channels()?;
    let held = colours.rounded();
    let loss = Loss::new(subject, &held);
    let phase = PhaseLoss::henyey_greenstein(colours.asymmetry);
    let (wavelength, index) = subject.index();
    let remarks = vec![
        format!("boundary: smooth dielectric, n = {} at {}", significant(index, 6), format_length(wavelength)),
        "coefficients are in 1/m whatever the scene unit is: the renderer knows how many metres a scene unit has"
            .into(),
    ];
    let how = format!("absorption_coefficient and scattering_coefficient in 1/m, {PATH}; {}", unit(subject));
    let id = identifier(&subject.name);
    let comment = commented(&head(subject, "MDL 1.7", &how, &loss, &phase, &remarks), "//");
    let float = |value: f64| {
        let text = single(value);
        if text.contains(['.', 'e']) { format!("{text}f") } else { format!("{text}.0f") }
    };
    let colour = |values: [f64; 3]| values.map(float).join(", ");
    let text = format!(
        "mdl 1.7;\n\n{comment}\nimport ::df::*;\n\n\
         export material {id}()\n= material(\n\
         \x20   ior: color({}),\n\
         \x20   surface: material_surface(\n\
         \x20       scattering: df::specular_bsdf(tint: color(1.0f), mode: df::scatter_reflect_transmit)\n\
         \x20   ),\n\
         \x20   volume: material_volume(\n\
         \x20       scattering: df::anisotropic_vdf(directional_bias: {}),\n\
         \x20       absorption_coefficient: color({}),\n\
         \x20       scattering_coefficient: color({})\n\
         \x20   )\n);\n",
        float(index),
        float(colours.asymmetry),
        colour(colours.sigma_a),
        colour(colours.sigma_s),
    );
    let files = vec![(format!("{id}.mdl"), text.into_bytes())];
    Ok(Written { files, form: how, held, loss, phase, remarks })
}

#[cfg(test)]
mod tests {
    use super::super::testing::{assert_colours_recovered, emulsion, text_of};
    use super::super::{Format, write};
    use super::*;

    #[test]
    fn what_is_read_back_is_the_material_as_far_as_colour_goes() {
        let subject = Subject { name: "2nd/emulsion.v2".into(), ..emulsion() };
        let written = write(Format::Mdl, &subject).unwrap();
        let text = text_of(&written);
        assert!(text.starts_with("mdl 1.7;") && text.contains("export material material_2nd_emulsion_v2()"), "{text}");
        let numbers = |key: &str| -> Vec<f64> {
            let at = text.find(key).unwrap() + key.len();
            let inside = text[at..].split([')', '\n']).next().unwrap();
            inside.split(',').map(|n| n.trim().trim_end_matches('f').parse().unwrap()).collect()
        };
        let (s, a) = (numbers("scattering_coefficient: color("), numbers("absorption_coefficient: color("));
        assert_colours_recovered(&subject, &written, &s, &a, numbers("directional_bias: ")[0]);
    }
}
