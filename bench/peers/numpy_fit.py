"""The paper in NumPy, as somebody would write it who needs it by Friday.

    python3 numpy_fit.py SESSION --out FOLDER

Reads a session and writes a fit, as `lamella fit` does, by the equations of Ghosh et al. 2008 in
the order in which they stand there: no visibility, no noise model, no joint fits, no multipole. It is
what `lamella bench` holds seconds and errors of the real fit against, and shares no code with it.

Needs NumPy and OpenCV (python3-numpy, python3-opencv), and reads photographs by the module OpenEXR
where that is there. Without one it needs it says which and ends with 3. Seconds of its steps, imports
apart, are in layers.json.
"""
import argparse
import json
import math
import os
import pathlib
import struct
import sys
import time

os.environ["OPENCV_IO_ENABLE_OPENEXR"] = "1"  # before it is imported
try:
    import cv2
    import numpy as np
except ImportError as missing:
    sys.exit(print(f"{sys.executable} has no module {missing.name}", file=sys.stderr) or 3)
try:
    import Imath
    import OpenEXR
except ImportError:
    OpenEXR = None

IOR = 1.38
BOUNDARY = 3.112  # A of eq. 7, internal reflectance at this index
CONE_DEG = 45  # of the lobe's table
FAR_DEG = 45, 70  # angle of h where only single scattering is left
DOT_RADIUS_SHARE = 2 / 3  # of a dot, where its profile is read
RINGS = 10


# Files


def read_rgb(path):
    """An EXR file's R, G and B, float32."""
    if OpenEXR is None:
        image = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
        if image is None:
            sys.exit(print(f"{sys.executable} has no module OpenEXR, and its cv2 reads no EXR", file=sys.stderr) or 3)
        return np.ascontiguousarray(image[..., ::-1], np.float32)
    file = OpenEXR.InputFile(str(path))
    window = file.header()["dataWindow"]
    size = window.max.y - window.min.y + 1, window.max.x - window.min.x + 1
    planes = file.channels("RGB", Imath.PixelType(Imath.PixelType.FLOAT))
    return np.stack([np.frombuffer(p, np.float32).reshape(size) for p in planes], -1)


def write_exr(path, names, values):
    """`values`, rows x columns x names, as an EXR file of floats, not compressed."""
    rows, columns = values.shape[:2]
    order = sorted(range(len(names)), key=lambda i: names[i])

    def attribute(name, kind, data):
        return f"{name}\0{kind}\0".encode() + struct.pack("<i", len(data)) + data

    channels = b"".join(names[i].encode() + struct.pack("<xiB3xii", 2, 0, 1, 1) for i in order)
    window = struct.pack("<4i", 0, 0, columns - 1, rows - 1)
    header = struct.pack("<ii", 20000630, 2)
    header += attribute("channels", "chlist", channels + b"\0")
    header += attribute("compression", "compression", b"\0")
    header += attribute("dataWindow", "box2i", window)
    header += attribute("displayWindow", "box2i", window)
    header += attribute("lineOrder", "lineOrder", b"\0")
    header += attribute("pixelAspectRatio", "float", struct.pack("<f", 1))
    header += attribute("screenWindowCenter", "v2f", struct.pack("<2f", 0, 0))
    header += attribute("screenWindowWidth", "float", struct.pack("<f", 1)) + b"\0"
    lines = np.zeros(rows, [("y", "<i4"), ("bytes", "<i4"), ("data", "<f4", (len(names), columns))])
    lines["y"] = np.arange(rows)
    lines["bytes"] = 4 * len(names) * columns
    lines["data"] = np.moveaxis(values, -1, 1)[:, order]
    first = len(header) + 8 * rows
    offsets = first + lines.itemsize * np.arange(rows, dtype="<u8")
    path.write_bytes(header + offsets.tobytes() + lines.tobytes())


