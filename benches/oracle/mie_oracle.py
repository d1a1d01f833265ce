"""Scattering by homogeneous and layered spheres in a host that may absorb, in arbitrary precision (needs gmpy2).

For every case of `mie_cases.py` the Lorenz-Mie series is summed straight from its definition: Riccati-Bessel functions
psi_n and zeta_n (or z y_n where an argument is real) of every layer, the two tangential fields matched from the core
outwards, and the coefficients a_n, b_n from the last match. Nothing is rearranged to save digits. Instead each case is
computed with two working precisions, which also end the series and start the downward recurrence of psi_n at different
orders, and both precisions are raised until every output agrees to 1e-27. Inputs are doubles, taken as exact numbers.

    python3 benches/oracle/mie_oracle.py                       compute the cases that the table does not hold yet
    python3 benches/oracle/mie_oracle.py --check REFERENCE.csv compare with a table of reference values (columns mp_*)
    python3 benches/oracle/mie_oracle.py --only PREFIX         restrict to cases whose id starts so

Conventions: exp(-i w t), n'' >= 0 absorbs; k0 = 2 pi / wavelength in vacuum, k = k0 n_host, r the outer radius.
    c_ext     4 pi Re(S(0)/k^2) with S(0) = 1/2 sum (2n+1)(a_n + b_n)                               frisvad2007 eq 22
    c_sca     2 pi exp(-alpha)/(gamma |k|^2) sum (2n+1)(|a_n|^2 + |b_n|^2), alpha = 2 k'' r          frisvad2007 eq 23-24
              with gamma = 2 (1 + (alpha - 1) exp(alpha))/alpha^2
    c_abs     c_ext - c_sca; zero, exactly, where nothing absorbs
    g         frisvad2007 eq 26
    c_back    4 pi |S(180)|^2/|k|^2
    my_c_ext  4 pi/k' Re(S(0)/k)                                        far field, Mishchenko and Yang (2018)
    my_c_sca  2 pi/|k|^2 sum (2n+1)(|a_n|^2 + |b_n|^2)                  far field, Mishchenko and Yang (2018)
    s1, s2    amplitudes of Bohren and Huffman, from plain a_n and b_n; left empty where they pass 1e300
`<name>_forced` is what rounding the inputs alone does to an output: the sum over all real inputs (wavelength, radii, real
parts, imaginary parts that are not zero) of |relative derivative| 2^-53, by differences with a relative step of 1e-20.
The derivative by the wavelength follows from those by the radii, since only lengths in proportion matter.
"""

import argparse
import csv
import math
import os
import sys
import time

import gmpy2
from gmpy2 import mpc, mpfr

import mie_cases

HERE = os.path.dirname(os.path.abspath(__file__))
TABLE = os.path.join(HERE, "..", "..", "crates", "mieux-optics", "tests", "data", "mie_oracle.csv")
ANGLES = (0, 30, 90, 175, 180)
REAL_OUTPUTS = ("c_ext_m2", "c_sca_m2", "c_abs_m2", "g", "c_back_m2", "my_c_ext_m2", "my_c_sca_m2")
AMPLITUDES = tuple(f"s{j}_{angle}" for angle in ANGLES for j in (1, 2))
AGREEMENT = 1e-27
STEP = 20


def set_digits(digits):
    gmpy2.get_context().precision = int(digits * math.log2(10)) + 8


def decay(order, size):
    """About log sqrt(|chi_n/psi_n|) beyond the turning point, 0 before it."""
    nu = order + 0.5
    if nu <= size:
        return 0.0
    return nu * math.acosh(nu / size) - math.sqrt((nu - size) * (nu + size))


def order_where_decayed(first, size, digits):
    """The lowest order where psi_n/chi_n has fallen by `digits` decimal digits from that at order `first`."""
    target = decay(first, size) + digits * math.log(10) / 2
    low = max(first, int(size) - 1)
    high = low + 8
    while decay(high, size) < target:
        high += high - low
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if decay(middle, size) >= target else (middle, high)
    return high


def psi_list(z, order, digits):
    """psi_0 .. psi_order, downward from where it has vanished; scaled by the larger of sin z and cos z = psi_(-1)."""
    inverse = 1 / z
    start = order_where_decayed(order, float(abs(z)), digits + 6)
    above, here = mpfr(0) * z, mpfr(1) + 0 * z
    for n in range(start, order, -1):
        above, here = here, (2 * n + 1) * inverse * here - above
    values = [None] * (order + 1)
    for n in range(order, 0, -1):
        values[n] = here
        above, here = here, (2 * n + 1) * inverse * here - above
    values[0] = here
    before = inverse * here - above
    sine, cosine = gmpy2.sin(z), gmpy2.cos(z)
    scale = sine / here if abs(sine) > abs(cosine) else cosine / before
    return [v * scale for v in values]


