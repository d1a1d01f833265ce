"""The cases of `mie_oracle.py`: wavelength, host and layers as doubles, in groups by what makes them hard."""

import itertools
import math
from dataclasses import dataclass

MICROMETRE = 1e-6
EXACT = 2.0**-20  # a wavelength that makes x = pi j exact for radii j 2^-21 in vacuum


@dataclass
class Case:
    id: str
    group: str
    wavelength: float
    host: complex
    layers: list  # (radius, re, im) from the core outwards


def radius(x, host, wavelength):
    """Of the size parameter wanted, which the double then misses by its rounding."""
    return x * wavelength / (2 * math.pi * abs(host))


def all_cases():
    cases = []
    counts = {}

    def add(group, wavelength, host, layers):
        counts[group] = counts.get(group, 0) + 1
        host = complex(host)
        layers = [(float(r), complex(m).real, complex(m).imag) for r, m in layers]
        cases.append(Case(f"{group}-{counts[group]:03}", group, float(wavelength), host, layers))

    def sphere(group, x, m, host=1.0, wavelength=0.55e-6):
        """By relative index m where the host is vacuum, else m is the particle's own index."""
        add(group, wavelength, host, [(radius(x, host, wavelength), m)])

    def layered(group, x, fractions, indices, host=1.0, wavelength=0.55e-6):
        outer = radius(x, host, wavelength)
        add(group, wavelength, host, [(outer * f, m) for f, m in zip(fractions, indices)])

    homogeneous(sphere, add)
    absorbing_hosts(sphere, add)
    layers(layered, add)
    large(sphere)
    return cases


def homogeneous(sphere, add):
    product = itertools.product
    sizes = (1e-8, 1e-6, 1e-4, 1e-3, 0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 1e3, 1e4)
    for m, x in product((1.5, 1.5 + 0.01j, 1.33 + 1e-8j, 0.75), sizes):
        sphere("grid", x, m)
    for m, x in product((1 + 1e-10, 1 + 1e-6, 1.0001, 1 - 1e-8, 1.0001 + 1e-7j), (1e-6, 0.1, 1.0, 31.4, 100.0, 1e4)):
        sphere("near-one", x, m)
    for m, x in product((0.05, 0.2, 0.5, 0.9, 0.99, 0.05 + 1e-3j), (1e-3, 1.0, 7.7, 50.0, 1e3)):
        sphere("below-one", x, m)
    for m, x in product((3.5, 10.0, 20.0, 10 + 10j, 20 + 0.1j, 4 + 1e-6j), (1e-4, 0.01, 0.3, 3.0, 40.0, 500.0)):
        sphere("high-index", x, m)
    metals = (0.05 + 3j, 1.5 + 7j, 0.01 + 5j, 0.2 + 3.5j, 1e-3 + 20j)
    for m, x in product(metals, (1e-6, 0.01, 0.3, 1.0, 10.0, 100.0, 1e4)):
        sphere("metal", x, m)
    plasmons = (1e-6 + 1.4142135623730951j, 0.01 + 1.4142135623730951j, 0.1 + 1.42j, 1e-3 + 1.224744871391589j)
    for m, x in product(plasmons, (1e-4, 0.01, 0.1, 0.5)):
        sphere("plasmon", x, m)
    for im, x in product((1e-14, 1e-12, 1e-10, 1e-8, 1e-6, 1e-4, 1e-3), (1e-4, 0.5, 10.0, 1e3)):
        sphere("weak-absorption", x, complex(1.5, im))

    # Poles of one coefficient on the real axis but for their width, by root search with 40 digits.
    resonances = (
        (33.22454562438709663, 1.5, 5.85e-3),  # b_39
        (33.62309562106802633, 1.5, 0.01),  # a_39
        (33.26216890994190374, 1.5, 7.56e-6),  # b_44
        (33.02972772893527879, 1.5, 1.63e-5),  # a_43
        (8.625892426875883345, 3.5, 6.86e-19),  # b_25
        (9.982939462788032995, 3.5, 5.97e-16),  # b_25
        (4.594894552418860903, 3.5, 5.45e-9),  # b_12
        (5.749449288177582887, 3.5, 6.8e-7),  # b_12
        (2.313252810748155659, 3.5, 4.67e-4),  # b_5
        (7.383459206002858291, 3.5, 3.24e-15),  # a_20
        (36.38753225115721257, 2.0, 2.25e-16),  # b_60
        (38.92880564549371733, 2.0, 1.2e-13),  # b_60
        (90.94541809522415352, 1.5, 2.37e-14),  # a_120
        (94.99420326371665522, 1.5, 1.96e-11),  # a_120
        (0.3113044751585564478, 10.0, 1.78e-3),  # b_1
        (0.4545195906873339315, 20.0, 1.88e-7),  # b_3
        (982.4840637688306067, 1.33, 2.42e-15),  # b_1050
    )
    for x, m, width in resonances:
        sphere("resonance", x, m, wavelength=EXACT)
        sphere("resonance", x + max(width, 4e-16 * x), m, wavelength=EXACT)
    for x, m in ((33.26216890994190374, 1.5 + 1e-9j), (4.594894552418860903, 3.5 + 1e-10j), (38.92880564549371733, 2 + 1e-14j)):
        sphere("resonance", x, m, wavelength=EXACT)

    # sin x or sin y is zero but for the rounding of pi; half radii make the cosine vanish.
    for j, m in product((1, 2, 10, 100, 1000), (1.5, 2.0, 1.33 + 1e-5j)):
        add("pi-multiple", EXACT, 1.0, [(j * EXACT / 2, m)])
    for j, m in ((1, 1.5), (21, 1.5), (201, 2.0)):
        add("pi-multiple", EXACT, 1.0, [(j * EXACT / 4, m)])
    for j in (1, 7, 50):
        add("pi-multiple", EXACT, 1.0, [(j * EXACT / 8, 4.0)])


