"""Writes what the scenes need beside them: a two-tone sky, a cloud, a mesh of 2 million triangles. All computed, nothing taken."""
import struct
from pathlib import Path

import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")
here = Path(__file__).parent / "scenes"

sky = np.full((64, 128, 3), 0.3, np.float32)
sky[:32] = (0.6, 0.9, 1.4)
mi.Bitmap(sky).write(str(here / "two-tone.exr"))

n = 128
x, y, z = np.meshgrid(*[(np.arange(n) + 0.5) / n * 2 - 1] * 3, indexing="ij")
shape = 0.75 - np.sqrt(x * x + y * y + (1.3 * z) ** 2)
waves = sum(np.sin(k * (x + 0.3 * k)) * np.sin(k * 1.1 * (y - z)) * np.cos(k * 0.9 * (z + x)) / k for k in (4, 9, 17, 31))
density = np.clip(4 * (shape + 0.35 * waves), 0, 1)
thickest = (density.sum(axis=0) * 2 / n).max()
density = (density * 80 / thickest).astype(np.float32)
with open(here / "cloud.vol", "wb") as f:
    f.write(b"VOL\x03" + struct.pack("<5i6f", 1, n, n, n, 1, 0, 0, 0, 1, 1, 1))
    f.write(np.transpose(density, (2, 1, 0)).tobytes())

rows, columns = 1000, 1000
theta = np.linspace(1e-3, np.pi - 1e-3, rows + 1)
phi = np.linspace(0, 2 * np.pi, columns, endpoint=False)
t, p = np.meshgrid(theta, phi, indexing="ij")
r = 1 + 0.08 * np.sin(9 * t) * np.sin(7 * p) + 0.02 * np.sin(60 * t) * np.sin(50 * p)
points = np.stack([r * np.sin(t) * np.cos(p), r * np.sin(t) * np.sin(p), r * np.cos(t)], -1).astype("<f4").reshape(-1, 3)
i, j = np.meshgrid(np.arange(rows), np.arange(columns), indexing="ij")
a, b = i * columns + j, i * columns + (j + 1) % columns
c, d = a + columns, b + columns
faces = np.concatenate([np.stack([a, c, b], -1).reshape(-1, 3), np.stack([b, c, d], -1).reshape(-1, 3)]).astype("<i4")
with open(here / "bumps.ply", "wb") as f:
    f.write(f"ply\nformat binary_little_endian 1.0\nelement vertex {len(points)}\nproperty float x\nproperty float y\nproperty float z\nelement face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n".encode())
    f.write(points.tobytes())
    record = np.zeros(len(faces), dtype=[("n", "u1"), ("v", "<i4", 3)])
    record["n"], record["v"] = 3, faces
    f.write(record.tobytes())
print("cloud: mean density", density.mean(), "most", density.max())
