//! Mitsuba 3 (`mitsuba3`): a homogeneous medium with extinction and albedo as spectra, one phase function as a table at
//! equally spaced cosines (or, where such a table would have to be too long, two Henyey-Greenstein lobes), its smooth
//! boundary, and a small scene to see it in.

use mieux_optics::phase::{PhaseFunction, Tabulated, compare, fit};

use super::text::{head, nanometres, rounded, single, singles, stem, unit, xml_comment};
use super::{ExportError, Format, Held, Loss, PhaseLoss, Subject, Written};
use crate::quantity::{format_length, significant};

/// Points of the shortest table over the cosine that is tried, and of the longest.
const FEWEST_POINTS: usize = 1001;
const MOST_POINTS: usize = 16_001;

/// Share of the scattered light that a table may put elsewhere, and relative error of its `1 - g`.
const TABLE_VARIATION: f64 = 0.01;
const TABLE_ASYMMETRY: f64 = 1e-3;

/// Vacuum wavelengths at which Mitsuba samples, nm: spectra end there, and are zero beyond their last value.
const SAMPLED: [f64; 2] = [360.0, 830.0];

/// A phase function as Mitsuba takes it.
struct Form {
    xml: String,
    asymmetry: f64,
    loss: PhaseLoss,
}

pub fn write(subject: &Subject) -> Result<Written, ExportError> {
    let form = if subject.isotropic { isotropic() } else { phase(subject)? };
    let sigma_s = subject.scattering_for(form.asymmetry);
    let sigma_t: Vec<f64> = sigma_s.iter().zip(&subject.sigma_a).map(|(s, a)| rounded(s + a)).collect();
    let albedo: Vec<f64> =
        sigma_s.iter().zip(&subject.sigma_a).map(|(s, a)| if *s > 0.0 { rounded(s / (s + a)) } else { 0.0 }).collect();
    let held = Held {
        sigma_s: sigma_t.iter().zip(&albedo).map(|(t, w)| t * w).collect(),
        sigma_a: sigma_t.iter().zip(&albedo).map(|(t, w)| t * (1.0 - w)).collect(),
        asymmetry: vec![form.asymmetry; sigma_t.len()],
    };
    let loss = Loss::new(subject, &held);
    let (wavelength, index) = subject.index();
    let mut remarks =
        vec![format!("boundary: smooth dielectric, n = {} at {}", significant(index, 6), format_length(wavelength))];
    if subject.grid.len() > 1 {
        remarks.push(
            "beyond the first and the last wavelength the spectra go on as constants; use a spectral variant".into(),
        );
    }
    let how = format!("sigma_t in 1/m times `scale`, albedo, over wavelength in nm; {}", unit(subject));
    let name = stem(&subject.name);
    let comment = xml_comment(&head(subject, "Mitsuba 3", &how, &loss, &form.loss, &remarks));
    let medium = format!(
        "<scene version=\"3.0.0\">\n{comment}\
         <medium type=\"homogeneous\" id=\"{name}\">\n{}{}\
         \x20   <float name=\"scale\" value=\"{}\"/>\n{}</medium>\n\
         <bsdf type=\"dielectric\" id=\"{name}-boundary\">\n\
         \x20   <float name=\"int_ior\" value=\"{}\"/>\n\
         \x20   <float name=\"ext_ior\" value=\"1\"/>\n\
         </bsdf>\n</scene>\n",
        spectrum("sigma_t", subject, &sigma_t),
        spectrum("albedo", subject, &albedo),
        single(subject.metres_per_unit),
        form.xml,
        single(index),
    );
    Ok(Written {
        files: vec![
            (format!("{name}.xml"), medium.into_bytes()),
            (format!("{name}-scene.xml"), scene(subject, &name).into_bytes()),
        ],
        form: how,
        held,
        loss,
        phase: form.loss,
        remarks,
    })
}

fn spectrum(name: &str, subject: &Subject, values: &[f64]) -> String {
    if let [value] = values {
        return format!(
            "    <spectrum name=\"{name}\" type=\"uniform\">\n        <float name=\"value\" value=\"{}\"/>\n    </spectrum>\n",
            single(*value)
        );
    }
    let mut points: Vec<(f64, f64)> = subject.grid.iter().map(nanometres).zip(values.iter().copied()).collect();
    if let (Some(&(first, before)), Some(&(last, after))) = (points.first(), points.last()) {
        if first > SAMPLED[0] {
            points.insert(0, (SAMPLED[0], before));
        }
        if last < SAMPLED[1] {
            points.push((SAMPLED[1], after));
        }
    }
    format!(
        "    <spectrum name=\"{name}\" type=\"irregular\">\n        <string name=\"wavelengths\" value=\"{}\"/>\n        \
         <string name=\"values\" value=\"{}\"/>\n    </spectrum>\n",
        singles(points.iter().map(|(w, _)| *w), ", "),
        singles(points.iter().map(|(_, v)| *v), ", "),
    )
}