def absorbing_hosts(sphere, add):
    product = itertools.product
    for im, m in product((1e-12, 1e-9, 1e-6, 1e-4, 1e-2, 0.1, 1.0), (1.5, 1.5 + 0.01j, 1.0, 1.33)):
        for x in (0.1, 10.0) if im < 1 else (0.01, 3.0):
            sphere("absorbing-host", x, m, complex(1.33, im))
    for im, x in product((1e-12, 1e-9, 1e-6), (1e-7, 1e-5, 1e-3, 1e-2)):
        sphere("small-in-host", x, 1.5, complex(1.33, im))
    for x in (1e-5, 1e-2):
        sphere("small-in-host", x, 0.05 + 3j, 1.33 + 1e-6j)
        sphere("small-in-host", x, 1.0, 1.33 + 1e-4j)
        sphere("small-in-host", x, 1.3300001 + 3e-9j, 1.33 + 1e-9j)
    for r, wavelength in product((5e-9, 5e-8, 5e-7, 1e-6, 5e-6, 5e-5), (4e-7, 7e-7)):
        add("milk", wavelength, 1.33 + 1e-9j, [(r, 1.46 + 1e-6j)])
    for r in (2e-8, 1.4e-7):
        add("milk", 5.5e-7, 1.33 + 6e-8j, [(r, 1.503)])
    for im, x, m in (
        (1e-9, 1e3, 1.0), (1e-6, 1e3, 1.0), (1e-4, 1e3, 1.0), (1e-3, 1e3, 1.0), (1e-2, 1e3, 1.0), (0.05, 66.5, 1.0),
        (0.3, 20.0, 1.0), (1e-7, 1e4, 1.0), (1e-4, 1e4, 1.31),
    ):  # fmt: skip
        sphere("bubble", x, m, complex(1.33, im))
    for k0r, host, m in (
        (1.0, 1.33 + 1j, 1.5), (10.0, 1.33 + 1j, 1.5), (100.0, 1.33 + 1j, 1.5 + 0.1j), (300.0, 1.33 + 1j, 1.5),
        (300.0, 1.33 + 1j, 1.0), (1e3, 1.33 + 0.1j, 1.5 + 0.01j), (3e3, 1.33 + 0.1j, 1.5), (3e3, 1.33 + 0.1j, 0.05 + 3j),
        (1e4, 1.33 + 0.01j, 1.5), (3e4, 1.33 + 0.01j, 1.5 + 1e-3j), (1e4, 1.33 + 0.03j, 1.33 + 0.03j + 1e-6),
        (50.0, 1.33 + 0.5j, 1.33), (150.0, 1.5 + 1j, 20 + 0.1j),
    ):  # fmt: skip
        add("deep-host", EXACT, host, [(k0r * EXACT / (2 * math.pi), m)])


