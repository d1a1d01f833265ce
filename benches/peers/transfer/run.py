"""Microseconds of processor time per slab: the transfer solvers of mieux beside those of others, one thread each.

    python3 benches/peers/transfer/run.py [--mieux EXECUTABLE] [--only WORKLOAD ...] [--peers NAME ...] [--rounds 5]
                                          [--values FILE] [--problems FOLDER]

See README.md for the workloads and for how EXECUTABLE is called. `--values` writes every contender's answers as JSON,
`--problems` keeps the files of problems.
"""

import os

for _name in ("OMP_NUM_THREADS", "RAYON_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[_name] = "1"

import argparse
import contextlib
import json
import subprocess
import tempfile
import time
from dataclasses import dataclass, field

import numpy as np

LIMIT_SECONDS = 2.0  # a peer slower than this for a whole workload gets its first problems only


@dataclass
class Workload:
    name: str
    text: str
    task: str  # flux, radiance, adding or inversion
    streams: int
    tau: np.ndarray = None  # optical thickness, albedo and g: a row a problem, a column a layer
    albedo: np.ndarray = None
    g: np.ndarray = None
    measured: np.ndarray = None  # for inversion: reflectance, transmittance, unscattered transmittance
    beam: float = 1.0  # cosine of incidence
    index: float = 1.0
    slides: float = 1.0
    moments: int = 0  # the degree of the last Legendre moment
    correction: bool = False  # that of Nakajima and Tanaka
    cosines: np.ndarray = field(default_factory=lambda: np.empty(0))  # negative: downward
    azimuths: np.ndarray = field(default_factory=lambda: np.empty(0))  # degrees

    @property
    def count(self):
        return len(self.measured if self.task == "inversion" else self.tau)

    def first(self, count):
        cut = {name: value[:count] for name in ("tau", "albedo", "g", "measured") if (value := getattr(self, name)) is not None}
        return Workload(**{**self.__dict__, **cut})

    def chi(self):
        """Legendre moments: problem, layer, degree."""
        return self.g[:, :, None] ** np.arange(self.moments + 1)

    def write(self, file):
        """The form that EXECUTABLE reads."""
        print(f"task {self.task}\nstreams {self.streams}\nbeam {self.beam!r}\nindex {self.index!r}", file=file)
        print(f"slides {self.slides!r}\nmoments {self.moments}\ncorrection {int(self.correction)}", file=file)
        for name in ("cosines", "azimuths"):
            print(name, *(repr(float(x)) for x in getattr(self, name)), file=file)
        rows = self.measured
        if rows is None:
            rows = np.stack([self.tau, self.albedo, self.g], axis=2).reshape(self.count, -1)
        for row in rows:
            print("problem", *(repr(float(x)) for x in row), file=file)


def slabs(seed, count, layers, g_most):
    """Stacks of random layers: total optical thickness 0.01 .. 100 (evenly in the logarithm), albedo 0.1 .. 0.999."""
    random = np.random.default_rng(seed)
    shape = (count, layers)
    share = random.uniform(0.5, 1.5, shape)
    tau = 10 ** random.uniform(-2, 2, (count, 1)) * share / share.sum(axis=1, keepdims=True)
    return {"tau": tau, "albedo": random.uniform(0.1, 0.999, shape), "g": random.uniform(-0.3, g_most, shape)}


def workloads():
    cosines = np.array([0.1, 0.3, 0.5, 0.75, 0.95])
    view = {
        "beam": 0.6,
        "cosines": np.concatenate([-cosines[::-1], cosines]),
        "azimuths": np.array([0.0, 60.0, 120.0, 180.0]),
    }
    measured = np.array([[0.4, 0.1, 0.002], [0.3, 0.2, 0.05], [0.2, 0.4, 0.1], [0.5, 0.1, 0.01]])
    return [
        Workload("flux-16", "16 streams, 1 layer: R, T", "flux", 16, beam=0.6, moments=16, **slabs(1, 2000, 1, 0.95)),
        Workload("flux-32x50", "32 streams, 50 layers: R, T", "flux", 32, beam=0.6, moments=32, **slabs(2, 200, 50, 0.95)),
        Workload("radiance-32", "32 streams, 1 layer: radiance, 10 cosines, 4 azimuths, top and bottom", "radiance", 32,
                 moments=32, **view, **slabs(3, 400, 1, 0.9)),
        Workload("radiance-32-corrected", "the same, corrected after Nakajima and Tanaka with 300 moments", "radiance", 32,
                 moments=300, correction=True, **view, **slabs(3, 400, 1, 0.9)),
        Workload("adding-16", "adding-doubling, 16 points, n = 1.5: R, T of a normal beam and of diffuse light", "adding", 16,
                 moments=32, index=1.5, **slabs(4, 400, 1, 0.95)),
        Workload("inversion-16", "(R, T, unscattered T) to (albedo, tau, g), 16 points, n = 1.4, slides 1.5", "inversion", 16,
                 moments=16, index=1.4, slides=1.5, measured=measured),
    ]


# Every peer: a function that prepares a workload (objects, arrays) and returns (problems done, solve, answers), or None
# where it has no such thing. Only solve() is timed; answers(what it returned) has a row a problem.


def nanodisort_settings(state, work):
    radiance = work.task == "radiance"
    state.nstr, state.nlyr, state.nmom, state.ntau = work.streams, work.tau.shape[1], work.moments, 2
    state.usrtau, state.usrang, state.onlyfl, state.lamber, state.quiet = True, radiance, not radiance, True, True
    state.umu0, state.phi0 = work.beam, 0.0
    state.intensity_correction = state.old_intensity_correction = work.correction
    if radiance:
        state.numu, state.nphi = len(work.cosines), len(work.azimuths)


def depths(work):
    return np.stack([np.zeros(work.count), work.tau.sum(axis=1)], axis=1)


def nanodisort_batch(work):
    """All problems in one call."""
    import nanodisort

    if work.task not in ("flux", "radiance"):
        return None
    solver = nanodisort.BatchSolver(nthreads=1)
    nanodisort_settings(solver, work)
    if work.task == "radiance":
        solver.set_umu(work.cosines)
        solver.set_phi(work.azimuths)
    solver.accur = 0.0
    solver.allocate(work.count)
    chi, levels = np.asfortranarray(work.chi().transpose(2, 1, 0)), depths(work)
    beams, black = np.full(work.count, 1 / work.beam), np.zeros(work.count)

    def solve():
        solver.set_dtauc(work.tau)
        solver.set_ssalb(work.albedo)
        solver.set_pmom(chi)
        solver.set_fbeam(beams)
        solver.set_albedo(black)
        solver.set_utau_batched(levels)
        solver.solve()

    def answers(_):
        if work.task == "radiance":
            return np.array(solver.uu)
        down = np.array(solver.rfldn)[:, 1] + np.array(solver.rfldir)[:, 1]
        return np.stack([np.array(solver.flup)[:, 0], down], axis=1)

    return solve, answers


def nanodisort_single(work):
    """One problem a call, the state used again."""
    import nanodisort

    if work.task not in ("flux", "radiance"):
        return None
    state = nanodisort.DisortState()
    nanodisort_settings(state, work)
    state.allocate()
    state.fbeam, state.albedo, state.accur = 1 / work.beam, 0.0, 0.0
    radiance = work.task == "radiance"
    if radiance:
        state.umu, state.phi = work.cosines, work.azimuths
    chi, levels = [np.asfortranarray(chi.T) for chi in work.chi()], depths(work)

    def solve():
        found = []
        for i in range(work.count):
            state.dtauc, state.ssalb, state.pmom, state.utau = work.tau[i], work.albedo[i], chi[i], levels[i]
            state.solve()
            found.append(np.array(state.uu) if radiance else (state.flup[0], state.rfldn[1] + state.rfldir[1]))
        return found

    return solve, np.array


def disortpp_flux(work):
    """All problems in one call of the solver compiled for this number of streams."""
    import disortpp

    config = disortpp.DisortFluxConfig(work.tau.shape[1], work.streams)
    config.direct_beam_flux, config.direct_beam_mu = 1 / work.beam, work.beam
    config.num_phase_func_moments = work.moments
    config.allocate()
    tau, albedo, chi = work.tau.tolist(), work.albedo.tolist(), work.chi().tolist()
    wavenumbers = [1.0] * work.count

    def solve():
        return disortpp.solve_flux_spectral(config, wavenumbers, tau, albedo, chi)

    def answers(found):
        return np.array([(r.flux_up[0], r.flux_down[-1] + r.flux_direct_beam[-1]) for r in found])

    return solve, answers


def disortpp_radiance(work):
    """One problem a call, configuration and solver used again: the depths asked for differ, which the spectral loop has
    no room for. Its flag `intensity_corr_nakajima` alone changes nothing; with `intensity_corr_buras`, and no
    tabulated phase function, it corrects after Nakajima and Tanaka."""
    import disortpp

    config = disortpp.DisortConfig(work.tau.shape[1], work.streams)
    flags = config.flags
    flags.use_lambertian_surface, flags.comp_only_fluxes = True, False
    flags.use_user_mu = flags.use_user_tau = True
    flags.intensity_corr_nakajima = flags.intensity_corr_buras = work.correction
    config.num_user_mu, config.num_phi, config.num_user_tau = len(work.cosines), len(work.azimuths), 2
    config.num_phase_func_moments = work.moments
    config.allocate()
    config.mu_user, config.phi_user = work.cosines.tolist(), work.azimuths.tolist()
    config.bc.direct_beam_flux, config.bc.direct_beam_mu, config.bc.surface_albedo = 1 / work.beam, work.beam, 0.0
    config.accuracy_fourier_series = 0.0
    tau, albedo, chi = work.tau.tolist(), work.albedo.tolist(), work.chi().tolist()
    levels, solver = depths(work).tolist(), disortpp.DisortSolver()

    def solve():
        found = []
        for i in range(work.count):
            config.delta_tau, config.single_scat_albedo = tau[i], albedo[i]
            config.phase_function_moments, config.tau_user = chi[i], levels[i]
            found.append(solver.solve(config).intensity)
        return found

    return solve, lambda found: np.array(found).transpose(0, 2, 1, 3)


def disortpp_peer(work):
    if work.task == "flux":
        return disortpp_flux(work)
    return disortpp_radiance(work) if work.task == "radiance" else None


def pythonic_peer(work):
    """Between its own cosines it interpolates radiance by a polynomial, near the horizon only to a few percent."""
    from PythonicDISORT import pydisort, subroutines

    if work.task not in ("flux", "radiance"):
        return None
    chi, radians = work.chi(), np.radians(work.azimuths)
    bottoms = np.cumsum(work.tau, axis=1)
    corrected = "eval" if work.correction else None

    def call(i, only_flux):
        return pydisort(bottoms[i], work.albedo[i], work.streams, chi[i], work.beam, 1 / work.beam, 0.0, NLeg=work.streams,
                        only_flux=only_flux, f_arr=chi[i, :, work.streams], cache_asso_leg="mu0")

    def solve():
        found = []
        for i in range(work.count):
            bottom = bottoms[i, -1]
            if work.task == "flux":
                _, up, down, _ = call(i, True)
                found.append((up(0.0), sum(down(bottom))))
            else:
                radiance = subroutines.interpolate(call(i, False)[-1], NT_cor=corrected)
                found.append(radiance(work.cosines, np.array([0.0, bottom]), radians))
        return found

    return solve, np.array


def iadpython_peer(work):
    """Its arrays; the quadrature is kept from call to call."""
    import iadpython

    def sample():
        return iadpython.Sample(n=work.index, n_above=work.slides, n_below=work.slides, quad_pts=work.streams)

    if work.task == "adding":
        slab = sample()
        slab.a, slab.b, slab.g = work.albedo[:, 0].copy(), work.tau[:, 0].copy(), work.g[:, 0].copy()
        return slab.rt, lambda found: np.stack(found, axis=1)
    if work.task != "inversion":
        return None

    def solve():
        # A row of measurements in one object, which keeps its grid of first guesses where it can.
        r, t, u = work.measured.T
        return iadpython.Experiment(r=r, t=t, u=u, sample=sample()).invert_rt()

    return solve, lambda found: np.stack(found, axis=1)


PEERS = {
    "nanodisort": nanodisort_single,
    "nanodisort-batch": nanodisort_batch,
    "disortpp": disortpp_peer,
    "PythonicDISORT": pythonic_peer,
    "iadpython": iadpython_peer,
}


@contextlib.contextmanager
def quiet():
    """The compiled peers write warnings to the terminal; the time that takes is not theirs."""
    import sys

    sys.stdout.flush()
    sys.stderr.flush()
    kept = [os.dup(1), os.dup(2)]
    with open(os.devnull, "wb") as sink:
        os.dup2(sink.fileno(), 1)
        os.dup2(sink.fileno(), 2)
    try:
        yield
    finally:
        for number, copy in zip((1, 2), kept):
            os.dup2(copy, number)
            os.close(copy)


def processor_seconds(function):
    start = time.process_time()
    found = function()
    return time.process_time() - start, found


class Contender:
    def __init__(self, name, prepare, work):
        self.name, self.best = name, float("inf")
        with quiet():
            few = prepare(work.first(4))
            self.able = few is not None
            if not self.able:
                return
            few[0]()  # compiles and caches
            seconds, _ = processor_seconds(few[0])
            self.count = max(1, min(work.count, round(LIMIT_SECONDS / seconds * min(4, work.count))))
            self.solve, answers = prepare(work.first(self.count))
            self.values = np.asarray(answers(self.solve()), dtype=float).reshape(self.count, -1)

    def turn(self):
        with quiet():
            self.best = min(self.best, processor_seconds(self.solve)[0])


class Mieux:
    def __init__(self, executable, work, path):
        self.name, self.command, self.count = "mieux", [executable, "--workload", work.name, "--problems", path], work.count
        self.best = float("inf")
        self.turn()
        self.able, self.best = self.values is not None, float("inf")

    def turn(self):
        out = subprocess.run(self.command, check=True, capture_output=True, text=True).stdout
        lines = [json.loads(line) for line in out.splitlines() if line.startswith("{")]
        if len(lines) != 1:
            raise SystemExit(f"{' '.join(self.command)} printed {len(lines)} answers instead of 1")
        values = lines[0].get("values")
        self.values = None if values is None else np.array(values).reshape(self.count, -1)
        if values is not None:
            self.best = min(self.best, lines[0]["cpu_seconds"])


def report(work, contenders):
    """Times, fastest first, and by how much the answers differ from those of the one named first in the table."""
    print(f"\n{work.name}: {work.text}")
    contenders = sorted(contenders, key=lambda c: c.best / c.count)
    ours = [c for c in contenders if c.name == "mieux"]
    against = next((c for c in contenders if c.name != "mieux"), contenders[0])
    print(f"  {'':18}{'us each':>12}{'problems':>10}{'sum of values':>22}{'difference':>13}" + (f"{'/mieux':>10}" if ours else ""))
    for c in contenders:
        shared = min(c.count, against.count)
        difference = np.abs(c.values[:shared] - against.values[:shared]).max()
        line = f"  {c.name:18}{c.best / c.count * 1e6:>12.5g}{c.count:>10}{c.values[:shared].sum():>22.14g}{difference:>13.1e}"
        print(line + "".join(f"{c.best / c.count / (o.best / o.count):>10.2f}" for o in ours), flush=True)
    print(f"  (differences from {against.name})")


def main():
    with tempfile.TemporaryDirectory() as folder:
        run(folder)


def run(folder):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--mieux")
    parser.add_argument("--only", nargs="*")
    parser.add_argument("--peers", nargs="*", default=list(PEERS))
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--values")
    parser.add_argument("--problems", default=folder)
    arguments = parser.parse_args()
    everything = {}
    for work in workloads():
        if arguments.only and work.name not in arguments.only:
            continue
        contenders = []
        for name in arguments.peers:
            try:
                contenders.append(Contender(name, PEERS[name], work))
            except ImportError as error:
                print(f"{name} is left out: {error}")
        path = os.path.join(arguments.problems, work.name + ".txt")
        with open(path, "w") as file:
            work.write(file)
        if arguments.mieux:
            contenders.append(Mieux(arguments.mieux, work, path))
        contenders = [c for c in contenders if c.able]
        for _ in range(arguments.rounds):
            for contender in contenders:
                contender.turn()
        if contenders:
            report(work, contenders)
        everything[work.name] = {c.name: c.values.tolist() for c in contenders}
    if arguments.values:
        with open(arguments.values, "w") as file:
            json.dump(everything, file)


if __name__ == "__main__":
    main()