fn isotropic() -> Form {
    Form { xml: "    <phase type=\"isotropic\"/>\n".into(), asymmetry: 0.0, loss: PhaseLoss::henyey_greenstein(0.0) }
}

/// The shortest table that is good enough, or else two lobes.
fn phase(subject: &Subject) -> Result<Form, ExportError> {
    let (wavelength, function) = subject.phase(Format::Mitsuba)?;
    if matches!(function, PhaseFunction::Isotropic(_)) {
        return Ok(isotropic());
    }
    let lack = 1.0 - function.asymmetry();
    let mut points = FEWEST_POINTS;
    while points <= MOST_POINTS {
        let table = PhaseFunction::from(Tabulated::regular_in_cosine(function, points)?);
        let apart = compare(function, &table);
        let error = apart.delta_asymmetry.abs() / lack;
        if apart.total_variation <= TABLE_VARIATION && error <= TABLE_ASYMMETRY {
            let form =
                format!("that at {}, at {points} equally spaced cosines from -1 to 1", format_length(wavelength));
            let loss =
                PhaseLoss { form, total_variation: Some(apart.total_variation), one_minus_asymmetry: Some(error) };
            return Ok(Form { xml: table_xml(&table), asymmetry: table.asymmetry(), loss });
        }
        points = 2 * points - 1;
    }
    lobes(function, wavelength)
}

fn table_xml(table: &PhaseFunction) -> String {
    let PhaseFunction::Tabulated(table) = table else { return String::new() };
    // From forward to backward, one value for each cosine; Mitsuba wants them the other way round.
    let forward = table.bins().first().map(|ends| ends[0]);
    let values: Vec<f64> = forward.into_iter().chain(table.bins().iter().map(|ends| ends[1])).collect();
    format!(
        "    <phase type=\"tabphase\">\n        <string name=\"values\" value=\"{}\"/>\n    </phase>\n",
        singles(values.into_iter().rev(), ", ")
    )
}

fn lobes(function: &PhaseFunction, wavelength: f64) -> Result<Form, ExportError> {
    let options = fit::Options { keep_asymmetry: true, weight: fit::Weight::Energy };
    let fitted = fit::double_henyey_greenstein(function, &options)?;
    let (weight, g1, g2) = fitted.phase.parameters();
    let [weight, g1, g2] = [weight, g1, g2].map(rounded);
    let asymmetry = weight * g1 + (1.0 - weight) * g2;
    let form = format!(
        "two Henyey-Greenstein lobes fitted to that at {} ({} of g = {}, the rest of g = {}), as a table would need more than {MOST_POINTS} cosines",
        format_length(wavelength),
        significant(weight, 4),
        significant(g1, 5),
        significant(g2, 5),
    );
    let loss = PhaseLoss {
        form,
        total_variation: Some(fitted.total_variation),
        one_minus_asymmetry: Some((asymmetry - function.asymmetry()).abs() / (1.0 - function.asymmetry())),
    };
    let lobe = |g: f64| {
        format!(
            "        <phase type=\"hg\">\n            <float name=\"g\" value=\"{}\"/>\n        </phase>\n",
            single(g)
        )
    };
    // The weight is that of the second.
    let xml = format!(
        "    <phase type=\"blendphase\">\n        <float name=\"weight\" value=\"{}\"/>\n{}{}    </phase>\n",
        single(weight),
        lobe(g2),
        lobe(g1)
    );
    Ok(Form { xml, asymmetry, loss })
}

/// A ball of the material, four centimetres across, in even daylight that is not seen itself.
fn scene(subject: &Subject, name: &str) -> String {
    let units = |metres: f64| single(metres / subject.metres_per_unit);
    format!(
        "<scene version=\"3.0.0\">\n\
         <!-- A ball of 4 cm across. Render with a spectral variant: mitsuba -m scalar_spectral {name}-scene.xml -->\n\
         <include filename=\"{name}.xml\"/>\n\
         <!-- Russian roulette would end paths that have lost nothing yet; these end by themselves. -->\n\
         <integrator type=\"volpathmis\">\n    <integer name=\"max_depth\" value=\"-1\"/>\n    \
         <integer name=\"rr_depth\" value=\"1000000\"/>\n    \
         <boolean name=\"hide_emitters\" value=\"true\"/>\n</integrator>\n\
         <emitter type=\"constant\">\n    <spectrum name=\"radiance\" type=\"d65\"/>\n</emitter>\n\
         <shape type=\"sphere\">\n    <float name=\"radius\" value=\"{}\"/>\n    <ref name=\"interior\" id=\"{name}\"/>\n    \
         <ref id=\"{name}-boundary\"/>\n</shape>\n\
         <sensor type=\"perspective\">\n    <float name=\"fov\" value=\"30\"/>\n    <transform name=\"to_world\">\n        \
         <lookat origin=\"0, 0, {}\" target=\"0, 0, 0\" up=\"0, 1, 0\"/>\n    </transform>\n    \
         <film type=\"hdrfilm\">\n        <integer name=\"width\" value=\"128\"/>\n        \
         <integer name=\"height\" value=\"128\"/>\n    </film>\n    <sampler type=\"independent\">\n        \
         <integer name=\"sample_count\" value=\"64\"/>\n    </sampler>\n</sensor>\n</scene>\n",
        units(0.02),
        units(0.1),
    )
}

