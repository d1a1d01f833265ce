"""Opens what `mieux export` writes with the programs it is written for, and compares what they make of it.

    run.py --mieux target/release/mieux [--only mitsuba materialx usd eradiate cycles gltf] [--samples N]

mitsuba     renders plane-parallel slabs (scalar_spectral) and compares reflectance with `mieux slab`: discrete ordinates and
            photons. Light of all directions falls onto the slab and is looked at along the normal, which by reciprocity is the
            share of normal light that comes back.
materialx   validates the documents against the node library of MaterialX.
usd         opens the stage and finds every shader of the network in MaterialX's library.
eradiate    reads the NetCDF file and checks its phase functions.
cycles      runs the script under bpy and looks at the ball it renders.
gltf        lets bpy import the ball, and looks for its interior.

Ends with 1 if something is not as it should be.
"""

import argparse
import importlib.util
import json
import math
import pathlib
import subprocess
import sys
import tempfile

# Material, settings, thickness in metres, wavelength, whether its surface refracts.
SLABS = [
    ("skim-milk", [], 1e-3, 550, True),
    ("skim-milk", [], 5e-3, 450, True),
    ("skim-milk", [], 5e-3, 650, False),
    ("whole-milk", [], 2e-4, 550, True),
]
WITHIN = 0.01


def run(mieux, *words):
    done = subprocess.run([mieux, *map(str, words)], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"mieux {' '.join(map(str, words))}\n{done.stderr}")
    return done.stdout


def settings(pairs):
    return [word for pair in pairs for word in ("--set", pair)]


def ask_slab(mieux, material, sets, thickness, wavelength, refracts, *more):
    index = [] if refracts else ["--index", "1"]
    text = run(mieux, "slab", material, *settings(sets), "--thickness", f"{thickness}m", "--wavelengths",
               f"{wavelength}nm", *index, "--format", "json", *more)
    answer = json.loads(text)
    first = lambda key: answer[key][0] if isinstance(answer[key], list) else answer[key]
    error = first("reflectance_se") if "reflectance_se" in answer else 0.0
    return first("reflectance"), error


def render_slab(fragment, name, thickness, refracts, samples):
    """Reflectance and its standard error. Lengths in scene units."""
    import mitsuba as mi
    import numpy as np

    boundary = f'<ref id="{name}-boundary"/>' if refracts else '<bsdf type="null"/>'
    # A grey of 1 from all sides; the black ground beneath swallows what passes and hides the light below.
    wide = 2000.0 * thickness
    text = f"""<scene version="3.0.0">
    <include filename="{fragment}"/>
    <integrator type="volpathmis"><integer name="max_depth" value="-1"/><integer name="rr_depth" value="1000000"/></integrator>
    <emitter type="constant"><spectrum name="radiance" type="uniform"><float name="value" value="1"/></spectrum></emitter>
    <shape type="cube"><transform name="to_world"><scale x="{wide}" y="{wide}" z="{0.5 * thickness}"/></transform>
        <ref name="interior" id="{name}"/>{boundary}</shape>
    <shape type="rectangle"><transform name="to_world"><scale x="{4 * wide}" y="{4 * wide}"/><translate z="{-thickness}"/></transform>
        <bsdf type="diffuse"><spectrum name="reflectance" type="uniform"><float name="value" value="0"/></spectrum></bsdf></shape>
    <sensor type="orthographic">
        <transform name="to_world"><lookat origin="0, 0, {3 * thickness}" target="0, 0, 0" up="0, 1, 0"/></transform>
        <film type="hdrfilm"><integer name="width" value="64"/><integer name="height" value="64"/>
            <string name="pixel_format" value="luminance"/>
            <rfilter type="box"/></film>
        <sampler type="independent"><integer name="sample_count" value="{samples}"/></sampler></sensor></scene>"""
    scene = mi.load_string(text)
    shown = np.array(mi.render(scene, seed=1)).reshape(64 * 64, -1)[:, 0]
    # The same light without the slab, for the scale of the film.
    empty = mi.load_string(text[:text.index('<shape type="cube">')] + text[text.index("<sensor"):].replace(
        f'value="{samples}"', 'value="16"'))
    light = np.array(mi.render(empty, seed=2)).reshape(64 * 64, -1)[:, 0].mean()
    return shown.mean() / light, shown.std() / math.sqrt(len(shown)) / light


