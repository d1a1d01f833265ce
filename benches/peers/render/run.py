"""The same scene files in Mitsuba 3 and in mieux: do the pictures agree, and which costs less at equal noise?

Each program renders every scene RUNS times with other seeds. Means over blocks of 16 x 16 pixels are compared by the
standard errors of both; the noise of one run (variance over runs by squared mean) times its processor time is the price.
"""
import argparse
import json
import resource
import subprocess
import tempfile
from pathlib import Path

import mitsuba as mi
import numpy as np

# Scene, values of its names, samples per pixel of one run: Mitsuba, mieux.
CASES = {
    "milk-sphere": ("milk-sphere", {}, 4, 16),
    "milk-sphere-spectral": ("milk-spectral", {}, 4, 16),
    "fog-lamp-outside": ("fog-lamp", {"x": 1.5}, 16, 16),
    "fog-lamp-inside": ("fog-lamp", {"x": 0.3}, 16, 16),
    "cloud": ("cloud", {}, 8, 8),
    "bow": ("bow", {}, 16, 16),
    "nested": ("nested", {}, 16, 16),
    "mesh": ("mesh", {}, 16, 16),
}
HERE = Path(__file__).parent


def seconds(who):
    use = resource.getrusage(who)
    return use.ru_utime + use.ru_stime


def mitsuba(scene, values, spp, runs, spectral):
    mi.set_variant("scalar_spectral" if spectral else "scalar_rgb")
    loaded = mi.load_file(str(HERE / "scenes" / f"{scene}.xml"), spp=spp, **values)
    pictures, spent = [], []
    for run in range(runs):
        start = seconds(resource.RUSAGE_SELF)
        image = mi.render(loaded, spp=spp, seed=run + 1)
        pictures.append(np.array(mi.Bitmap(image).convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32, False)))
        spent.append(seconds(resource.RUSAGE_SELF) - start)
    return np.array(pictures), np.mean(spent)


def mieux(program, scene, values, spp, runs):
    pictures, spent = [], []
    with tempfile.TemporaryDirectory() as folder:
        sets = [word for k, v in values.items() for word in ("--set", f"{k}={v}")]
        path = HERE / "scenes" / f"{scene}.xml"
        start = seconds(resource.RUSAGE_CHILDREN)
        command = [program, "render", str(path), *sets, "--spp", "1", "-o", folder]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        # Reading the scene and writing the pictures is not what is compared.
        fixed = seconds(resource.RUSAGE_CHILDREN) - start
        for run in range(runs):
            start = seconds(resource.RUSAGE_CHILDREN)
            command = [program, "render", str(path), *sets, "--spp", str(spp), "--seed", str(run + 1), "-o", folder]
            subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
            spent.append(seconds(resource.RUSAGE_CHILDREN) - start - fixed * (1 - 1 / spp))
            image = mi.Bitmap(str(Path(folder) / "picture.exr"))
            names = [c.name for c in image.struct_()]
            data = np.array(image).astype(np.float32)
            pictures.append(np.stack([data[..., names.index(c)] for c in ("R", "G", "B")], -1))
    return np.array(pictures), np.mean(spent)


def price(pictures, spent):
    mean = pictures.mean(0).mean(-1)
    variance = pictures.mean(-1).var(0, ddof=1)
    return float((variance / (mean**2 + 1e-2 * mean.mean() ** 2)).mean()), spent


def blocks(pictures):
    runs, height, width, _ = pictures.shape
    whole = pictures.mean(-1)[:, : height // 16 * 16, : width // 16 * 16]
    return whole.reshape(runs, height // 16, 16, width // 16, 16).mean((2, 4))


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--mieux", default="mieux")
    parser.add_argument("--runs", type=int, default=16)
    parser.add_argument("--only", nargs="*")
    parser.add_argument("--values", type=Path)
    args = parser.parse_args()
    results = {}
    print(f"{'scene':24}{'blocks beyond 3 errors':>24}{'worst':>7}{'bias %':>8}{'noise x s: Mitsuba':>20}{'mieux':>10}{'ratio':>8}")
    for name, (scene, values, theirs, ours) in CASES.items():
        if args.only and name not in args.only:
            continue
        a, spent_a = mitsuba(scene, values, theirs, args.runs, "spectral" in name)
        b, spent_b = mieux(args.mieux, scene, values, ours, args.runs)
        ba, bb = blocks(a), blocks(b)
        off = bb.mean(0) - ba.mean(0)
        error = np.sqrt((ba.var(0, ddof=1) + bb.var(0, ddof=1)) / args.runs)
        z = off / np.maximum(error, 1e-12)
        (noise_a, _), (noise_b, _) = price(a, spent_a), price(b, spent_b)
        pa, pb = noise_a * spent_a, noise_b * spent_b
        bias = 100 * (b.mean() / a.mean() - 1)
        print(f"{name:24}{(abs(z) > 3).sum():>14} of {z.size:<7}{abs(z).max():>7.2f}{bias:>8.2f}{pa:>20.4g}{pb:>10.4g}{pa / pb:>8.2f}", flush=True)
        results[name] = {"worst_z": float(abs(z).max()), "beyond": int((abs(z) > 3).sum()), "blocks": int(z.size), "bias_percent": float(bias), "mitsuba": pa, "mieux": pb, "ratio": pa / pb, "seconds": [spent_a, spent_b], "noise": [noise_a, noise_b]}
    if args.values:
        args.values.write_text(json.dumps(results, indent=1))


if __name__ == "__main__":
    main()