#[cfg(test)]
mod tests {
    use super::super::testing::{assert_recovered, droplets, emulsion, numbers_after, text_of};
    use super::super::{Phases, write};
    use super::*;

    fn recovered(text: &str, count: usize, lead: usize) -> (Vec<f64>, Vec<f64>) {
        let values = |name: &str| {
            let at = text.find(&format!("name=\"{name}\"")).unwrap();
            let from = if text[at..].starts_with(&format!("name=\"{name}\" type=\"uniform\"")) {
                "name=\"value\" value="
            } else {
                "name=\"values\" value="
            };
            let all = numbers_after(&text[at..], from);
            all[lead..lead + count].to_vec()
        };
        (values("sigma_t"), values("albedo"))
    }

    #[test]
    fn what_mitsuba_reads_is_the_material() {
        for scale in [1.0, 0.001] {
            let subject = Subject { metres_per_unit: scale, ..emulsion() };
            let written = write(Format::Mitsuba, &subject).unwrap();
            let text = text_of(&written);
            // The table's mean cosine, from the values in the file by the trapezoidal form of its own interpolant.
            let table = numbers_after(&text[text.find("tabphase").unwrap()..], "name=\"values\" value=");
            let step = 2.0 / (table.len() - 1) as f64;
            let (mut total, mut first) = (0.0, 0.0);
            for (i, pair) in table.windows(2).enumerate() {
                let [low, high] = [-1.0 + step * i as f64, -1.0 + step * (i + 1) as f64];
                total += 0.5 * step * (pair[0] + pair[1]);
                first += step * (pair[0] * (2.0 * low + high) + pair[1] * (low + 2.0 * high)) / 6.0;
            }
            let g = first / total;
            let read_scale = numbers_after(&text, "name=\"scale\" value=")[0];
            assert!((read_scale / scale - 1.0).abs() < 1e-6);
            let (sigma_t, albedo) = recovered(&text, subject.grid.len(), 1);
            // What the renderer sees per scene unit, back in 1/m.
            let sigma_t: Vec<f64> = sigma_t.iter().map(|t| t * read_scale / scale).collect();
            let sigma_s: Vec<f64> = sigma_t.iter().zip(&albedo).map(|(t, w)| t * w).collect();
            let sigma_a: Vec<f64> = sigma_t.iter().zip(&albedo).map(|(t, w)| t * (1.0 - w)).collect();
            assert_recovered(&subject, &written, &sigma_s, &sigma_a, &vec![g; sigma_s.len()]);
            assert!(written.loss.reduced.largest < 1e-4 && written.loss.sigma_a.largest < 2e-3);
        }
    }

    #[test]
    fn a_peak_too_narrow_for_a_table_becomes_two_lobes() {
        let subject = droplets();
        let written = write(Format::Mitsuba, &subject).unwrap();
        let text = text_of(&written);
        assert!(text.contains("blendphase") && !text.contains("tabphase"), "{text}");
        let at = &text[text.find("blendphase").unwrap()..];
        let (weight, g) =
            (numbers_after(at, "\"weight\" value=")[0], |from: &str| numbers_after(from, "\"g\" value=")[0]);
        let second = &at[at.find("name=\"g\"").unwrap() + 8..];
        let mean = (1.0 - weight) * g(at) + weight * g(second);
        let Phases::One { function, .. } = &subject.phases else { panic!("one") };
        assert!(((mean - function.asymmetry()) / (1.0 - function.asymmetry())).abs() < 1e-3);
        assert!(written.phase.total_variation.unwrap() > 0.01);
    }

    #[test]
    fn a_single_wavelength_is_uniform() {
        let mut subject = emulsion();
        subject.grid = mieux_optics::spectrum::WavelengthGrid::new(vec![550e-9]).unwrap();
        for values in
            [&mut subject.sigma_s, &mut subject.sigma_a, &mut subject.asymmetry, &mut subject.refractive_index]
        {
            values.truncate(1);
        }
        let written = write(Format::Mitsuba, &subject).unwrap();
        let (sigma_t, albedo) = recovered(&text_of(&written), 1, 0);
        let sigma_s = vec![sigma_t[0] * albedo[0]];
        let sigma_a = vec![sigma_t[0] * (1.0 - albedo[0])];
        let g = written.held.asymmetry.clone();
        assert_recovered(&subject, &written, &sigma_s, &sigma_a, &g);
    }
}
