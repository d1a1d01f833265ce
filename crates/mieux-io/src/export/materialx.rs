//! MaterialX 1.39 (`materialx139`): `anisotropic_vdf` under a smooth `dielectric_bsdf`, as a surface and as a volume material.

use super::channels::PATH;
use super::text::{head, identifier, single, singles, stem, unit, xml_comment};
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
        "the specification counts coefficients in 1/m; a renderer that counts in 1/scene unit instead must be told the \
         scale"
            .into(),
    ];
    let how = format!("absorption and scattering in 1/m, {PATH}; {}", unit(subject));
    let id = identifier(&subject.name);
    let comment = xml_comment(&head(subject, "MaterialX 1.39", &how, &loss, &phase, &remarks));
    let text = format!(
        "<?xml version=\"1.0\"?>\n{comment}<materialx version=\"1.39\" colorspace=\"lin_rec709\">\n\
         \x20 <anisotropic_vdf name=\"{id}_vdf\" type=\"VDF\">\n\
         \x20   <input name=\"absorption\" type=\"vector3\" value=\"{}\" />\n\
         \x20   <input name=\"scattering\" type=\"vector3\" value=\"{}\" />\n\
         \x20   <input name=\"anisotropy\" type=\"float\" value=\"{}\" />\n\
         \x20 </anisotropic_vdf>\n\
         \x20 <dielectric_bsdf name=\"{id}_boundary\" type=\"BSDF\">\n\
         \x20   <input name=\"ior\" type=\"float\" value=\"{}\" />\n\
         \x20   <input name=\"roughness\" type=\"vector2\" value=\"0, 0\" />\n\
         \x20   <input name=\"scatter_mode\" type=\"string\" value=\"RT\" />\n\
         \x20 </dielectric_bsdf>\n\
         \x20 <layer name=\"{id}_body\" type=\"BSDF\">\n\
         \x20   <input name=\"top\" type=\"BSDF\" nodename=\"{id}_boundary\" />\n\
         \x20   <input name=\"base\" type=\"VDF\" nodename=\"{id}_vdf\" />\n\
         \x20 </layer>\n\
         \x20 <surface name=\"{id}_surface\" type=\"surfaceshader\">\n\
         \x20   <input name=\"bsdf\" type=\"BSDF\" nodename=\"{id}_body\" />\n\
         \x20 </surface>\n\
         \x20 <surfacematerial name=\"{id}\" type=\"material\">\n\
         \x20   <input name=\"surfaceshader\" type=\"surfaceshader\" nodename=\"{id}_surface\" />\n\
         \x20 </surfacematerial>\n\
         \x20 <volume name=\"{id}_interior\" type=\"volumeshader\">\n\
         \x20   <input name=\"vdf\" type=\"VDF\" nodename=\"{id}_vdf\" />\n\
         \x20 </volume>\n\
         \x20 <volumematerial name=\"{id}_volume\" type=\"material\">\n\
         \x20   <input name=\"volumeshader\" type=\"volumeshader\" nodename=\"{id}_interior\" />\n\
         \x20 </volumematerial>\n\
         </materialx>\n",
        singles(colours.sigma_a, ", "),
        singles(colours.sigma_s, ", "),
        single(colours.asymmetry),
        single(index),
    );
    let files = vec![(format!("{}.mtlx", stem(&subject.name)), text.into_bytes())];
    Ok(Written { files, form: how, held, loss, phase, remarks })
}

#[cfg(test)]
mod tests {
    use super::super::testing::{assert_colours_recovered, emulsion, numbers_after, text_of};
    use super::super::{Format, write};
    use super::*;

    #[test]
    fn what_is_read_back_is_the_material_as_far_as_colour_goes() {
        let subject = Subject { metres_per_unit: 0.01, ..emulsion() };
        let written = write(Format::MaterialX, &subject).unwrap();
        let text = text_of(&written);
        let three = |name: &str| numbers_after(&text, &format!("name=\"{name}\" type=\"vector3\" value="));
        let g = numbers_after(&text, "name=\"anisotropy\" type=\"float\" value=")[0];
        assert_colours_recovered(&subject, &written, &three("scattering"), &three("absorption"), g);
    }
}
