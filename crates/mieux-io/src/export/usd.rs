//! OpenUSD (`openusd`): a MaterialX network of `ND_anisotropic_vdf` under `ND_dielectric_bsdf`, as surface and as volume, on a
//! ball. `UsdPreviewSurface` has no interior and cannot hold it.

use super::channels::PATH;
use super::text::{commented, head, identifier, single, singles, stem, unit};
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
        "MaterialX counts coefficients in 1/m, and metersPerUnit of the stage says what a unit is; a renderer that counts in \
         1/unit must be told"
            .into(),
        "UsdPreviewSurface has no interior and is left out".into(),
    ];
    let how = format!("absorption and scattering in 1/m, {PATH}; {}", unit(subject));
    let id = identifier(&subject.name);
    let comment = commented(&head(subject, "OpenUSD with MaterialX", &how, &loss, &phase, &remarks), "#");
    let text = format!(
        r#"#usda 1.0
{comment}(
    defaultPrim = "Ball"
    metersPerUnit = {scale}
    upAxis = "Y"
)

def Sphere "Ball" (
    prepend apiSchemas = ["MaterialBindingAPI"]
)
{{
    double radius = {radius}
    rel material:binding = </{id}>
}}

def Material "{id}"
{{
    token outputs:mtlx:surface.connect = </{id}/Surface.outputs:out>
    token outputs:mtlx:volume.connect = </{id}/Interior.outputs:out>

    def Shader "Vdf"
    {{
        uniform token info:id = "ND_anisotropic_vdf"
        float3 inputs:absorption = ({absorption})
        float3 inputs:scattering = ({scattering})
        float inputs:anisotropy = {g}
        token outputs:out
    }}

    def Shader "Boundary"
    {{
        uniform token info:id = "ND_dielectric_bsdf"
        float inputs:ior = {index}
        float2 inputs:roughness = (0, 0)
        string inputs:scatter_mode = "RT"
        token outputs:out
    }}

    def Shader "Body"
    {{
        uniform token info:id = "ND_layer_vdf"
        token inputs:top.connect = </{id}/Boundary.outputs:out>
        token inputs:base.connect = </{id}/Vdf.outputs:out>
        token outputs:out
    }}

    def Shader "Surface"
    {{
        uniform token info:id = "ND_surface"
        token inputs:bsdf.connect = </{id}/Body.outputs:out>
        token outputs:out
    }}

    def Shader "Interior"
    {{
        uniform token info:id = "ND_volume"
        token inputs:vdf.connect = </{id}/Vdf.outputs:out>
        token outputs:out
    }}
}}
"#,
        scale = single(subject.metres_per_unit),
        radius = single(0.02 / subject.metres_per_unit),
        absorption = singles(colours.sigma_a, ", "),
        scattering = singles(colours.sigma_s, ", "),
        g = single(colours.asymmetry),
        index = single(index),
    );
    let files = vec![(format!("{}.usda", stem(&subject.name)), text.into_bytes())];
    Ok(Written { files, form: how, held, loss, phase, remarks })
}

#[cfg(test)]
mod tests {
    use super::super::testing::{assert_colours_recovered, emulsion, text_of};
    use super::super::{Format, write};
    use super::*;

    #[test]
    fn what_is_read_back_is_the_material_as_far_as_colour_goes() {
        let subject = Subject { metres_per_unit: 0.01, ..emulsion() };
        let written = write(Format::Usd, &subject).unwrap();
        let text = text_of(&written);
        assert!(text.starts_with("#usda 1.0\n") && text.contains("metersPerUnit = 0.01"));
        let numbers = |key: &str| -> Vec<f64> {
            let at = text.find(key).unwrap() + key.len();
            let inside = text[at..].split([')', '\n']).next().unwrap();
            inside.trim_start_matches('(').split(',').map(|n| n.trim().parse().unwrap()).collect()
        };
        let (s, a) = (numbers("inputs:scattering = "), numbers("inputs:absorption = "));
        assert_colours_recovered(&subject, &written, &s, &a, numbers("inputs:anisotropy = ")[0]);
    }
}