def mitsuba(mieux, folder, samples):
    import mitsuba as mi

    mi.set_variant("scalar_spectral")
    print(f"mitsuba {mi.__version__}, scalar_spectral: reflectance of a slab in normal light")
    print(f"{'':34}{'mitsuba':>18}{'ordinates':>11}{'photons':>18}{'apart':>9}")
    good = True
    for material, sets, thickness, wavelength, refracts in SLABS:
        # The coefficients in millimetres, to try the scale.
        out = folder / f"mitsuba-{material}-{wavelength}"
        run(mieux, "export", material, *settings(sets), "--to", "mitsuba", "--wavelengths", f"{wavelength}nm", "--scale",
            0.001, "-o", out)
        found, error = render_slab(out / f"{material}.xml", material, thickness * 1e3, refracts, samples)
        truth, _ = ask_slab(mieux, material, sets, thickness, wavelength, refracts)
        walk, walk_error = ask_slab(mieux, material, sets, thickness, wavelength, refracts, "--solver", "monte-carlo",
                                    "--photons", 1000000)
        apart = found / walk - 1
        # Within 1 %, beyond what both leave to chance.
        fine = abs(apart) <= WITHIN + 2 * math.hypot(error, walk_error) / walk
        good &= fine
        name = f"{material} {thickness * 1e3:g} mm {wavelength} nm {'n' if refracts else 'n = 1'}"
        print(f"{name:34}{found:10.5f}±{error:.5f}{truth:11.5f}{walk:10.5f}±{walk_error:.5f}{100 * apart:8.2f}%"
              f"{'' if fine else '  TOO FAR'}")
    # The whole scene, as a user starts with it.
    out = folder / "mitsuba-whole"
    run(mieux, "export", "skim-milk", "--to", "mitsuba", "--scale", 0.01, "-o", out)
    scene = mi.load_file(str(out / "skim-milk-scene.xml"))
    picture = mi.render(scene, spp=4)
    mi.util.write_bitmap(str(folder / "mitsuba-ball.png"), picture)
    print(f"skim-milk-scene.xml loads and renders: {folder / 'mitsuba-ball.png'}")
    return good


def materialx(mieux, folder, _):
    import MaterialX as mx

    library = mx.createDocument()
    mx.loadLibraries(mx.getDefaultDataLibraryFolders(), mx.getDefaultDataSearchPath(), library)
    good = True
    for target, name in [("materialx", "skim-milk.mtlx"), ("openpbr", "skim-milk.openpbr.mtlx")]:
        out = folder / target
        run(mieux, "export", "skim-milk", "--to", target, "-o", out)
        document = mx.createDocument()
        mx.readFromXmlFile(document, str(out / name))
        document.setDataLibrary(library)
        fine, why = document.validate()
        found = [node.getName() for node in document.getNodes() if node.getNodeDef() is None]
        print(f"MaterialX {mx.getVersionString()}: {name} {'is valid' if fine else why}"
              f"{', without definition: ' + ', '.join(found) if found else ', every node is defined'}")
        good &= fine and not found
    return good


def usd(mieux, folder, _):
    import MaterialX as mx
    from pxr import Usd, UsdGeom, UsdShade

    library = mx.createDocument()
    mx.loadLibraries(mx.getDefaultDataLibraryFolders(), mx.getDefaultDataSearchPath(), library)
    run(mieux, "export", "skim-milk", "--to", "usd", "--scale", 0.01, "-o", folder / "usd")
    stage = Usd.Stage.Open(str(folder / "usd" / "skim-milk.usda"))
    good = abs(UsdGeom.GetStageMetersPerUnit(stage) - 0.01) < 1e-9
    for prim in stage.Traverse():
        if prim.IsA(UsdShade.Shader):
            shader = UsdShade.Shader(prim)
            definition = library.getNodeDef(shader.GetIdAttr().Get())
            inputs = {i.getName() for i in definition.getActiveInputs()} if definition else set()
            good &= definition is not None and all(i.GetBaseName() in inputs for i in shader.GetInputs())
    material = UsdShade.MaterialBindingAPI(stage.GetPrimAtPath("/Ball")).ComputeBoundMaterial()[0]
    surface = material.ComputeSurfaceSource("mtlx")[0]
    volume = material.ComputeVolumeSource("mtlx")[0]
    good &= surface.GetIdAttr().Get() == "ND_surface" and volume.GetIdAttr().Get() == "ND_volume"
    print(f"USD {'.'.join(map(str, Usd.GetVersion()))}: skim-milk.usda {'opens, every shader is MaterialX' if good else 'is wrong'}")
    return good