def second_list(z, order):
    """Upward: z y_n where z is real (Wronskian with psi_n: 1), zeta_n otherwise (Wronskian: i)."""
    inverse = 1 / z
    if isinstance(z, type(mpfr(0))):
        before, here = gmpy2.sin(z), -gmpy2.cos(z)
    else:
        before = gmpy2.exp(mpc(0, 1) * z)
        here = mpc(0, -1) * before
    values = [here]
    for n in range(order):
        before, here = here, (2 * n + 1) * inverse * here - before
        values.append(here)
    return values


def number(re, im):
    return mpfr(re) if im == 0 else mpc(mpfr(re), mpfr(im))


def coefficients(k0r, indices, host, digits):
    """The a_n and b_n, n = 1, 2, ... as a generator; k0r and indices from the innermost layer outwards."""
    x = k0r[-1] * host
    order = order_where_decayed(1, float(abs(x)), digits)
    if abs(x) > 1:
        order = max(order, order_where_decayed(int(abs(x)), float(abs(x)), digits))

    def functions(z, both):
        psi = psi_list(z, order, digits)
        return 1 / z, psi, second_list(z, order) if both else None

    inner = [None] + [functions(k0r[l - 1] * indices[l], True) for l in range(1, len(indices))]
    outer = [functions(k0r[l] * indices[l], l > 0) for l in range(len(indices))]
    inverse_x, psi_x, second_x = functions(x, True)
    real_x = isinstance(x, type(mpfr(0)))
    imaginary = mpc(0, 1)
    ratios = [indices[l - 1] / indices[l] for l in range(1, len(indices))]
    last = indices[-1] / host
    inverse_core, psi_core, _ = outer[0]

    for n in range(1, order + 1):
        # Value and derivative of the radial function: in every layer for a_n and b_n.
        value = psi_core[n]
        slope = psi_core[n - 1] - n * inverse_core * value
        ua, da, ub, db = value, slope, value, slope
        for l in range(1, len(indices)):
            ratio = ratios[l - 1]
            ua, db = ua * ratio, db * ratio  # a: n u and u' pass unchanged; b: u and n u'
            inverse, psi, second = inner[l]
            p, s = psi[n], second[n]
            dp, ds = psi[n - 1] - n * inverse * p, second[n - 1] - n * inverse * s
            ca, ea = ua * ds - da * s, p * da - dp * ua
            cb, eb = ub * ds - db * s, p * db - dp * ub
            inverse, psi, second = outer[l]
            p, s = psi[n], second[n]
            dp, ds = psi[n - 1] - n * inverse * p, second[n - 1] - n * inverse * s
            ua, da = ca * p + ea * s, ca * dp + ea * ds
            ub, db = cb * p + eb * s, cb * dp + eb * ds
        ua, db = ua * last, db * last
        p, s = psi_x[n], second_x[n]
        dp, ds = psi_x[n - 1] - n * inverse_x * p, second_x[n - 1] - n * inverse_x * s
        ta, tb = p * da - dp * ua, p * db - dp * ub
        na, nb = s * da - ds * ua, s * db - ds * ub
        if real_x:
            na, nb = ta + imaginary * na, tb + imaginary * nb
        yield n, ta / na, tb / nb


def scatter(wavelength, host, layers, digits):
    """All outputs; every argument an exact number, layers (radius, re, im), host (re, im)."""
    set_digits(digits)
    k0 = 2 * gmpy2.const_pi() / wavelength
    pi = gmpy2.const_pi()
    k = k0 * number(*host)
    k0r = [k0 * r for r, _, _ in layers]
    indices = [number(re, im) for _, re, im in layers]

    zero = mpc(0)
    forward = backward = zero
    scattering = cosine = mpfr(0)
    a1 = b1 = zero
    cosines = [gmpy2.cos(pi * angle / 180) if angle != 90 else mpfr(0) for angle in ANGLES[1:-1]]
    angular = [[mu, mpfr(0), mpfr(1), zero, zero] for mu in cosines]
    for n, a, b in coefficients(k0r, indices, number(*host), digits):
        weight = 2 * n + 1
        forward += weight * (a + b)
        backward += (weight if n % 2 else -weight) * (a - b)
        scattering += weight * (gmpy2.norm(a) + gmpy2.norm(b))
        pair = a1.real * a.real + a1.imag * a.imag + b1.real * b.real + b1.imag * b.imag
        cosine += mpfr((n - 1) * (n + 1)) / n * pair
        cosine += mpfr(weight) / (n * (n + 1)) * (a.real * b.real + a.imag * b.imag)
        a1, b1 = a, b
        share = mpfr(weight) / (n * (n + 1))
        sa, sb = share * a, share * b
        for state in angular:
            mu, before, here = state[0], state[1], state[2]
            t = mu * here
            tau = n * t - (n + 1) * before
            state[3] += sa * here + sb * tau
            state[4] += sa * tau + sb * here
            state[1], state[2] = here, (tau + (n + 1) * t) / n
    forward, backward = forward / 2, backward / 2

    k_squared = gmpy2.norm(mpc(k))
    far = 2 * pi / k_squared * scattering
    surface = mpfr(1)
    if k.imag != 0:
        alpha = 2 * k.imag * layers[-1][0]
        surface = gmpy2.exp(-alpha) * alpha**2 / (2 * (1 + (alpha - 1) * gmpy2.exp(alpha)))
    extinction = 4 * pi * mpc(forward / k**2).real
    lossless = host[1] == 0 and all(im == 0 for _, _, im in layers)
    values = [
        extinction,
        far * surface,
        mpfr(0) if lossless else extinction - far * surface,
        2 * cosine / scattering,
        4 * pi * gmpy2.norm(backward) / k_squared,
        4 * pi / k.real * mpc(forward / k).real,
        far,
    ]
    amplitudes = [forward, forward]
    for state in angular:
        amplitudes += [state[3], state[4]]
    return values + amplitudes + [backward, -backward]


