//! glTF 2.0 with the drafts of volume scattering (`gltfscatter`): extinction by `KHR_materials_volume`, albedo and
//! asymmetry by `KHR_materials_volume_scatter`, on a ball.
//!
//! The draft gives the albedo of a single scattering, `w`, by the colour `c` that a deep body of isotropic scattering shows:
//! `w = 1 - (4.09712 + 4.20863 c - sqrt(9.59217 + 41.6808 c + 17.7126 c^2))^2`, whatever the asymmetry is.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::json;

use super::channels::PATH;
use super::text::{head, rounded, stem, unit};
use super::{ExportError, Loss, PhaseLoss, Subject, Written};
use crate::quantity::{format_length, significant};

/// Radius of the ball, m.
const RADIUS: f64 = 0.02;
/// Meridians and parallels of the ball.
const AROUND: u16 = 48;
const DOWN: u16 = 24;

pub fn write(subject: &Subject) -> Result<Written, ExportError> {
    if !subject.drafts {
        return Err(ExportError::Draft);
    }
    let colours = subject.channels()?;
    let sigma_t: [f64; 3] = std::array::from_fn(|c| colours.sigma_s[c] + colours.sigma_a[c]);
    // At the mean free path of the densest channel all colours lie well within (0, 1).
    let distance = rounded(1.0 / sigma_t.iter().copied().fold(0.0, f64::max));
    let attenuation = sigma_t.map(|t| rounded((-t * distance).exp()));
    let shown: [f64; 3] = std::array::from_fn(|c| rounded(shown_by(1.0 - colours.sigma_a[c] / sigma_t[c])));
    let (sigma_s, sigma_a) = coefficients(attenuation, distance, shown);
    let held = colours.held(sigma_s, sigma_a, colours.asymmetry);
    let loss = Loss::new(subject, &held);
    let phase = PhaseLoss::henyey_greenstein(colours.asymmetry);
    let (wavelength, index) = subject.index();
    let remarks = vec![
        format!("boundary: smooth dielectric, n = {} at {}", significant(index, 6), format_length(wavelength)),
        "KHR_materials_volume_scatter is a draft, and few programs read it; units of glTF are metres, so the scale is of no \
         consequence here"
            .into(),
    ];
    let how = format!(
        "attenuation colour at attenuationDistance in m, multiple-scattering colour, {PATH}; {}",
        unit(subject)
    );
    let lines = head(subject, "glTF 2.0 with KHR_materials_volume_scatter (draft)", &how, &loss, &phase, &remarks);
    let name = stem(&subject.name);
    let material = json!({
        "name": name,
        "extras": { "notes": lines },
        "pbrMetallicRoughness": { "baseColorFactor": [1.0, 1.0, 1.0, 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.0 },
        "extensions": {
            "KHR_materials_ior": { "ior": rounded(index) },
            "KHR_materials_transmission": { "transmissionFactor": 1.0 },
            "KHR_materials_volume": {
                "thicknessFactor": 2.0 * RADIUS,
                "attenuationDistance": distance,
                "attenuationColor": attenuation,
            },
            "KHR_materials_volume_scatter": {
                "multiscatterColor": shown,
                "scatterAnisotropy": colours.asymmetry,
            },
        },
    });
    let text = format!("{:#}\n", document(&name, &material));
    let files = vec![(format!("{name}.gltf"), text.into_bytes())];
    Ok(Written { files, form: how, held, loss, phase, remarks })
}

/// Albedo of a single scattering, by the colour of a deep body.
fn albedo(shown: f64) -> f64 {
    let root = 4.09712 + 4.20863 * shown - (9.59217 + 41.6808 * shown + 17.7126 * shown * shown).sqrt();
    1.0 - root * root
}

/// The colour of a deep body, by the albedo of a single scattering: where [`albedo`], which rises, has that value.
fn shown_by(wanted: f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if albedo(middle) < wanted {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

/// Scattering and absorption, 1/m, as the extensions define them.
fn coefficients(attenuation: [f64; 3], distance: f64, shown: [f64; 3]) -> ([f64; 3], [f64; 3]) {
    let sigma_t = attenuation.map(|c| -c.ln() / distance);
    let albedo = shown.map(albedo);
    (std::array::from_fn(|c| sigma_t[c] * albedo[c]), std::array::from_fn(|c| sigma_t[c] * (1.0 - albedo[c])))
}

/// A ball with a material.
fn document(name: &str, material: &serde_json::Value) -> serde_json::Value {
    let (points, triangles) = ball();
    let mut bytes: Vec<u8> = Vec::new();
    points.iter().for_each(|point| point.iter().for_each(|v| bytes.extend(((RADIUS * v) as f32).to_le_bytes())));
    points.iter().for_each(|point| point.iter().for_each(|v| bytes.extend((*v as f32).to_le_bytes())));
    triangles.iter().for_each(|i| bytes.extend(i.to_le_bytes()));
    let vertices = 12 * points.len();
    let far = f64::from(RADIUS as f32);
    json!({
        "asset": { "version": "2.0", "generator": "mieux" },
        "extensionsUsed": [
            "KHR_materials_ior", "KHR_materials_transmission", "KHR_materials_volume", "KHR_materials_volume_scatter",
        ],
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "name": name, "mesh": 0 }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0, "NORMAL": 1 }, "indices": 2, "material": 0 }] }],
        "materials": [material],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": points.len(), "type": "VEC3",
              "min": [-far, -far, -far], "max": [far, far, far] },
            { "bufferView": 1, "componentType": 5126, "count": points.len(), "type": "VEC3" },
            { "bufferView": 2, "componentType": 5123, "count": triangles.len(), "type": "SCALAR" },
        ],
        "bufferViews": [
            { "buffer": 0, "byteOffset": 0, "byteLength": vertices, "target": 34962 },
            { "buffer": 0, "byteOffset": vertices, "byteLength": vertices, "target": 34962 },
            { "buffer": 0, "byteOffset": 2 * vertices, "byteLength": 2 * triangles.len(), "target": 34963 },
        ],
        "buffers": [{
            "byteLength": bytes.len(),
            "uri": format!("data:application/octet-stream;base64,{}", STANDARD.encode(&bytes)),
        }],
    })
}

