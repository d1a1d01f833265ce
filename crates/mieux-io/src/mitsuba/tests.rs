use proptest::prelude::*;

use super::*;
use crate::scene::description::*;

const SCENE: &str = r#"<?xml version="1.0"?>
<!-- fog around a ball of glass -->
<scene version="3.0.0">
  <default name="spp" value="16"/>
  <default name="g" value="0.9"/>
  <integrator type="volpath"><integer name="max_depth" value="64"/><integer name="rr_depth" value="1000"/></integrator>
  <sensor type="perspective">
    <float name="fov" value="45"/>
    <string name="fov_axis" value="smaller"/>
    <transform name="to_world"><lookat origin="1, 2, 3" target="0 0 0" up="0, 0, 1"/></transform>
    <sampler type="independent"><integer name="sample_count" value="$spp"/></sampler>
    <film type="hdrfilm">
      <integer name="width" value="320"/><integer name="height" value="240"/>
      <integer name="crop_offset_x" value="10"/><integer name="crop_width" value="100"/>
      <rfilter type="tent"/>
    </film>
    <ref name="medium" id="fog"/>
  </sensor>
  <medium type="homogeneous" id="fog">
    <spectrum name="sigma_t" value="400:1, 700:0.5"/>
    <rgb name="albedo" value="0.5, 0.6, 0.7"/>
    <float name="scale" value="2"/>
    <phase type="blendphase">
      <float name="weight" value="0.25"/>
      <phase type="hg"><float name="g" value="$g"/></phase>
      <phase type="tabphase"><string name="values" value="1, 2, 3"/></phase>
    </phase>
  </medium>
  <bsdf type="roughdielectric" id="glass">
    <string name="int_ior" value="water"/><float name="ext_ior" value="1"/>
    <string name="distribution" value="ggx"/><float name="alpha" value="0.2"/>
  </bsdf>
  <shape type="sphere" id="ball">
    <point name="center" x="1" y="2" z="3"/><float name="radius" value="0.5"/>
    <ref id="glass"/>
    <ref name="exterior" id="fog"/>
    <medium name="interior" type="homogeneous"><float name="sigma_t" value="3"/></medium>
  </shape>
  <shape type="rectangle">
    <transform name="to_world"><scale value="2"/><rotate x="0.6" y="0.8" angle="30"/><translate x="1" y="2"/></transform>
    <bsdf type="twosided"><bsdf type="diffuse"><rgb name="reflectance" value=".1 .2 .3"/></bsdf></bsdf>
    <emitter type="area"><spectrum name="radiance" type="blackbody"><float name="temperature" value="3000"/></spectrum></emitter>
  </shape>
  <emitter type="spot"><spectrum name="intensity" value="4"/></emitter>
  <emitter type="directional"><vector name="direction" value="0, 0, -2"/><float name="irradiance" value="3"/></emitter>
</scene>
"#;

fn read_with(text: &str, set: &[(&str, &str)]) -> Result<Description> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.xml");
    std::fs::write(&path, text).unwrap();
    let set: Vec<_> = set.iter().map(|(k, v)| ((*k).to_owned(), (*v).to_owned())).collect();
    read_mitsuba(&path, &set)
}

fn read(text: &str) -> Result<Description> {
    read_with(text, &[])
}

/// A scene with a camera and this in it, on line 2.
fn with(inside: &str) -> Result<Description> {
    read(&format!("<scene version=\"3.0.0\"><sensor type=\"perspective\"/>\n{inside}</scene>"))
}

fn near(found: &Transform, expected: [[f64; 4]; 3]) {
    for (f, e) in found.0.iter().flatten().zip(expected.iter().flatten()) {
        assert!((f - e).abs() < 1e-5, "{found:?}");
    }
}

use crate::scene::Transform;