def disagreement(one, two):
    """The largest relative difference of any output; an amplitude counts by its parts, unless one is an exact zero."""
    worst = 0.0
    for p, q in zip(one, two):
        parts = ((p.real, q.real), (p.imag, q.imag))
        for u, v in parts:
            if u != v:
                worst = max(worst, float(abs(u - v) / max(abs(u), abs(v))))
    return worst


def exact(case):
    layers = [(mpfr(r), mpfr(re), mpfr(im)) for r, re, im in case.layers]
    return mpfr(case.wavelength), (mpfr(case.host.real), mpfr(case.host.imag)), layers


def converged(wavelength, host, layers):
    digits, more = 45, 65
    low = scatter(wavelength, host, layers, digits)
    while True:
        high = scatter(wavelength, host, layers, more)
        worst = disagreement(low, high)
        if worst < AGREEMENT:
            return high, more, worst
        digits, more, low = more, more * 3 // 2, high
        if digits > 2000:
            raise ArithmeticError("no agreement")


def forced(wavelength, host, layers, base, digits):
    """Sum over the inputs of |relative derivative| 2^-53, for every output."""
    set_digits(digits)
    grow = 1 + mpfr(10) ** -STEP
    totals = [mpfr(0)] * len(base)
    by_length = [mpc(0)] * len(base)

    def change(host_, layers_):
        values = scatter(wavelength, host_, layers_, digits)
        scale = mpfr(10) ** STEP
        # Of a real output the relative derivative, of a complex one the derivative over the modulus.
        return [(v - b) / abs(b) * scale if b != 0 else mpfr(0) for v, b in zip(values, base)]

    def add(changes):
        for j, c in enumerate(changes):
            totals[j] += abs(c)

    if host[0] != 0:
        add(change((host[0] * grow, host[1]), layers))
    if host[1] != 0:
        add(change((host[0], host[1] * grow), layers))
    for l, (r, re, im) in enumerate(layers):
        def with_layer(layer):
            return layers[:l] + [layer] + layers[l + 1:]
        changes = change(host, with_layer((r * grow, re, im)))
        add(changes)
        by_length = [s + c for s, c in zip(by_length, changes)]
        add(change(host, with_layer((r, re * grow, im))))
        if im != 0:
            add(change(host, with_layer((r, re, im * grow))))
    # Areas grow with the square of all lengths, g and the amplitudes not at all.
    powers = [0 if name == "g" else 2 for name in REAL_OUTPUTS] + [0] * len(AMPLITUDES)
    for j, (power, s) in enumerate(zip(powers, by_length)):
        sign = 1 if j >= len(REAL_OUTPUTS) or base[j] >= 0 else -1
        if base[j] != 0:
            totals[j] += abs(power * sign - s)
    return [t / mpfr(2) ** 53 for t in totals]


HEADER = ["id", "group", "wavelength_m", "host_re", "host_im", "layers"]
for _name in REAL_OUTPUTS:
    HEADER += [_name, _name + "_forced"]
for _name in AMPLITUDES:
    HEADER += [_name + "_re", _name + "_im", _name + "_forced"]


def inputs(case):
    layers = ";".join(f"{r!r}:{re!r}:{im!r}" for r, re, im in case.layers)
    return [case.id, case.group, repr(case.wavelength), repr(case.host.real), repr(case.host.imag), layers]


def text(v, digits=20):
    return "0" if v == 0 else format(v, f".{digits - 1}e")