class Burst:
    """The left camera's photographs as radiance in the colours of the LEDs, and the rig."""

    def __init__(self, folder):
        manifest = json.loads((folder / "session.json").read_text())
        rig = manifest["rig"]
        self.camera = next(c for c in rig["cameras"] if c["id"] == "left")
        self.projector = rig["projector"]
        self.patterns = manifest.get("patterns", {})
        tint = np.reshape(rig.get("projector_to_led", np.eye(3)), (3, 3)).astype(np.float32)
        self.images, self.clipped = {}, None
        for frame in manifest["frames"]:
            if frame["camera"] != "left" or frame["role"] == "VALIDATION":
                continue
            stored = read_rgb(folder / frame["file"])
            clipped = (stored >= self.camera.get("saturation", np.inf)).any(-1)
            self.clipped = clipped if self.clipped is None else self.clipped | clipped
            image = stored * np.array(frame.get("radiance_scale", [1, 1, 1]), np.float32)
            if not frame["role"].startswith("GRADIENT"):
                image = image @ tint.T
            self.images[frame["role"], frame.get("index", 0), frame["analyser"]] = image
        self.black = self.cross("BLACK")
        self.lit = self.cross("FRONT") - self.black
        if "regions" in manifest:
            file, self.names = manifest["regions"]["file"], manifest["regions"]["names"]
            self.labels = cv2.imread(str(folder / file), cv2.IMREAD_UNCHANGED)
        else:
            light = cv2.GaussianBlur(self.lit.mean(-1), (0, 0), 2)
            self.labels = (light > 0.05 * np.percentile(light, 98)).astype(np.uint8)
            self.names = ["background", "face"]

    def cross(self, role, index=0):
        return self.images[role, index, "CROSS"]

    def polarized(self, role):
        """S, what keeps its polarization."""
        return self.images[role, 0, "PARALLEL"] - self.images[role, 0, "CROSS"]


# Small things


def dot(a, b):
    return np.einsum("...i,...i->...", a, b)


def unit(a):
    return a / np.maximum(np.sqrt(dot(a, a)), 1e-12)[..., None]


def fresnel(cosine):
    """Reflectance of unpolarized light at a smooth surface of index IOR."""
    g = np.sqrt(IOR**2 - 1 + cosine**2)
    first = ((g - cosine) / (g + cosine)) ** 2 / 2
    return first * (1 + ((cosine * (g + cosine) - 1) / (cosine * (g - cosine) + 1)) ** 2)


def v_groove(n_h, n_v, n_l, v_h):
    return np.minimum(1, 2 * n_h * np.minimum(n_v, n_l) / v_h)


def pose(device):
    """Rotation (device from rig) and the device's centre in the rig frame, mm."""
    rotation = np.reshape(device["rotation"], (3, 3))
    return rotation, -rotation.T @ np.array(device["translation_mm"])


def map_by_region(labels, values, shape=()):
    """`values` by label, None where there is none, on every pixel."""
    table = np.full((256, *shape), np.nan)
    for label, value in values.items():
        table[label] = np.nan if value is None else value
    return table[labels]


# Steps


def reconstruct(burst):
    """Positions (mm, rig frame), projector pixels (u, v) and directions to the camera."""
    camera, projector = burst.camera, burst.projector
    rotation, centre = pose(camera)
    y, x = np.indices(burst.labels.shape)
    along = np.stack([(x - camera["cx"]) / camera["fx"], (y - camera["cy"]) / camera["fy"],
                      np.ones(x.shape)], -1)
    ray = unit(along @ rotation)
    u = projector_columns(burst)
    p_rotation, p_centre = pose(projector)
    # Column u is a plane through the projector: its normal in the rig frame.
    normal = projector["fx"] * p_rotation[0] + (projector["cx"] - u)[..., None] * p_rotation[2]
    distance = dot(normal, p_centre - centre) / dot(normal, ray)
    inside = burst.labels > 0
    usual = np.nanmedian(distance[inside])
    distance = np.where(np.abs(distance - usual) < 300, distance, usual).astype(np.float32)
    distance = np.where(inside, cv2.medianBlur(distance, 3), np.nan)
    position = centre + distance[..., None] * ray
    seen = (position - p_centre) @ p_rotation.T
    pixel = np.stack([projector["fx"] * seen[..., 0] / seen[..., 2] + projector["cx"],
                      projector["fy"] * seen[..., 1] / seen[..., 2] + projector["cy"]], -1)
    return position, pixel, -ray