def layers(layered, add):
    product = itertools.product
    for x, count in product((0.1, 5.0, 50.0, 1e3), (1, 2, 5, 20)):
        layered("layers-equal", x, [(i + 1) / count for i in range(count)], [1.5 + 0.01j] * count)
    for shell, x in product((1.33 + 0.1j, 0.2 + 3j, 1.33), (1e-2, 1.0, 30.0, 1e3)):
        layered("thin-shell", x, (1 - 1e-6, 1.0), (1.5, shell))
    for fraction, x in product((0.1, 0.5, 0.9, 0.999), (0.05, 1.0, 10.0, 200.0)):
        layered("soot-water", x, (fraction, 1.0), (1.75 + 0.44j, 1.33))
    for metal, x in product((0.2 + 3.5j, 0.05 + 3j), (1e-4, 0.01, 0.3, 1.0, 5.0, 100.0)):
        layered("metal-shell", x, (0.9, 1.0), (1.45, metal))
    for x, (fraction, shell) in product((1e-4, 0.1, 3.0, 50.0, 1e4), ((0.5, 1.5 + 0.01j), (0.99, 1.33))):
        layered("hollow", x, (fraction, 1.0), (1.0, shell))
    for core, x in product((1.5 + 7j, 3 + 3j), (1.0, 50.0, 1e3, 1e4)):
        layered("dark-core", x, (0.7, 1.0), (core, 1.5))
    for x in (100.0, 1e3):
        layered("dark-core", x, (0.5, 1.0), (1.33, 1.5 + 1j))  # a shell that hides the core
        layered("dark-core", x, (0.005, 1.0), (1.33, 1.34))
    for count, x in product((3, 5, 10, 20), (1e-4, 0.1, 1.0, 10.0, 100.0, 1e3)):
        fractions = [(i + 1) / count for i in range(count)]
        if x in (0.1, 10.0):
            indices = [1.5 - 0.17 * i / count for i in range(count)]  # graded, lossless
        else:
            indices = [(1.33 + 0.001j, 1.5 + 0.01j)[i % 2] for i in range(count)]
        layered("many-layers", x, fractions, indices)
    layered("many-layers", 1e4, (0.3, 0.6, 0.9, 1.0), (1.75 + 0.44j, 1.33, 1.5 + 1e-3j, 1.4))
    for x in (0.5, 4.0, 20.0):
        layered("many-layers", x, (0.4642, 0.7114, 0.7393, 0.9168, 1.0), (1.8 + 1.7j, 0.8 + 0.7j, 1.2 + 0.09j, 2.8 + 0.2j, 1.5 + 0.4j))
    for im, x in product((1e-9, 1e-4, 1e-2, 0.3), (1e-3, 0.1, 5.0, 100.0)):
        host = complex(1.33, im)
        layered("layered-in-host", x, (0.6, 1.0), (1.75 + 0.44j, 1.45), host)
        layered("layered-in-host", x, (0.95, 1.0), (1.0, 1.46 + 1e-6j), host)  # a bubble with a skin
    for im, x, count in ((1e-6, 1.0, 5), (1e-3, 30.0, 5), (1e-9, 20.0, 20), (1e-2, 60.0, 20), (0.1, 5.0, 10)):
        indices = [(1.4 + 0.001j, 1.5, 1.33 + 0.01j)[i % 3] for i in range(count)]
        layered("layered-in-host", x, [(i + 1) / count for i in range(count)], indices, complex(1.33, im))
    for x in (2.0, 200.0):
        layered("layered-in-host", x, (0.5, 1.0), (1.5 + 0.01j, 1.33 + 0.01j), 1.33 + 0.01j)  # outer layer of the host
        layered("layered-in-host", x, (1 - 1e-6, 1.0), (1.5, 0.2 + 3j), 1.33 + 0.01j)
    layered("layered-in-host", 3e3, (0.5, 1.0), (1.5, 1.45), 1.33 + 0.05j)
    layered("layered-in-host", 1e4, (0.8, 1.0), (1.75 + 0.44j, 1.5), 1.33 + 1e-5j)


def large(sphere):
    for m in (1.33, 1.5 + 0.01j, 1.33 + 1e-8j, 1.5 + 1j, 0.75):
        sphere("large", 1e5, m)
    sphere("large", 1e5, 1.5, 1.33 + 1e-4j)
    sphere("large", 1e5, 1.0, 1.33 + 1e-9j)
    sphere("large", 1e6, 1.5)
    sphere("large", 1e6, 1.33 + 1e-7j)
    sphere("large", 1e6, 1.5 + 0.1j)
