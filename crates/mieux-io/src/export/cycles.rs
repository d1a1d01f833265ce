//! Cycles in Blender (`blender5`): a Python script that makes the material, and sets the renderer so that light is followed
//! to its end.
//!
//! The volume is `Volume Coefficients` (`Volume Scatter` and `Volume Absorption` in a Blender too old for it). Its phase
//! function is Henyey-Greenstein, or, where that fits better, a sum of it and Draine's, both with the right mean cosine.

use mieux_optics::phase::{PhaseFunction, fit};

use super::channels::PATH;
use super::text::{commented, head, rounded, single, singles, stem, unit};
use super::{ExportError, Format, Loss, PhaseLoss, Subject, Written};
use crate::quantity::{format_length, significant};

/// A second lobe must put this share less of the light in the wrong place to be worth its node.
const WORTH: f64 = 0.8;

/// A share of the scattering, and the node's phase function with its settings as Python.
type Lobe = (f64, &'static str, String);

pub fn write(subject: &Subject) -> Result<Written, ExportError> {
    let (lobes, g, phase) = if subject.isotropic { isotropic() } else { fitted(subject)? };
    let colours = subject.channels_for(g)?;
    let held = colours.rounded();
    let loss = Loss::new(subject, &held);
    let (wavelength, index) = subject.index();
    let longest = colours.sigma_s.iter().copied().fold(0.0, f64::max);
    let remarks = vec![
        format!("boundary: Glass without roughness, n = {} at {}", significant(index, 6), format_length(wavelength)),
        format!(
            "Cycles gives a path up after 1024 bounces; a path as long as 1 cm scatters {} times here (`--isotropic` makes \
             that less where the material is thick)",
            significant(0.01 * longest, 2)
        ),
    ];
    let how = format!("scattering and absorption in 1/m, times METRES_PER_UNIT, {PATH}; {}", unit(subject));
    let name = stem(&subject.name);
    let comment = commented(&head(subject, "Cycles (Blender 4.3 and later)", &how, &loss, &phase, &remarks), "#");
    let lobes: String =
        lobes.iter().map(|(share, kind, set)| format!("    ({}, \"{kind}\", {{{set}}}),\n", single(*share))).collect();
    let text = format!(
        "{comment}#\n# In Blender: open it in the text editor and run it; the material is then among the others.\n\
         # A picture of a ball of 4 cm: blender -b -P {name}.py -- --test ball.png\n\
         # or, with bpy from PyPI:      python {name}.py --test ball.png\n\n\
         import sys\n\nimport bpy\n\n\
         NAME = \"{name}\"\n\
         METRES_PER_UNIT = {}  # length of a Blender unit\n\
         SIGMA_S = ({})  # 1/m\n\
         SIGMA_A = ({})  # 1/m\n\
         IOR = {}\n\
         # Share of the scattering, phase function, its settings.\n\
         LOBES = [\n{lobes}]\n{SCRIPT}",
        single(subject.metres_per_unit),
        singles(colours.sigma_s, ", "),
        singles(colours.sigma_a, ", "),
        single(index),
    );
    let files = vec![(format!("{name}.py"), text.into_bytes())];
    Ok(Written { files, form: how, held, loss, phase, remarks })
}

fn isotropic() -> (Vec<Lobe>, f64, PhaseLoss) {
    (vec![(1.0, "HENYEY_GREENSTEIN", "\"Anisotropy\": 0.0".into())], 0.0, PhaseLoss::henyey_greenstein(0.0))
}

fn fitted(subject: &Subject) -> Result<(Vec<Lobe>, f64, PhaseLoss), ExportError> {
    let (wavelength, function) = subject.phase(Format::Cycles)?;
    if matches!(function, PhaseFunction::Isotropic(_)) {
        return Ok(isotropic());
    }
    let at = format_length(wavelength);
    let options = fit::Options { keep_asymmetry: true, weight: fit::Weight::Energy };
    let one = fit::henyey_greenstein(function, &options)?;
    let two = fit::henyey_greenstein_draine(function, &options)?;
    let lack = 1.0 - function.asymmetry();
    if two.total_variation >= WORTH * one.total_variation {
        let g = rounded(one.phase.asymmetry());
        let loss = PhaseLoss {
            form: format!("Henyey-Greenstein with the mean cosine at {at}, g = {}", significant(g, 6)),
            total_variation: Some(one.total_variation),
            one_minus_asymmetry: Some((g - function.asymmetry()).abs() / lack),
        };
        return Ok((vec![(1.0, "HENYEY_GREENSTEIN", format!("\"Anisotropy\": {}", single(g)))], g, loss));
    }
    let share = rounded(two.phase.draine_weight());
    let (g_d, alpha) = two.phase.draine().parameters();
    let [g_hg, g_d, alpha] = [two.phase.henyey_greenstein().asymmetry(), g_d, alpha].map(rounded);
    let draine = g_d * (1.0 + alpha * (3.0 + 2.0 * g_d * g_d) / 5.0) / (1.0 + alpha * (1.0 + 2.0 * g_d * g_d) / 3.0);
    let g = (1.0 - share) * g_hg + share * draine;
    let loss = PhaseLoss {
        form: format!(
            "Henyey-Greenstein (g = {}) and, for {} of the light, Draine (g = {}, alpha = {}), fitted to that at {at}",
            significant(g_hg, 5),
            significant(share, 4),
            significant(g_d, 5),
            significant(alpha, 5)
        ),
        total_variation: Some(two.total_variation),
        one_minus_asymmetry: Some((g - function.asymmetry()).abs() / lack),
    };
    let lobes = vec![
        (1.0 - share, "HENYEY_GREENSTEIN", format!("\"Anisotropy\": {}", single(g_hg))),
        (share, "DRAINE", format!("\"Anisotropy\": {}, \"Alpha\": {}", single(g_d), single(alpha))),
    ];
    Ok((lobes, g, loss))
}

/// What is the same for every material.
const SCRIPT: &str = r#"

def volume(tree, scatter, absorb, kind, settings):
    """Nodes of one lobe, coefficients in 1/Blender unit; returns the output."""
    if hasattr(bpy.types, "ShaderNodeVolumeCoefficients"):
        node = tree.nodes.new("ShaderNodeVolumeCoefficients")
        node.inputs["Scatter Coefficients"].default_value = scatter
        node.inputs["Absorption Coefficients"].default_value = absorb
        output = node.outputs["Volume"]
    else:
        # A colour times a density; absorption is the density times one less the colour.
        node = tree.nodes.new("ShaderNodeVolumeScatter")
        density = max(scatter)
        node.inputs["Density"].default_value = density
        node.inputs["Color"].default_value = [s / density for s in scatter] + [1.0]
        output = node.outputs["Volume"]
        if max(absorb) > 0.0:
            absorption = tree.nodes.new("ShaderNodeVolumeAbsorption")
            density = max(absorb)
            absorption.inputs["Density"].default_value = density
            absorption.inputs["Color"].default_value = [1.0 - a / density for a in absorb] + [1.0]
            output = add(tree, output, absorption.outputs["Volume"])
    node.phase = kind
    for name, value in settings.items():
        node.inputs[name].default_value = value
    return output


def add(tree, first, second):
    node = tree.nodes.new("ShaderNodeAddShader")
    tree.links.new(first, node.inputs[0])
    tree.links.new(second, node.inputs[1])
    return node.outputs[0]


def node_group():
    """A node group with the boundary and the interior as outputs."""
    group = bpy.data.node_groups.new(NAME, "ShaderNodeTree")
    for name in ("Surface", "Volume"):
        group.interface.new_socket(name, in_out="OUTPUT", socket_type="NodeSocketShader")
    out = group.nodes.new("NodeGroupOutput")
    glass = group.nodes.new("ShaderNodeBsdfGlass")
    glass.inputs["Color"].default_value = (1.0, 1.0, 1.0, 1.0)
    glass.inputs["Roughness"].default_value = 0.0
    glass.inputs["IOR"].default_value = IOR
    group.links.new(glass.outputs[0], out.inputs["Surface"])
    total = None
    for share, kind, settings in LOBES:
        scatter = [share * s * METRES_PER_UNIT for s in SIGMA_S]
        # The first lobe carries all of the absorption.
        absorb = [0.0 if total else a * METRES_PER_UNIT for a in SIGMA_A]
        lobe = volume(group, scatter, absorb, kind, settings)
        total = add(group, total, lobe) if total else lobe
    group.links.new(total, out.inputs["Volume"])
    return group


def material():
    """The material, to be given to closed objects."""
    made = bpy.data.materials.new(NAME)
    if bpy.app.version < (5, 0, 0):
        made.use_nodes = True
    tree = made.node_tree
    tree.nodes.clear()
    group = tree.nodes.new("ShaderNodeGroup")
    group.node_tree = node_group()
    out = tree.nodes.new("ShaderNodeOutputMaterial")
    for name in ("Surface", "Volume"):
        tree.links.new(group.outputs[name], out.inputs[name])
    return made


def set_up(scene):
    """Cycles as it must be for light to be followed to its end; the defaults cut paths and blur what is sharp."""
    scene.render.engine = "CYCLES"
    cycles = scene.cycles
    cycles.blur_glossy = 0.0  # Filter Glossy
    for name in ("max_bounces", "diffuse_bounces", "glossy_bounces", "transmission_bounces", "volume_bounces",
                 "transparent_max_bounces"):
        setattr(cycles, name, 1024)
    cycles.caustics_reflective = cycles.caustics_refractive = True
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0.0


def ball(path):
    """A picture of a ball of 4 cm in even light, before black."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    set_up(scene)
    bpy.ops.mesh.primitive_uv_sphere_add(segments=64, ring_count=32, radius=0.02 / METRES_PER_UNIT)
    sphere = bpy.context.object
    bpy.ops.object.shade_smooth()
    sphere.data.materials.append(material())
    scene.world = bpy.data.worlds.new("even light")
    if bpy.app.version < (5, 0, 0):
        scene.world.use_nodes = True
    nodes = scene.world.node_tree.nodes
    background = nodes.get("Background")
    background.inputs["Color"].default_value = (1.0, 1.0, 1.0, 1.0)
    scene.world.cycles_visibility.camera = False
    bpy.ops.object.camera_add(location=(0.0, -0.1 / METRES_PER_UNIT, 0.0), rotation=(1.5707963267948966, 0.0, 0.0))
    scene.camera = bpy.context.object
    scene.camera.data.clip_start = 0.001 / METRES_PER_UNIT
    scene.render.resolution_x = scene.render.resolution_y = 64
    scene.cycles.samples = 16
    scene.cycles.use_denoising = False
    scene.view_settings.view_transform = "Standard"
    scene.render.filepath = path
    bpy.ops.render.render(write_still=True)


if __name__ == "__main__":
    if "--test" in sys.argv:
        ball(sys.argv[sys.argv.index("--test") + 1])
    else:
        material()
        set_up(bpy.context.scene)
"#;

#[cfg(test)]
mod tests {
    use super::super::testing::{assert_colours_recovered, emulsion, text_of};
    use super::super::write;
    use super::*;

    fn after(text: &str, key: &str) -> Vec<f64> {
        let at = text.find(key).unwrap() + key.len();
        text[at..].split([')', '}', ']', '\n']).next().unwrap().split(',').map(|n| n.trim().parse().unwrap()).collect()
    }

    #[test]
    fn the_script_holds_the_material_as_far_as_colour_goes() {
        let subject = Subject { metres_per_unit: 0.01, ..emulsion() };
        let written = write(Format::Cycles, &subject).unwrap();
        let text = text_of(&written);
        // The mean cosine of what the nodes are told to do.
        let lobes = &text[text.find("LOBES = [").unwrap()..text.find("\n]\n").unwrap()];
        let mut g = 0.0;
        for line in lobes.lines().filter(|line| line.trim_start().starts_with('(')) {
            let share: f64 = line.trim_start()[1..].split(',').next().unwrap().parse().unwrap();
            let number = |key: &str| -> f64 {
                let rest = &line[line.find(key).unwrap() + key.len()..];
                rest.split([',', '}']).next().unwrap().trim().parse().unwrap()
            };
            let parameter = number("\"Anisotropy\":");
            g += share
                * if line.contains("DRAINE") {
                    mieux_optics::phase::Draine::new(parameter, number("\"Alpha\":")).unwrap().asymmetry()
                } else {
                    parameter
                };
        }
        assert_colours_recovered(&subject, &written, &after(&text, "SIGMA_S = ("), &after(&text, "SIGMA_A = ("), g);
        assert!(text.contains("METRES_PER_UNIT = 0.01 ") && text.contains("blur_glossy = 0.0"));
    }
}