#[test]
fn a_scene_is_read_whole() {
    let scene = read(SCENE).unwrap();
    assert_eq!((scene.title.as_str(), scene.shapes.len(), scene.lights.len(), scene.media.len()), ("scene", 2, 2, 2));
    let camera = &scene.camera;
    assert_eq!((camera.size, camera.crop, camera.spp), ([320, 240], Some([10, 0, 100, 240]), Some(16)));
    assert_eq!((camera.fov_axis, camera.fov, camera.max_depth), (FovAxis::Smaller, 45_f64.to_radians(), Some(64)));
    assert_eq!((camera.filter, camera.medium), (ReconstructionFilter::Tent { radius: 1.0 }, Some(0)));
    let MediumKind::Homogeneous(fog) = &scene.media[0].kind else { panic!("{:?}", scene.media[0]) };
    assert_eq!((scene.media[0].name.as_str(), fog.scale), ("fog", 2.0));
    let Coefficients::ExtinctionAlbedo { extinction: Spectrum::Sampled { nodes, outside }, albedo } = &fog.coefficients
    else {
        panic!("{fog:?}")
    };
    assert_eq!(*outside, Outside::Zero);
    assert!((nodes[0].0 - 400e-9).abs() < 1e-20 && nodes[1].1 == 0.5);
    assert_eq!(*albedo, Spectrum::Rgb { rgb: [0.5, 0.6, 0.7], kind: RgbKind::Reflectance });
    let Phase::Blend { weight: BlendWeight::Constant(weight), a, b } = &fog.phase else { panic!("{:?}", fog.phase) };
    assert_eq!((*weight, &**a), (0.25, &Phase::HenyeyGreenstein { g: 0.9 }));
    // Forward is at the end, as Mitsuba 3.9.1 evaluates it.
    assert_eq!(**b, Phase::Tabulated { cosines: vec![-1.0, 0.0, 1.0], values: vec![1.0, 2.0, 3.0] });
    let ball = &scene.shapes[0];
    assert_eq!(
        (ball.name.as_str(), ball.interior, ball.exterior, ball.changes_medium),
        ("ball", Some(1), Some(0), true)
    );
    assert_eq!(ball.geometry, Geometry::Sphere { centre: [1.0, 2.0, 3.0], radius: 0.5 });
    let (interior, exterior) = (Some(Spectrum::Constant(1.333)), Some(Spectrum::Constant(1.0)));
    assert_eq!(ball.finish, Finish::Dielectric { interior, exterior, roughness: 0.2 });
    let lamp = &scene.shapes[1];
    assert_eq!(lamp.emission, Some(Spectrum::Blackbody { temperature: 3000.0, scale: 1.0 }));
    assert!(matches!(lamp.finish, Finish::Diffuse { two_sided: true, .. }) && !lamp.changes_medium);
    let Light::Spot { cutoff, beam_width, direction, .. } = &scene.lights[0] else { panic!("{:?}", scene.lights) };
    assert_eq!((*cutoff, *beam_width, *direction), (20_f64.to_radians(), 15_f64.to_radians(), [0.0, 0.0, 1.0]));
    let irradiance = Spectrum::Rgb { rgb: [3.0; 3], kind: RgbKind::Illuminant };
    assert_eq!(scene.lights[1], Light::Directional { direction: [0.0, 0.0, -1.0], irradiance });
}

/// What Mitsuba 3.9.1 prints for the same steps.
#[test]
fn transforms_are_those_of_mitsuba() {
    let scene = read(SCENE).unwrap();
    near(
        &scene.camera.to_world,
        [
            [0.894427, -0.358569, -0.267261, 1.0],
            [-0.447214, -0.717137, -0.534522, 2.0],
            [0.0, 0.597614, -0.801784, 3.0],
        ],
    );
    near(
        &scene.shapes[1].to_world,
        [[1.82851, 0.128616, 0.8, 1.0], [0.128616, 1.90354, -0.6, 2.0], [-0.8, 0.6, 1.73205, 0.0]],
    );
    let scene = with(
        "<shape type='disk'><transform name='to_world'><matrix value='1 0 0 5 0 2 0 0 0 0 3 0 0 0 0 1'/>\
         <rotate value='0,0,1' angle='90'/></transform></shape>",
    );
    near(&scene.unwrap().shapes[0].to_world, [[0.0, -2.0, 0.0, 0.0], [1.0, 0.0, 0.0, 5.0], [0.0, 0.0, 3.0, 0.0]]);
}

#[test]
fn a_camera_without_a_view_has_that_of_a_lens_of_fifty_millimetres() {
    let camera = with("").unwrap().camera;
    // Mitsuba 3.9.1 prints 38.1848 degrees across 768 of 768 by 576 pixels, whose diagonal is 960.
    let across = 2.0 * ((camera.fov / 2.0).tan() * 768.0 / 960.0).atan();
    assert!((across.to_degrees() - 38.1848).abs() < 1e-4, "{}", across.to_degrees());
    assert_eq!(camera.fov_axis, FovAxis::Diagonal);
}

/// Mitsuba 3.9.1 sees the direction of the axis at 0.4, 0.3 of width and height.
#[test]
fn the_axis_moves_against_the_offset_of_the_film() {
    let camera = "<float name='principal_point_offset_x' value='0.1'/><float name='principal_point_offset_y' value='0.2'/>\
                  <film type='hdrfilm'><rfilter type='mitchell'><float name='B' value='0.1'/></rfilter></film>";
    let scene = read(&format!("<scene version='3.0.0'><sensor type='perspective'>{camera}</sensor></scene>")).unwrap();
    assert_eq!(scene.camera.principal_point, [-0.1, -0.2]);
    assert_eq!(scene.camera.filter, ReconstructionFilter::Mitchell { b: 0.1, c: 1.0 / 3.0 });
}