def projector_columns(burst):
    """u of every pixel: phase of ever finer fringes, each told its period by the one before."""
    width, column = burst.projector["width"], None
    for k, periods in enumerate(burst.patterns.get("fringe", {}).get("periods", [1, 4, 16, 64])):
        share = (burst.cross("FRINGE", k) - burst.black) / np.maximum(burst.lit, 1e-4)
        red, green, blue = np.moveaxis(share, -1, 0)
        phase = np.arctan2(math.sqrt(3) * (red - blue), 2 * green - red - blue) / (2 * math.pi) % 1
        turns = 0 if column is None else np.round(column * periods / width - phase)
        column = (phase + turns) * width / periods
    return column


def estimate_normals(burst, to_camera):
    """From the gradients (Ma et al. 2007): one specular normal, a diffuse one per channel."""
    axes = ("GRADIENT_X", "GRADIENT_Y", "GRADIENT_Z")
    full = np.maximum(burst.polarized("GRADIENT_FULL").mean(-1), 1e-4)
    mirror = np.stack([2 * burst.polarized(a).mean(-1) / full - 1 for a in axes], -1)
    specular = unit(unit(mirror) + to_camera)
    full = np.maximum(burst.cross("GRADIENT_FULL"), 1e-4)
    ratio = np.stack([2 * burst.cross(a) / full - 1 for a in axes], -1)  # ... channel, axis
    return specular, unit(ratio)


class Front:
    """What the projector's white does at every pixel."""

    def __init__(self, burst, position, normal, to_camera):
        _, centre = pose(burst.projector)
        way = centre - position
        self.light = unit(way)
        self.n_l = dot(normal, self.light)
        self.n_v = np.clip(dot(normal, to_camera), 0.02, 1)
        half = unit(self.light + to_camera)
        self.n_h = np.clip(dot(normal, half), 0, 1)
        self.v_h = np.clip(dot(to_camera, half), 1e-3, 1)
        self.facing = dot(centre, centre) / dot(way, way)  # radiance of white that faces it
        self.irradiance = self.facing * np.maximum(self.n_l, 0.05)


def fit_lobes(burst, front):
    """p(theta) by region: (theta, p, m), or None where too few pixels show it."""
    theta = np.arccos(front.n_h)
    shown = burst.polarized("FRONT").mean(-1)
    groove = np.maximum(v_groove(front.n_h, front.n_v, front.n_l, front.v_h), 1e-3)
    table = shown * front.n_v / (math.pi * front.facing * fresnel(front.v_h) * groove)
    edges = np.radians(np.arange(CONE_DEG + 1.0))
    middle = (edges[1:] + edges[:-1]) / 2
    usable = np.isfinite(table) & (theta < edges[-1]) & (front.n_l > 0.2) & ~burst.clipped
    lobes = {}
    for label in range(1, len(burst.names)):
        inside = usable & (burst.labels == label)
        if inside.sum() < 200:
            lobes[label] = None
            continue
        bright = inside & (shown > 0.2 * np.percentile(shown[inside], 99))
        bins = np.digitize(theta[bright], edges) - 1
        count = np.bincount(bins, minlength=CONE_DEG)
        mean = np.bincount(bins, table[bright], CONE_DEG) / np.maximum(count, 1)
        known = count > 20
        if known.sum() < 5:
            lobes[label] = None
            continue
        p = np.maximum(np.interp(middle, middle[known], mean[known], right=0), 0)
        step = edges[1]
        p /= 2 * math.pi * step * np.sum(p * np.cos(middle) * np.sin(middle))
        lobes[label] = middle, p, gaussian_width(middle, p)
    return lobes


