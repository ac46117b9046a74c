"""The fit's scattering profiles by SciPy's solvers.

    python3 scipy_profiles.py PROGRAMS.json --out FOLDER

Solves what `lamella bench` writes of each region and channel: the kernel as a sum of exponentials,
least x'ax - 2b'x over x >= 0 (scipy.optimize.nnls), and the dipole of the kernel's tail, eq. 7 with
a free amplitude (scipy.optimize.least_squares). l_d and the seconds of either go to layers.json.

Needs NumPy and SciPy (python3-scipy); without them it says so and ends with 3.
"""
import argparse
import json
import math
import pathlib
import sys
import time

try:
    import numpy as np
    from scipy.linalg import cholesky, solve_triangular
    from scipy.optimize import least_squares, nnls
except ImportError as missing:
    sys.exit(print(f"{sys.executable} has no module {missing.name}", file=sys.stderr) or 3)

BOUNDARY = 3.112  # A of eq. 7 at ior 1.38
FROM_MM, TO_MM, SAMPLES = 1.0, 8.0, 24  # of the tail, at equal steps of log r
TRANSPORT_MM, TRANSPORT_SPREAD = 0.32, 0.08  # of dermis, and one sigma of its logarithm
TRANSPORT_DOUBT = 1  # sigmas from which on it rather is not dermis's
TAIL_ERROR = 0.15  # relative
LOWEST = np.log([0.05, 0.05]).tolist() + [-np.inf]  # l_d, transport length (mm), amplitude
HIGHEST = np.log([50.0, 3.0]).tolist() + [np.inf]


def solve_kernel(program):
    """Weights of the exponentials, summing to 1."""
    root = cholesky(program["a"])
    weights, _ = nnls(root, solve_triangular(root, program["b"], trans="T"))
    return weights / weights.sum()


def solve_tail(weights, length_mm):
    """l_d of the dipole that follows the kernel's tail, mm."""
    r = np.geomspace(FROM_MM, TO_MM, SAMPLES)[:, None]
    value = np.maximum(np.exp(-r / length_mm) / (2 * math.pi * length_mm**2) @ weights, 1e-9)
    r = r[:, 0]
    light = np.sqrt(r**2 * value)
    light /= light.max()

    def residuals(logarithms):
        ld, source, _ = np.exp(logarithms)
        shape = 0
        for depth in (source, source * (1 + 4 * BOUNDARY / 3)):
            d = np.sqrt(r**2 + depth**2)
            shape = shape + depth * (1 / ld + 1 / d) * np.exp(-d / ld) / d**2
        tail = light * (logarithms[2] + np.log(shape / value)) / TAIL_ERROR
        off = (logarithms[1] - math.log(TRANSPORT_MM)) / TRANSPORT_SPREAD / TRANSPORT_DOUBT
        prior = TRANSPORT_DOUBT * math.copysign(math.sqrt(math.log1p(off**2)), off)
        return np.append(tail, prior)

    fits = [least_squares(residuals, [math.log(1.5 * source), math.log(source), -2],
                          bounds=(LOWEST, HIGHEST))
            for source in (TRANSPORT_MM, 3 * TRANSPORT_MM)]
    return math.exp(min(fits, key=lambda fit: fit.cost).x[0])


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("programs", type=pathlib.Path)
    parser.add_argument("--out", type=pathlib.Path, required=True)
    arguments = parser.parse_args()
    document = json.loads(arguments.programs.read_text())
    length_mm = np.array(document["length_mm"])
    programs = [{"region": p["region"], "a": np.array(p["a"]), "b": np.array(p["b"])}
                for p in document["programs"]]
    start = time.perf_counter()
    kernels = [solve_kernel(program) for program in programs]
    middle = time.perf_counter()
    lengths = [solve_tail(kernel, length_mm) for kernel in kernels]
    end = time.perf_counter()
    regions = {}
    for program, ld in zip(programs, lengths):  # channels in order
        regions.setdefault(program["region"], []).append(ld)
    arguments.out.mkdir(parents=True, exist_ok=True)
    (arguments.out / "layers.json").write_text(json.dumps({
        "format": "lamella.layers.v1",
        "regions": [{"name": name, "deep": {"ld_mm": ld}} for name, ld in regions.items()],
        "timings_s": {"nnls": middle - start, "least_squares": end - middle}}))


if __name__ == "__main__":
    main()