def eradiate(mieux, folder, _):
    import netCDF4
    import numpy as np

    run(mieux, "export", "skim-milk", "--to", "eradiate", "-o", folder / "eradiate")
    data = netCDF4.Dataset(folder / "eradiate" / "skim-milk.nc")
    mu, phase = np.asarray(data["mu"][:]), np.asarray(data["phase"][0])
    integral = np.trapezoid(phase, mu, axis=1)
    g = np.array([np.trapezoid(p * m, m) / 2 for p, m in zip(phase, mu)])
    good = np.allclose(integral, 2, atol=1e-6) and (np.diff(mu, axis=1) > 0).all() and data["phase"].dimensions == (
        "phamat", "w", "iangle")
    print(f"netCDF4 {netCDF4.__version__}: skim-milk.nc, {mu.shape[1]} angles, g {g[0]:.4f} to {g[-1]:.4f}"
          f"{'' if good else ': WRONG'}")
    return bool(good)


def cycles(mieux, folder, _):
    if importlib.util.find_spec("bpy") is None:
        print("bpy is not here (its wheels are for one version of Python each): Cycles is left out")
        return True
    good = True
    for material, more in [("skim-milk", []), ("whole-milk", ["--isotropic"])]:
        out = folder / f"cycles-{material}"
        run(mieux, "export", material, "--to", "cycles", *more, "-o", out)
        picture = folder / f"cycles-{material}.png"
        done = subprocess.run([sys.executable, out / f"{material}.py", "--test", picture], capture_output=True, text=True)
        fine = done.returncode == 0 and picture.exists()
        if fine:
            import bpy
            pixels = bpy.data.images.load(str(picture)).pixels[:]
            inside = [4 * (64 * y + x) for y in range(24, 40) for x in range(24, 40)]
            middle = [sum(pixels[i + c] for i in inside) / len(inside) for c in range(3)]
            # A white ball in white light: neither black nor a hole.
            fine = all(0.3 < v <= 1.0 for v in middle)
            print(f"bpy {bpy.app.version_string}: {material}.py renders {picture}, {[round(v, 3) for v in middle]} (sRGB) in the middle")
        if not fine:
            print(f"{material}.py under bpy: {done.stderr[-2000:]}")
        good &= fine
    return good


def gltf(mieux, folder, _):
    if importlib.util.find_spec("bpy") is None:
        print("bpy is not here: glTF is left out")
        return True
    import bpy

    run(mieux, "export", "skim-milk", "--to", "gltf", "--draft", "-o", folder / "gltf")
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_scene.gltf(filepath=str(folder / "gltf" / "skim-milk.gltf"))
    balls = [thing for thing in bpy.data.objects if thing.type == "MESH"]
    good = len(balls) == 1 and all(abs(size - 0.04) < 1e-6 for size in balls[0].dimensions)
    nodes = {node.type for node in balls[0].data.materials[0].node_tree.nodes} if good else set()
    good &= "VOLUME_ABSORPTION" in nodes
    print(f"bpy {bpy.app.version_string}: skim-milk.gltf {'is a ball of 4 cm with an interior' if good else 'is WRONG'}")
    return good


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--mieux", default="target/release/mieux")
    parser.add_argument("--only", nargs="*", default=["mitsuba", "materialx", "usd", "eradiate", "cycles", "gltf"])
    parser.add_argument("--samples", type=int, default=64, help="samples per pixel of 4096, for Mitsuba")
    parser.add_argument("--keep", type=pathlib.Path, help="folder for everything that is made")
    arguments = parser.parse_args()
    mieux = str(pathlib.Path(arguments.mieux).resolve())
    with tempfile.TemporaryDirectory() as temporary:
        folder = (arguments.keep or pathlib.Path(temporary)).resolve()
        folder.mkdir(parents=True, exist_ok=True)
        results = [globals()[name](mieux, folder, arguments.samples) for name in arguments.only]
    sys.exit(0 if all(results) else 1)


if __name__ == "__main__":
    main()
