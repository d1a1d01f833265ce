"""Spheres per second of processor time: the Lorenz-Mie code of mieux beside those of others, one thread each.

    python3 benches/peers/mie/run.py [--mieux EXECUTABLE] [--only WORKLOAD ...] [--peers NAME ...] [--rounds 5]

EXECUTABLE is called as `EXECUTABLE --workload NAME` and prints one line
`{"workload": "NAME", "spheres": N, "cpu_seconds": T}`, optionally with `"checksum": C`, the sum over the spheres of what
`checksum` below sums. See README.md for the workloads.
"""

import os

for _name in ("OMP_NUM_THREADS", "RAYON_NUM_THREADS", "NUMBA_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[_name] = "1"
os.environ["MIEPYTHON_USE_JIT"] = "1"

import argparse
import json
import subprocess
import time
from dataclasses import dataclass

import numpy as np

LIMIT_SECONDS = 2.0  # a peer slower than this for a whole workload gets every k-th sphere instead


@dataclass
class Workload:
    name: str
    text: str
    x: np.ndarray  # size parameters; for layers one row per sphere, from the core outwards
    m: np.ndarray  # relative indices, of the shape of x
    mu: np.ndarray = None  # cosines, where amplitudes are wanted

    def thinned(self, step):
        return Workload(self.name, self.text, np.ascontiguousarray(self.x[::step]), np.ascontiguousarray(self.m[::step]), self.mu)


def log_spaced(low, high, count):
    return np.geomspace(low, high, count)


def homogeneous(name, text, x, m=1.5 + 0.01j, mu=None):
    return Workload(name, text, x, np.full(x.shape, m, dtype=complex), mu)


def table():
    """1 000 radii, 17 wavelengths, lossless dispersive host; the wavelength is the outer loop."""
    radii = log_spaced(0.01, 10.0, 1000)
    wavelengths = np.arange(380.0, 781.0, 25.0)
    host = 1.32 + 3.1e3 / wavelengths**2
    particle = 1.45 + 4.0e3 / wavelengths**2 + 1e-6j
    x = 2 * np.pi * 1e3 * radii[None, :] * host[:, None] / wavelengths[:, None]
    m = np.broadcast_to((particle / host)[:, None], x.shape)
    return x.ravel(), np.ascontiguousarray(m).ravel()


def layered(count):
    outer = log_spaced(1.0, 100.0, 10_000)
    x = outer[:, None] * (np.arange(1, count + 1) / count)[None, :]
    m = np.where(np.arange(count) % 2 == 0, 1.33 + 0.001j, 1.5 + 0.01j)
    return x, np.ascontiguousarray(np.broadcast_to(m, x.shape))


def workloads():
    x_table, m_table = table()
    cosines = np.cos(np.radians(np.arange(1801) / 10.0))
    return [
        homogeneous("spheres-100", "100 000 spheres, x 1..100: Q_ext, Q_sca, g", log_spaced(1.0, 100.0, 100_000)),
        homogeneous("spheres-1000", "100 000 spheres, x 0.1..1000: Q_ext, Q_sca, g", log_spaced(0.1, 1000.0, 100_000)),
        Workload("table-lossless", "1 000 radii, 17 wavelengths, lossless host", x_table, m_table),
        homogeneous("single-1e5", "one sphere, x = 1e5", np.array([1e5])),
        homogeneous("single-1e6", "one sphere, x = 1e6", np.array([1e6])),
        homogeneous("amplitudes", "1 000 spheres, x 1..100: S1, S2 at 1 801 angles", log_spaced(1.0, 100.0, 1000), mu=cosines),
        Workload("layers-2", "10 000 spheres of 2 layers, outer x 1..100", *layered(2)),
        Workload("layers-10", "10 000 spheres of 10 layers, outer x 1..100", *layered(10)),
    ]


# Of mieux alone, beside the peers' table in a lossless host: they cannot do an absorbing one.
ABSORBING = ("table-absorbing", "table-lossless")


# Every peer: a function from a workload to (Q_ext, Q_sca, g) or (S1, S2), None where it has no such thing.


def scatrs_peer():
    from scatrs import layered as layers
    from scatrs import mie

    def run(work):
        module = layers if work.x.ndim == 2 else mie
        if work.mu is not None:
            s = mie.amplitudes(work.x, work.m, work.mu)
            return s.s1, s.s2
        q = module.efficiencies(work.x, work.m, allow_unvalidated=bool(work.x.max() > 2e4))
        return q.q_ext, q.q_sca, q.g

    return run


def sasktran2_peer():
    """Its convention is n - i k; it gives no g."""
    from sasktran2.mie import LinearizedMie

    def run(work):
        if work.x.ndim == 2:
            return None
        mie = LinearizedMie()
        mu = np.array([1.0]) if work.mu is None else work.mu
        # One call an index: those of a table follow one another.
        starts = np.concatenate([[0], np.flatnonzero(np.diff(work.m)) + 1, [len(work.m)]])
        spans = [slice(a, b) for a, b in zip(starts[:-1], starts[1:])]
        parts = [mie.calculate(work.x[s], work.m[s.start].conjugate(), mu).values for s in spans]
        if work.mu is not None:
            return parts[0].S1, parts[0].S2
        return (np.concatenate([p.Qext for p in parts]), np.concatenate([p.Qsca for p in parts]), None)

    return run


def miepython_peer():
    """The compiled kernels of miepython, called from a compiled loop rather than once a sphere from Python."""
    import numba
    from miepython import mie_jit

    kernel, amplitudes = mie_jit._single_sphere_nb, mie_jit._S1_S2_nb

    @numba.njit
    def efficiencies(m, x, out):
        for i in range(len(x)):
            out[0, i], out[1, i], _, out[2, i] = kernel(m[i], x[i], 0, True)

    @numba.njit
    def functions(m, x, mu, s1, s2):
        for i in range(len(x)):
            s1[i], s2[i] = amplitudes(m[i], x[i], mu, 0)

    def run(work):
        if work.x.ndim == 2:
            return None
        m = np.conj(work.m)
        if work.mu is not None:
            s1, s2 = (np.empty((len(work.x), len(work.mu)), dtype=complex) for _ in range(2))
            functions(m, work.x, work.mu, s1, s2)
            return s1, s2
        out = np.empty((3, len(work.x)))
        efficiencies(m, work.x, out)
        return tuple(out)

    return run


def scattnlay_peer():
    from scattnlay import scattnlay

    def run(work):
        x, m = (work.x, work.m) if work.x.ndim == 2 else (work.x[:, None], work.m[:, None])
        if work.mu is not None:
            r = scattnlay(x, m, np.arccos(work.mu))
            return r[8], r[9]
        r = scattnlay(x, m)
        return r[1], r[2], r[6]

    return run


def lxmie_peer():
    """Lists in, lists out; its angles are cosines."""
    import lxmie

    def run(work):
        if work.x.ndim == 2:
            return None
        re, im, x = work.m.real.tolist(), work.m.imag.tolist(), work.x.tolist()
        if work.mu is not None:
            r = lxmie.mie_amplitudes(re, im, x, work.mu.tolist())
            return np.array(r[1]), np.array(r[2])
        results = lxmie.mie(re, im, x)
        return tuple(np.array([getattr(r, name) for r in results]) for name in ("q_ext", "q_sca", "asymmetry_parameter"))

    return run


PEERS = {
    "scatrs": scatrs_peer,
    "sasktran2": sasktran2_peer,
    "miepython": miepython_peer,
    "scattnlay": scattnlay_peer,
    "lxmie": lxmie_peer,
}


def checksum(result):
    """Sum of Q_ext + Q_sca; of amplitudes the sum of |S1|^2 + |S2|^2."""
    first, second = result[0], result[1]
    if np.iscomplexobj(first):
        return float(np.sum(np.abs(first) ** 2) + np.sum(np.abs(second) ** 2))
    return float(np.sum(first) + np.sum(second))


def processor_seconds(function):
    start = time.process_time()
    function()
    return time.process_time() - start


class Contender:
    def __init__(self, name, run, work):
        self.name, self.run, self.best = name, run, float("inf")
        count = len(work.x)
        sample = work.thinned(max(1, count // 100))
        self.result = run(sample)  # compiles what compiles
        self.able = self.result is not None
        if not self.able:
            return
        estimate = processor_seconds(lambda: run(sample)) * count / len(sample.x)
        self.step = max(1, round(estimate / LIMIT_SECONDS))
        self.work = work.thinned(self.step)
        self.spheres = len(self.work.x)
        self.sum = checksum(run(self.work)) if self.step == 1 else None

    def turn(self):
        self.best = min(self.best, processor_seconds(lambda: self.run(self.work)))


class Mieux:
    def __init__(self, executable, workload):
        self.name, self.command, self.workload = "mieux", executable, workload
        self.best, self.sum, self.spheres = float("inf"), None, 0
        self.turn()
        self.best = float("inf")

    def turn(self):
        out = subprocess.run([self.command, "--workload", self.workload], check=True, capture_output=True, text=True).stdout
        for line in out.splitlines():
            if not line.startswith("{"):
                continue
            answer = json.loads(line)
            if answer.get("workload") == self.workload:
                self.spheres = answer["spheres"]
                self.best = min(self.best, answer["cpu_seconds"])
                self.sum = answer.get("checksum")
                return
        raise SystemExit(f"{self.command} printed no line for {self.workload}")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--mieux")
    parser.add_argument("--only", nargs="*")
    parser.add_argument("--peers", nargs="*", default=list(PEERS))
    parser.add_argument("--rounds", type=int, default=5)
    arguments = parser.parse_args()
    runs = {}
    for name in arguments.peers:
        try:
            runs[name] = PEERS[name]()
        except ImportError as error:
            print(f"{name} is left out: {error}")
    for work in workloads():
        if arguments.only and work.name not in arguments.only:
            continue
        contenders = [Contender(name, run, work) for name, run in runs.items()]
        contenders = [c for c in contenders if c.able]
        ours = []
        if arguments.mieux:
            ours.append(Mieux(arguments.mieux, work.name))
            if work.name == ABSORBING[1]:
                ours.append(Mieux(arguments.mieux, ABSORBING[0]))
                ours[-1].name = "mieux, absorbing host"
        for _ in range(arguments.rounds):
            for contender in ours + contenders:
                contender.turn()
        report(work, ours, contenders)


def report(work, ours, contenders):
    print(f"\n{work.name}: {work.text}")
    head = f"  {'':24}{'spheres/s':>12}{'spheres':>9}{'checksum':>22}"
    print(head + "".join(f"{c.name + '/it':>28}" for c in ours))
    for c in sorted(ours + contenders, key=lambda c: -c.spheres / c.best):
        rate = c.spheres / c.best
        total = "" if c.sum is None else f"{c.sum:.14g}"
        ratios = "".join(f"{o.spheres / o.best / rate:>28.2f}" for o in ours)
        print(f"  {c.name:24}{rate:>12.4g}{c.spheres:>9}{total:>22}{ratios}", flush=True)


if __name__ == "__main__":
    main()