#[test]
fn values_given_go_before_defaults() {
    let scene = read_with(SCENE, &[("spp", "1"), ("g", "-0.5")]).unwrap();
    assert_eq!(scene.camera.spp, Some(1));
    let MediumKind::Homogeneous(fog) = &scene.media[0].kind else { panic!() };
    assert!(matches!(&fog.phase, Phase::Blend { a, .. } if **a == Phase::HenyeyGreenstein { g: -0.5 }));
}

#[test]
fn files_are_included_and_found() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    std::fs::create_dir(at("parts")).unwrap();
    std::fs::write(at("parts/glass.xml"), "<scene version='3.0.0'><bsdf type='dielectric' id='glass'/></scene>")
        .unwrap();
    std::fs::write(at("white.spd"), "# nm\n400 1.0\n700 0.5 # red\n").unwrap();
    let text = "<scene version='3.0.0'><include filename='parts/glass.xml'/><sensor type='perspective'/>\
                <alias id='glass' as='window'/><shape type='cube'><ref id='window'/></shape>\
                <emitter type='point'><spectrum name='intensity' filename='white.spd'/></emitter></scene>";
    std::fs::write(at("scene.xml"), text).unwrap();
    let scene = read_mitsuba(&at("scene.xml"), &[]).unwrap();
    assert!(matches!(scene.shapes[0].finish, Finish::Dielectric { roughness: 0.0, .. }));
    let Light::Point { intensity: Spectrum::Sampled { nodes, .. }, .. } = &scene.lights[0] else { panic!() };
    assert_eq!(nodes.iter().map(|n| n.1).collect::<Vec<_>>(), [1.0, 0.5]);
    // A file that includes itself.
    std::fs::write(at("scene.xml"), "<scene version='3.0.0'><include filename='scene.xml'/></scene>").unwrap();
    assert!(read_mitsuba(&at("scene.xml"), &[]).unwrap_err().message.contains("more than 15 deep"));
}

#[test]
fn what_is_not_supported_is_named_with_its_place() {
    for (inside, pointed, words) in [
        ("<shape type='sphere'><float name='raduis' value='1'/></shape>", "raduis", "`raduis`|radius"),
        ("<shape type='spheer'/>", "spheer", "`spheer`|did you mean `sphere`?"),
        ("<bsdf type='principled'/>", "principled", "`principled`|diffuse"),
        ("<shape type='sphere'><ref id='glas'/></shape><bsdf type='dielectric' id='glass'/>", "glas", "`glas`|`glass`"),
        ("<shape type='sphere'><float name='radius' value='one'/></shape>", "one", "`one` is not a number"),
        ("<shape type='sphere'><float name='radius' value='-1'/></shape>", "-1", "more than 0"),
        ("<shap type='sphere'/>", "<shap type='sphere'/>", "`shap`|`shape`"),
        (
            "<medium type='homogeneous'><rgb name='albedo' value='2'/></medium>",
            "<rgb name='albedo' value='2'/>",
            "more than 1",
        ),
        ("<medium type='homogeneous'><float name='sigma_s' value='2'/></medium>", "sigma_s", "`sigma_s`|sigma_t"),
        ("<shape type='ply'><string name='filename' value='a.ply'/></shape>", "a.ply", "a.ply"),
        ("<bsdf type='roughdielectric'/>", "<bsdf type='roughdielectric'/>", "`beckmann`|ggx"),
        ("<bsdf type='conductor'><string name='material' value='Au'/></bsdf>", "Au", "`Au`|`eta` and `k`"),
        ("<bsdf type='dielectric'><string name='int_ior' value='glass'/></bsdf>", "glass", "`glass`|bk7"),
        ("<emitter type='area'/>", "<emitter type='area'/>", "inside the shape"),
        (
            "<shape type='sphere'><transform name='to_world'><scale x='0'/></transform></shape>",
            "<transform name='to_world'>",
            "undone",
        ),
        ("<shape type='sphere'><ref id='$x'/></shape>", "$x", "`$x` has no value"),
        (
            "<bsdf type='diffuse'><texture name='reflectance' type='bitmap'/></bsdf>",
            "<texture name='reflectance' type='bitmap'/>",
            "textures",
        ),
        ("<bsdf type='null'><rotate/></bsdf>", "<rotate/>", "no `rotate`"),
        (
            "<shape type='disk'><transform name='to_world'><rotate x='1' y='1' angle='9'/></transform></shape>",
            "<rotate x='1' y='1' angle='9'/>",
            "should be 1|shear",
        ),
        ("hello", "hello", "text"),
        ("<shape type='sphere' id='a'/><shape type='sphere' id='a'/>", "a", "taken"),
        ("<bsdf type='null' id='a'/><phase type='hg'><float name='g' value='1'/></phase>", "1", "between -1 and 1"),
    ] {
        let error = with(inside).unwrap_err();
        let said = format!("{error} {}", error.help.clone().unwrap_or_default());
        words.split('|').for_each(|w| assert!(said.contains(w), "`{said}` does not say `{w}`"));
        assert_eq!((error.line, &error.text[error.span.clone()]), (2, pointed), "{said}");
    }
    assert!(read("<scene version='0.6.0'/>").unwrap_err().message.contains("0.6.0"));
    assert!(read("<scene version='3.0.0'/>").unwrap_err().message.contains("no camera"));
    assert!(read("").unwrap_err().message.contains("no element"));
}