def row(case):
    set_digits(100)
    wavelength, host, layers = exact(case)
    base, digits, _ = converged(wavelength, host, layers)
    moved = forced(wavelength, host, layers, base, digits)
    cells = inputs(case)
    for j, v in enumerate(base):
        if j < len(REAL_OUTPUTS):
            cells += [text(v), text(moved[j], 3)]
        elif abs(v) > 1e300:
            cells += ["", "", ""]
        else:
            cells += [text(v.real), text(v.imag), text(moved[j], 3)]
    return cells, digits


def read_table():
    if not os.path.exists(TABLE):
        return {}
    with open(TABLE, newline="") as file:
        rows = csv.reader(line for line in file if not line.startswith("#"))
        next(rows)
        return {r[0]: r for r in rows}


def write_table(rows):
    with open(TABLE, "w", newline="") as file:
        file.write("# Lorenz-Mie scattering in arbitrary precision: homogeneous and layered spheres, absorbing hosts.\n")
        file.write("# Source: own computation, two working precisions agreeing to 1e-27, 20 digits printed; no outside data.\n")
        file.write("# Licence: as the project (MIT OR Apache-2.0). Command: python3 benches/oracle/mie_oracle.py\n")
        file.write("# Inputs are doubles taken exactly; layers are radius_m:re:im from the core outwards, the last radius the sphere's.\n")
        file.write("# Outputs are defined at the head of benches/oracle/mie_oracle.py. <name>_forced: relative change that rounding the\n")
        file.write("# inputs forces, sum of |relative derivative| 2^-53 over all real inputs that are not zero.\n")
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(HEADER)
        writer.writerows(rows)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", default="")
    parser.add_argument("--check")
    parser.add_argument("--minutes", type=float, default=1e9, help="start no new case after so many minutes")
    arguments = parser.parse_args()
    if arguments.check:
        return check(arguments.check)
    cases = mie_cases.all_cases()
    known = read_table()
    started = saved = time.monotonic()

    def keep():
        current = [known[c.id] for c in cases if c.id in known and known[c.id][:6] == inputs(c)]
        write_table(current)
        return len(current)

    for case in cases:
        if not case.id.startswith(arguments.only) or known.get(case.id, [])[:6] == inputs(case):
            continue
        if time.monotonic() - started > 60 * arguments.minutes:
            break
        begun = time.monotonic()
        known[case.id], digits = row(case)
        print(f"{case.id:24} {digits:5} digits {time.monotonic() - begun:8.2f} s", flush=True)
        if time.monotonic() - saved > 60:
            keep()
            saved = time.monotonic()
    print(keep(), "of", len(cases), "cases in the table")


def check(path):
    """Compare with every row of a reference table that has values of arbitrary precision (mp_*), for inputs as doubles."""
    set_digits(60)
    worst = {}
    with open(path, newline="") as file:
        for entry in csv.DictReader(file):
            if not entry["mp_qext"]:
                continue
            wavelength = 2 * gmpy2.const_pi()  # so that lengths are k0 r
            parts = entry["m"].split()
            host, radii, indices = 1 + 0j, entry["x"].split(), parts
            if entry["kind"] == "absorbing host":
                radii = [entry["x"].split("=")[1].split("(")[0]]
                host, indices = complex(parts[1].replace("i", "j")), [parts[3]]
            layers = []
            for r, index in zip(radii, indices):
                m = complex(index.replace("i", "j"))
                layers.append((mpfr(float(r)), mpfr(m.real), mpfr(m.imag)))
            base, _, _ = converged(wavelength, (mpfr(host.real), mpfr(host.imag)), layers)
            set_digits(60)
            area = gmpy2.const_pi() * layers[-1][0] ** 2
            ours = dict(zip(REAL_OUTPUTS, base))
            pairs = {
                "mp_qext": ours["c_ext_m2"] / area,
                "mp_qsca": ours["c_sca_m2"] / area,
                "mp_g": ours["g"],
                "mp_qback": ours["c_back_m2"] / area,
                "mp_my_qext": ours["my_c_ext_m2"] / area,
                "mp_my_qsca": ours["my_c_sca_m2"] / area,
            }
            line = []
            for name, value in pairs.items():
                if entry[name]:
                    error = float(abs(value / mpfr(entry[name]) - 1))
                    line.append(f"{name[3:]} {error:.1e}")
                    if error > worst.get(name, (0, ""))[0]:
                        worst[name] = (error, entry["id"])
            print(f"{entry['id']:14}", "  ".join(line), flush=True)
    for name, (error, identity) in worst.items():
        print(f"worst {name:11} {error:.2e} at {identity}")


if __name__ == "__main__":
    sys.exit(main())