def gaussian_width(theta, p):
    """m of a exp(-(theta/m)^2), least squares: the best of many m, each with its best a."""
    widths = np.linspace(0.05, 0.8, 1501)
    shapes = np.exp(-((theta / widths[:, None]) ** 2))
    gain = shapes @ p / (shapes**2).sum(1)
    error = ((p - gain[:, None] * shapes) ** 2).sum(1)
    return float(widths[error.argmin()])


def lobe_integrals(lobe, n_v):
    """W of c = 1 under an even sphere of light, for each of `n_v`."""
    theta, p, _ = lobe
    polar, azimuth = np.meshgrid((np.arange(60) + 0.5) * math.pi / 120,
                                 (np.arange(120) + 0.5) * math.pi / 60, indexing="ij")
    light = np.stack([np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth),
                      np.cos(polar)], -1)
    solid = np.sin(polar) * (math.pi / 120) * (math.pi / 60)
    integrals = []
    for cosine in n_v:
        view = np.array([math.sqrt(1 - cosine**2), 0, cosine])
        half = unit(light + view)
        v_h = np.clip(half @ view, 1e-3, 1)
        density = np.interp(np.arccos(np.clip(half[..., 2], 0, 1)), theta, p, right=0)
        groove = v_groove(half[..., 2], cosine, light[..., 2], v_h)
        integrals.append(np.sum(density * fresnel(v_h) * groove * solid) / cosine)
    return np.array(integrals)


def fit_intensity(burst, front, lobes):
    """c = S_full / W."""
    cosines = np.linspace(0.05, 1, 24)
    full = burst.polarized("GRADIENT_FULL").mean(-1)
    c = np.full(burst.labels.shape, np.nan)
    for label, lobe in lobes.items():
        if lobe is None:
            continue
        inside = burst.labels == label
        c[inside] = full[inside] / np.interp(front.n_v[inside], cosines,
                                             lobe_integrals(lobe, cosines))
    return c


def fit_single(burst, front):
    """alpha (1-g)/(1+g)^2 by region and channel, where the surface returns nothing."""
    inside_l = np.sqrt(1 - (1 - front.n_l**2) / IOR**2)
    inside_v = np.sqrt(1 - (1 - front.n_v**2) / IOR**2)
    passed = (1 - fresnel(np.clip(front.n_l, 0.02, 1))) * (1 - fresnel(front.n_v))
    per_amplitude = front.irradiance * passed / (4 * (inside_l + inside_v))
    theta = np.degrees(np.arccos(front.n_h))
    usable = (theta > FAR_DEG[0]) & (theta < FAR_DEG[1]) & (front.n_l > 0.2) & ~burst.clipped
    shown = burst.polarized("FRONT") / per_amplitude[..., None]
    amplitudes = {}
    for label in range(1, len(burst.names)):
        inside = usable & (burst.labels == label)
        enough = inside.sum() >= 50
        amplitudes[label] = np.median(shown[inside], 0) if enough else None
    return amplitudes


def separate(burst, front):
    """Shallow from the swing of the stripes, deep from their minimum."""
    stripes = np.stack([burst.cross("STRIPES", k) - burst.black for k in range(4)])
    least, most = stripes.min(0), stripes.max(0)
    irradiance = front.irradiance[..., None]
    return 2 * (most - least) / irradiance, 4 * least / irradiance


def reduced_albedo(reflectance):
    """alpha' of eq. 8, by a table in s = sqrt(3 (1 - alpha'))."""
    s = np.linspace(1e-6, math.sqrt(3), 4000)
    total = (1 - s**2 / 3) / 2 * (1 + np.exp(-4 / 3 * BOUNDARY * s)) * np.exp(-s)
    return 1 - np.interp(np.clip(reflectance, 0, 0.94), total[::-1], s[::-1]) ** 2 / 3


def dipole(r, alpha, ld):
    """Eq. 7, per mm^2 at r mm."""
    source = math.sqrt(3 * (1 - alpha)) * ld
    total = 0
    for depth in (source, source * (1 + 4 * BOUNDARY / 3)):
        d = np.sqrt(r**2 + depth**2)
        total = total + depth * (1 / ld + 1 / d) * np.exp(-d / ld) / d**2
    return alpha / (4 * math.pi) * total


