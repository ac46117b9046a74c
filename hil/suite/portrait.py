"""End to end: what the virtual machine photographed, received, fitted and held against the twin's truth,
beside the twin's own photographs of the same light."""
import json
import math
import shutil
import subprocess
from pathlib import Path

from suite import exr, light, pictures
from suite.camera import recorded
from suite.report import Measure, Result
from suite.twin import Twin
from witness import plan

SUBJECT, SCALE = "head", 0.5
# Of two noisy photographs of the same light, sample by sample: 1, and what half floats round off. Their
# means are as far apart as the noise of thousands of samples.
RMS_SIGMAS, MEAN_SIGMAS = 1.1, 0.1
CHUNKS = (8, 14)    # of 16 lines each: the nose, the mouth
CLIPPED = 0.98      # of full scale
# What, where in the report of `lamella compare`, unit, limit.
FIGURES = (
    ("position, RMS without the worst 1 %", "position/rms_trimmed99_mm", "mm", 0.40),
    ("specular normal, median", "normal_specular/deg/median", "degrees", 2.5),
    ("diffuse normal of green, median", "normal_diffuse/g/deg/median", "degrees", 2),
    ("specular intensity, relative RMSE", "specular_intensity/all/rel_rmse", "", 0.20),
    ("phase function p, L1", "summary/p_L1_mean", "", 0.15),
    ("mean free path, mean error", "summary/ld_mean_abs_rel_error", "", 0.25),
    ("amplitude of single scattering, mean error", "summary/single_amplitude_mean_abs_rel_error", "", 0.10))
STEP = 1 / (pictures.CLIPPED_DN - pictures.BLACK_DN)  # of the machine's sensor


def render(lamella, rig_file, guest):
    """The twin's picture of each state that a boot recorded, to guest/known, from where the next boot feeds
    its cameras; and the twin's own session, to guest/twin."""
    expected = recorded(guest / "camera-record").expected
    states = light.read_states((guest / "camera-record/states").read_text(encoding="utf-8"))
    known = guest / "known"
    known.mkdir()
    with Twin(lamella, SUBJECT, SCALE, guest / "twin", known / "calibration.json") as twin:
        pictures.render(known, [states[key] for key in sorted(set(expected.values()))],
                        (plan.read_leds(rig_file), plan.read_numbers(rig_file)), twin)


def _json(lamella, *arguments):
    done = subprocess.run([lamella, *map(str, arguments), "--json"], capture_output=True, text=True)
    if done.returncode != 0:
        raise ValueError(f"exit {done.returncode} of lamella {arguments[0]}: {done.stderr.strip()}")
    return json.loads(done.stdout)


def _manifest(session):
    return json.loads((session / "session.json").read_text(encoding="utf-8"))


def _label(session, twins):
    """Names the regions of the face, as an operator may: the labels are the twin's."""
    manifest = {**_manifest(session), "regions": _manifest(twins)["regions"]}
    (session / "session.json").write_text(json.dumps(manifest), encoding="utf-8")
    shutil.copy(twins / "regions.png", session)


def _receive(lamella, guest):
    """The burst on the machine's disk, taken out of it, as a session of this host."""
    told = _json(lamella, "rig", "recover", "--store", guest / "camera-play/store",
                 "--out", guest / "received")
    session = Path(told["bursts"][0]["session"])
    _label(session, guest / "twin")
    return session


def _frames(session):
    """[(subject, manifest's frame)]"""
    return [((f["camera"], f["role"], f.get("index", 0), f["analyser"]), f)
            for f in _manifest(session)["frames"]]


def _samples(session, frame):
    """Stored values that a sensor under red, green / green, blue measures itself, and demosaicing leaves."""
    image, values = (session / frame["file"]).read_bytes(), []
    for chunk in CHUNKS:
        for y, line in enumerate(exr.lines(image, chunk)):
            values += [*line[y % 2][0::2], *line[y % 2 + 1][1::2]]
    return values


def _sigmas_apart(ours, twins, frames, camera):
    """Difference of radiance over its sigma, for each sample of a photograph and the twin's own."""
    scale = frames[1].get("radiance_scale", [1])[0]
    read, well = camera["read_noise"], camera["full_well_electrons"]
    found = []
    for a, b in zip(_samples(ours, frames[0]), _samples(twins, frames[1])):
        if a < CLIPPED and b < CLIPPED:
            variance = 2 * scale * scale * (max(b, 0) / well + read * read) + STEP * STEP / 12
            found.append((a - b * scale) / math.sqrt(variance))
    return found


def frames_agree(ours, twins):
    """Measures of the difference of two sessions' photographs."""
    cameras = {camera["id"]: camera for camera in _manifest(twins)["rig"]["cameras"]}
    of_twin = dict(_frames(twins))
    apart = {frame["file"]: _sigmas_apart(ours, twins, (frame, of_twin[subject]), cameras[subject[0]])
             for subject, frame in _frames(ours)}
    rms = {name: math.sqrt(sum(z * z for z in zs) / len(zs)) for name, zs in apart.items()}
    means = {name: abs(sum(zs) / len(zs)) for name, zs in apart.items()}
    measures = [Measure("photographs compared", len(apart), ""),
                Measure("samples compared", sum(map(len, apart.values())), "")]
    for what, found, limit in (("RMS difference", rms, RMS_SIGMAS), ("mean difference", means, MEAN_SIGMAS)):
        worst = max(found, key=found.get)
        measures.append(Measure(f"{what}, at most ({worst})", found[worst],
                                "sigma of a sample's noise", limit))
    return measures


def _figure(figures, path):
    for name in path.split("/"):
        figures = figures[name]
    return figures


def _fitted(lamella, session, truth):
    """The figures of a session's fit, held against the truth, which the fit does not see."""
    alone = session.parent / f"{session.name}-alone"
    shutil.copytree(session, alone, ignore=shutil.ignore_patterns("truth"))
    _json(lamella, "fit", alone)
    return _json(lamella, "compare", alone / "fit", truth)


def _fits_agree(lamella, ours, twins):
    """Each figure of the machine's burst beside the one of the twin's own photographs."""
    found, beside = (_fitted(lamella, session, twins / "truth") for session in (ours, twins))
    measures = []
    for what, path, unit, limit in FIGURES:
        measures += [Measure(what, _figure(found, path), unit, limit),
                     Measure(f"{what}, of the twin's own photographs", _figure(beside, path), unit)]
    return measures


def play(lamella, guest):
    """The scenes; [Result]."""
    frames = "the received photographs are the twin's, to the noise of the sensor"
    fits = "the machine's burst, developed and fitted, beside the twin's truth"
    try:
        ours, twins = _receive(lamella, guest), guest / "twin"
        return [Result(frames, frames_agree(ours, twins), []),
                Result(fits, _fits_agree(lamella, ours, twins), [])]
    except (OSError, ValueError, LookupError) as why:
        return [Result(fits, [], [str(why)])]