/// Points of a unit ball, and triangles between them, counter-clockwise from outside.
fn ball() -> (Vec<[f64; 3]>, Vec<u16>) {
    let mut points = Vec::new();
    for i in 0..=DOWN {
        let (sin, cos) = (std::f64::consts::PI * f64::from(i) / f64::from(DOWN)).sin_cos();
        for j in 0..AROUND {
            let (y, x) = (std::f64::consts::TAU * f64::from(j) / f64::from(AROUND)).sin_cos();
            // Poles and equator reach the bounds exactly.
            points.push([sin * x, cos, -sin * y]);
        }
    }
    let mut triangles = Vec::new();
    for i in 0..DOWN {
        for j in 0..AROUND {
            let next = (j + 1) % AROUND;
            let [a, b, c, d] = [i * AROUND + j, i * AROUND + next, (i + 1) * AROUND + j, (i + 1) * AROUND + next];
            if i + 1 < DOWN {
                triangles.extend([a, c, d]);
            }
            if i > 0 {
                triangles.extend([a, d, b]);
            }
        }
    }
    (points, triangles)
}

#[cfg(test)]
mod tests {
    use super::super::testing::{assert_colours_recovered, emulsion, text_of};
    use super::super::{Format, write};
    use super::*;

    #[test]
    fn the_draft_s_formulas_give_the_coefficients_back() {
        let subject = Subject { drafts: true, ..emulsion() };
        let written = write(Format::Gltf, &subject).unwrap();
        let value: serde_json::Value = serde_json::from_str(&text_of(&written)).unwrap();
        let extensions = &value["materials"][0]["extensions"];
        let number = |v: &serde_json::Value| v.as_f64().unwrap();
        let three = |v: &serde_json::Value| -> Vec<f64> { v.as_array().unwrap().iter().map(number).collect() };
        let volume = &extensions["KHR_materials_volume"];
        let scatter = &extensions["KHR_materials_volume_scatter"];
        let distance = number(&volume["attenuationDistance"]);
        let (mut sigma_s, mut sigma_a) = (Vec::new(), Vec::new());
        for (c, m) in three(&volume["attenuationColor"]).into_iter().zip(three(&scatter["multiscatterColor"])) {
            let sigma_t = -c.ln() / distance;
            let root = 4.09712 + 4.20863 * m - (9.59217 + 41.6808 * m + 17.7126 * m * m).sqrt();
            sigma_s.push(sigma_t * (1.0 - root * root));
            sigma_a.push(sigma_t * root * root);
        }
        assert_colours_recovered(&subject, &written, &sigma_s, &sigma_a, number(&scatter["scatterAnisotropy"]));
        assert!(matches!(write(Format::Gltf, &emulsion()), Err(ExportError::Draft)));
    }

    #[test]
    fn the_ball_is_closed_and_faces_outward() {
        let (points, triangles) = ball();
        let mut volume = 0.0;
        for t in triangles.chunks(3) {
            let [a, b, c] = [t[0], t[1], t[2]].map(|i| points[usize::from(i)]);
            let cross = [b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]];
            volume += (a[0] * cross[0] + a[1] * cross[1] + a[2] * cross[2]) / 6.0;
        }
        let whole = 4.0 / 3.0 * std::f64::consts::PI;
        assert!(volume < whole && volume > 0.98 * whole, "{volume}");
    }

    #[test]
    fn the_colour_of_a_deep_body_inverts_the_albedo() {
        for wanted in [0.1, 0.5, 0.9, 0.999, 0.999_99] {
            assert!((albedo(shown_by(wanted)) - wanted).abs() < 1e-9, "{wanted}");
        }
    }
}