def dot_tables(pitch_mm, radius_mm, lengths, albedos, rings):
    """Light that leaks into a dot of the periodic pattern: albedo x length x ring."""
    cells = 96
    at = (np.arange(cells) - cells // 2) * pitch_mm / cells
    x, y = np.meshgrid(at, at)
    r = np.hypot(x, y)
    lit = np.fft.rfft2((r >= radius_mm).astype(float))
    ring = np.digitize(r, rings) - 1
    area = (pitch_mm / cells) ** 2
    far = [np.hypot(x + i * pitch_mm, y + j * pitch_mm) for i in (-1, 0, 1) for j in (-1, 0, 1)]
    table = np.empty((len(albedos), len(lengths), len(rings) - 1))
    for a, alpha in enumerate(albedos):
        for b, ld in enumerate(lengths):
            kernel = sum(dipole(distance, alpha, ld) for distance in far) * area
            leaked = np.fft.irfft2(np.fft.rfft2(np.fft.ifftshift(kernel)) * lit, (cells, cells))
            table[a, b] = [leaked[ring == k].mean() for k in range(len(rings) - 1)]
    return table


def fit_dots(burst, front, position, pixel, deep_alpha):
    """l_d (mm) by region and channel, the median over its dots; and how many there were."""
    pattern = burst.patterns.get("dots", {})
    pitch, diameter = pattern.get("pitch_px", 53.33), pattern.get("diameter_px", 20)
    rotation, _ = pose(burst.projector)
    to_mm = burst.projector["translation_mm"][2] / burst.projector["fx"]
    radius = diameter / 2 * to_mm
    rings = np.linspace(0, DOT_RADIUS_SHARE * radius, RINGS + 1)
    lengths, albedos = np.geomspace(0.3, 6, 48), 1 - np.geomspace(0.004, 0.5, 20)
    table = dot_tables(pitch * to_mm, radius, lengths, albedos, rings)
    area = rings[1:] ** 2 - rings[:-1] ** 2

    grid = (pixel - np.array(pattern.get("offset_px", [640, 400]))) / pitch
    cell = np.round(grid)
    off = np.hypot(*np.moveaxis(grid - cell, -1, 0)) * pitch
    near = (burst.labels > 0) & (off < 0.75 * diameter) & np.isfinite(off)
    albedo = 2 * (burst.cross("DOTS") - burst.black) / front.irradiance[..., None]
    key = ((cell[..., 0] + 500) * 1000 + cell[..., 1] + 500)[near].astype(int)
    order = np.argsort(key, kind="stable")
    dots = np.split(np.flatnonzero(near)[order], np.flatnonzero(np.diff(key[order])) + 1)
    flat = {"off": off, "clipped": burst.clipped, "facing": front.n_l, "label": burst.labels}
    flat = {name: image.reshape(-1) for name, image in flat.items()}
    where, shown, alphas = (image.reshape(-1, 3) for image in (position, albedo, deep_alpha))

    found = {label: [] for label in range(1, len(burst.names))}
    whole = np.median([len(pixels) for pixels in dots]) if dots else 0
    for pixels in dots:
        label = np.bincount(flat["label"][pixels]).argmax()
        middle = pixels[flat["off"][pixels] < 0.25 * diameter]
        if (len(pixels) < whole / 2 or len(middle) < 5 or flat["clipped"][pixels].any()
                or flat["facing"][pixels].mean() < 0.5
                or (flat["label"][pixels] == label).mean() < 0.8):
            continue
        distance = np.linalg.norm(where[pixels] - where[middle].mean(0), axis=1)
        ring = np.digitize(distance, rings) - 1
        known = np.bincount(ring, minlength=RINGS)[:RINGS] > 0
        lds = []
        for channel in range(3):
            profile = np.array([shown[pixels[ring == k], channel].mean()
                                for k in np.flatnonzero(known)])
            alpha = np.median(alphas[pixels, channel])
            of_alpha = table[np.abs(albedos - alpha).argmin()][:, known]
            error = (of_alpha - profile) ** 2 @ area[known]
            lds.append(lowest_point(np.log(lengths), error))
        found[label].append(np.exp(lds))
    return {label: (np.median(lds, 0), len(lds)) if lds else None for label, lds in found.items()}


def lowest_point(x, y):
    """Where the parabola through the least of evenly spaced samples and its neighbours is least."""
    i = int(y.argmin())
    if i in (0, len(y) - 1):
        return x[i]
    bend = y[i - 1] - 2 * y[i] + y[i + 1]
    return x[i] + (x[1] - x[0]) * (y[i - 1] - y[i + 1]) / (2 * bend)


# The whole


class Steps:
    """Seconds of what was done, by name."""

    def __init__(self):
        self.seconds = {}

    def __call__(self, name, work, *arguments):
        start = time.perf_counter()
        result = work(*arguments)
        self.seconds[name] = time.perf_counter() - start
        return result


def region_figures(burst, lobes, amplitudes, dots):
    regions = []
    for label, name in enumerate(burst.names[1:], 1):
        region = {"name": name}
        if lobes[label]:
            theta, p, m = lobes[label]
            region["specular"] = {"theta": theta.tolist(), "p": p.tolist(), "gaussian_m": m}
        if amplitudes[label] is not None:
            region["single"] = {"amplitude": amplitudes[label].tolist()}
        if dots[label]:
            region["deep"] = {"ld_mm": dots[label][0].tolist(), "dots": dots[label][1]}
        regions.append(region)
    return regions


def write_maps(folder, labels, maps):
    unknown = labels == 0
    for name, (channels, values) in maps.items():
        values = values.reshape(*labels.shape, len(channels)).copy()
        values[unknown] = np.nan
        write_exr(folder / f"{name}.exr", channels, values)
    cv2.imwrite(str(folder / "regions.png"), labels)


def fit(session, folder):
    steps = Steps()
    burst = steps("read", Burst, session)
    position, pixel, to_camera = steps("geometry", reconstruct, burst)
    specular, diffuse = steps("normals", estimate_normals, burst, to_camera)
    front = steps("front", Front, burst, position, specular, to_camera)
    lobes = steps("lobes", fit_lobes, burst, front)
    c = steps("intensity", fit_intensity, burst, front, lobes)
    amplitudes = steps("single", fit_single, burst, front)
    shallow, deep = steps("separate", separate, burst, front)
    alpha = steps("alpha", reduced_albedo, deep)
    dots = steps("dots", fit_dots, burst, front, position, pixel, alpha)
    labels = burst.labels
    ld = map_by_region(labels, {k: v and v[0] for k, v in dots.items()}, (3,))
    # alpha of eq. 3 at the g that the paper found.
    per_amplitude = (1 + 0.65) ** 2 / (1 - 0.65)
    single = map_by_region(labels, amplitudes, (3,)) * per_amplitude
    total = 2 * burst.lit / front.irradiance[..., None]
    steps("write", write_maps, folder, labels, {
        "position": ("XYZ", position),
        "normal_specular": ("XYZ", specular),
        "normal_diffuse": ([f"{k}.{a}" for k in "rgb" for a in "XYZ"], diffuse),
        "specular_intensity": ("Y", c),
        "single_albedo": ("RGB", single),
        "total_albedo": ("RGB", total),
        "shallow_albedo": ("RGB", shallow),
        "deep_albedo": ("RGB", deep),
        "deep_alpha": ("RGB", alpha),
        "deep_ld": ("RGB", ld)})
    layers = {"format": "lamella.layers.v1", "ior": IOR,
              "regions": region_figures(burst, lobes, amplitudes, dots),
              "timings_s": steps.seconds}
    (folder / "layers.json").write_text(json.dumps(layers))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("session", type=pathlib.Path)
    parser.add_argument("--out", type=pathlib.Path, required=True)
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    fit(arguments.session, arguments.out)


if __name__ == "__main__":
    main()