#[test]
fn bombs_do_not_go_off() {
    let bomb =
        "<?xml version='1.0'?><!DOCTYPE b [<!ENTITY a 'aaaaaaaaaa'><!ENTITY b '&a;&a;&a;&a;'>]><scene version='&b;'/>";
    assert!(read(bomb).unwrap_err().message.contains("document types"));
    assert!(with("<bsdf type='&lol;'/>").is_err());
    let deep = format!("{}{}", "<bsdf type='twosided'>".repeat(10_000), "</bsdf>".repeat(10_000));
    assert!(with(&deep).unwrap_err().message.contains("64 deep"));
    let mut doubling = String::from("<default name='a0' value='xxxxxxxxxxxxxxxx'/>");
    (1..60).for_each(|n| doubling += &format!("<default name='a{n}' value='$a{0}$a{0}'/>", n - 1));
    assert!(with(&doubling).unwrap_err().message.contains("16 MiB"));
    let ring = "<bsdf type='twosided' id='a'><ref id='a'/></bsdf><shape type='sphere'><ref id='a'/></shape>";
    assert!(with(ring).is_err());
    let ring = "<phase type='blendphase' id='a'><float name='weight' value='.5'/><ref id='a'/><ref id='a'/></phase>";
    assert!(with(ring).unwrap_err().message.contains("16 deep"));
}

#[test]
fn a_grid_may_be_named() {
    let folder = tempfile::tempdir().unwrap();
    let mut bytes = b"VOL\x03".to_vec();
    [1, 2, 1, 1, 1].iter().for_each(|w: &i32| bytes.extend(w.to_le_bytes()));
    [0.0, 0.0, 0.0, 4.0, 1.0, 1.0, 5.0, 6.0_f32].iter().for_each(|c| bytes.extend(c.to_le_bytes()));
    std::fs::write(folder.path().join("cloud.vol"), bytes).unwrap();
    let text = "<scene version='3.0.0'><sensor type='perspective'/><medium type='heterogeneous' id='cloud'>\
                <volume type='gridvolume' name='sigma_t'><string name='filename' value='cloud.vol'/>\
                <boolean name='use_grid_bbox' value='true'/><string name='filter_type' value='nearest'/>\
                <transform name='to_world'><translate z='1'/></transform></volume>\
                <float name='albedo' value='0.9'/><float name='scale' value='10'/></medium></scene>";
    let path = folder.path().join("scene.xml");
    std::fs::write(&path, text).unwrap();
    let scene = read_mitsuba(&path, &[]).unwrap();
    let MediumKind::Grid { optics, density, albedo: None, .. } = &scene.media[0].kind else { panic!() };
    assert_eq!(
        (optics.scale, density.values.as_slice(), density.filter),
        (10.0, [5.0, 6.0].as_slice(), GridFilter::Nearest)
    );
    assert_eq!(density.to_world.point([1.0, 0.0, 0.0]), [4.0, 0.0, 1.0]);
}

#[test]
fn a_medium_needs_a_closed_surface() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("open.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    let path = folder.path().join("scene.xml");
    let scene = |inside: &str| {
        let shape = format!("<shape type='obj'><string name='filename' value='open.obj'/>{inside}</shape>");
        std::fs::write(&path, format!("<scene version='3'><sensor type='perspective'/>{shape}</scene>")).unwrap();
        read_mitsuba(&path, &[])
    };
    assert!(matches!(&scene("").unwrap().shapes[0].geometry, Geometry::Mesh(mesh) if mesh.triangles.len() == 1));
    let error = scene("<medium name='interior' type='homogeneous'/>").unwrap_err();
    assert!(error.message.contains("not closed: 3 of its edges"), "{error}");
}

proptest! {
    #[test]
    fn damaged_scenes_end_in_an_answer(at in 0.0..1.0_f64, byte: u8, kind in 0..3_u8, more in 0.0..1.0_f64) {
        let mut bytes = SCENE.as_bytes().to_vec();
        crate::testing::damage(&mut bytes, at, byte, kind, more);
        let _ = read(&String::from_utf8_lossy(&bytes));
    }
}
