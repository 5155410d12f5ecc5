"""Synthetic force-distance curves of JKR spheres with an instrument's noise, and files of them in each format."""

import struct

import numpy as np
import xarray as xr

RADIUS = 2000.0
MODULUS = 40.0
WORK = 0.02
STIFFNESS = 1.0
PULL = 1.5 * np.pi * WORK * RADIUS


def sphere(piezo, work=WORK, stiffness=STIFFNESS):
    """Return the force (nN), without noise, of a JKR sphere on a spring, with the jumps of loading or retraction."""
    a = np.linspace(1.0, 140.0, 20000)
    force = 4 * MODULUS * a**3 / (3 * RADIUS) - np.sqrt(8 * np.pi * work * MODULUS * a**3)
    travel = a**2 / RADIUS - np.sqrt(2 * np.pi * work * a / MODULUS) + force / stiffness
    fold = int(np.argmin(travel))  # where the contact becomes unstable on the spring
    away = piezo[0] > piezo[-1]
    touching = piezo > (travel[fold] if away else 0.0)
    return np.where(touching, np.interp(piezo, travel[fold:], force[fold:]), 0.0)


def noisy_force(rng, piezo, noise=1.0, **sphere_options):
    """Return a sphere's force with noise, an offset, a drift in time and a virtual deflection."""
    drift = rng.normal(0, 5) * np.linspace(0, 1, piezo.size)
    line = rng.normal(0, 30) + rng.normal(0, 0.02) * piezo
    return sphere(piezo, **sphere_options) + line + drift + rng.normal(0, noise, piezo.size)


def retraction_with_tail(rng, kind):
    """Return piezo, force and pull-off force (nN) of a retraction of the given kind, with noise, offset and tilt."""
    length = rng.uniform(1000, 4000)
    n = int(rng.choice([400, 1000, 3000]))
    z = np.linspace(length, 0, n)
    pull = rng.uniform(50, 900)
    noise = 10 ** rng.uniform(-0.5, 1.0)
    flat = rng.uniform(0.25, 0.6) * length
    zero = rng.uniform(0.75, 0.85) * length
    lowest = flat + rng.uniform(0.2, 0.5) * (zero - flat)
    force = np.interp(z, [0, flat, flat + 1e-6, zero, length], [0, 0, -pull, 0, 3 * pull])
    if kind == "linear tail":
        force = np.interp(z, [0, flat, lowest, zero, length], [0, 0, -pull, 0, 3 * pull])
    if kind == "exponential tail":
        tail = -pull * np.exp((z - lowest) / rng.uniform(0.02 * length, 0.12 * length))
        force = np.where(z < lowest, tail, np.interp(z, [lowest, zero, length], [-pull, 0, 3 * pull]))
    if kind == "fringe":
        force += rng.uniform(2, 15) * np.sin(2 * np.pi * z / rng.uniform(250, 800) + rng.uniform(0, 6))
    if kind == "second rupture":
        still = rng.uniform(5, 40)
        force = force - np.where(z < rng.uniform(0.3, 0.7) * flat, 0, still)
        pull = pull + still
    white = rng.normal(0, 1, n + 39)
    memory = np.exp(-np.arange(40) / 8.0) if kind == "slow noise" else np.eye(40)[0]
    noise_of_detector = noise * np.convolve(white, memory / np.sqrt((memory**2).sum()), "valid")
    return z, force + noise_of_detector + rng.normal(0, 50) + rng.normal(0, 0.02) * z, pull


#: Returns of the force after the largest tension: shares of it that are left after a way, for a decay length.
SLOW_RETURNS = {
    "exponential": lambda way, decay, share: np.exp(-way / decay),
    "power": lambda way, decay, share: 1 / (1 + way / decay) ** 2,
    "jump and tail": lambda way, decay, share: np.where(way > 0, (1 - share) * np.exp(-way / decay), 1.0),
}


def retraction_with_slow_return(rng, kind):
    """Return piezo, force and pull-off force (nN) of a retraction whose tension is lost slowly, with some waves."""
    length = rng.uniform(500, 4000)
    piezo = np.linspace(length, 0, int(rng.choice([500, 1000, 2000])))
    pull = 10 ** rng.uniform(-1, 2)
    zero = rng.uniform(0.7, 0.9) * length
    rise = 0.03 * length
    way = np.maximum(zero - rise - piezo, 0)
    remainder = SLOW_RETURNS[kind](way, rng.uniform(0.03, 0.2) * length, rng.uniform(0.3, 0.8))
    force = np.where(way > 0, -remainder, -np.clip((zero - piezo) / rise, -5, 1))
    turns = 2 * np.pi * piezo / (rng.uniform(0.2, 1.5) * length) + rng.uniform(0, 2 * np.pi)
    force += rng.choice([0, 0.01, 0.03]) * np.sin(turns) + rng.normal(0, 0.02) * piezo / length
    noise = 10 ** rng.uniform(-2.5, -1.3)
    return piezo, pull * (force + rng.normal(0, noise, piezo.size)), pull


def retraction_with_fringes(rng, amplitude, *, shape="sine"):
    """Return piezo, force and pull-off force (nN) of a retraction with a jump, and interference about its baseline.

    ``amplitude`` is that of the interference over the pull; lengths, noise, tilt and drift are drawn at random.
    """
    length = rng.uniform(300, 4000)
    n = int(rng.choice([500, 1000, 2000, 4000]))
    z = np.linspace(length, 0, n)
    pull = 10 ** rng.uniform(-1, 3)
    zero = rng.uniform(0.3, 0.9) * length
    stiffness = pull / (rng.uniform(0.02, 0.3) * zero)
    force = np.where(z > zero - pull / stiffness, (z - zero) * stiffness, 0.0)
    period = rng.uniform(0.15, 2.0) * zero
    phase = rng.uniform(0, 2 * np.pi)
    turns = 2 * np.pi * z / period + phase
    if shape == "chirp":
        wave = (1 + 0.6 * (z / length - 0.5)) * np.sin(turns * (1 + 0.1 * z / length))
    elif shape == "two":
        wave = (np.sin(turns) + 0.5 * np.sin(turns / rng.uniform(0.3, 0.7))) / 1.2
    elif shape == "triangle":
        wave = 2 / np.pi * np.arcsin(np.sin(turns))
    else:
        wave = np.sin(turns)
    tilt = rng.normal(0, 0.1) * z / length
    drift = rng.normal(0, 0.03) * np.linspace(0, 1, n)
    noise = 10 ** rng.uniform(-3, -1.3) * rng.normal(size=n)
    return z, force + pull * (amplitude * wave + tilt + drift + rng.normal() + noise), pull


def fringes_without_pull(rng, amplitude, *, shape="sine"):
    """Return piezo and force of a retraction without adhesion, with interference of ``amplitude`` times its noise."""
    length = rng.uniform(300, 4000)
    count = int(rng.choice([500, 1000, 2000, 4000]))
    z = np.linspace(length, 0, count)
    contact = rng.uniform(0.3, 0.9) * length
    slope = rng.uniform(20, 200) * max(amplitude, 1) / (length - contact)
    turns = 2 * np.pi * z / (rng.uniform(0.15, 2) * contact) + rng.uniform(0, 2 * np.pi)
    wave = {"sine": np.sin(turns), "triangle": 2 / np.pi * np.arcsin(np.sin(turns))}[shape]
    tilt = rng.normal(0, max(amplitude, 1)) * z / length
    return z, np.maximum(z - contact, 0.0) * slope + amplitude * wave + tilt + rng.normal(size=count)


def weak_retractions(rng, pulls, noise=1.0):
    """Return retractions that end with a jump from each pull, on white noise, as a Dataset."""
    piezo = np.linspace(400.0, 0.0, 800)
    force = np.where(piezo > 300.0, 0.5 * (piezo - 300.0) - np.asarray(pulls)[:, None], 0.0)
    force += rng.normal(0, noise, force.shape)
    dims = ("subregion", "sample")
    return xr.Dataset({"piezo": ("sample", piezo, {"units": "nm"}), "force": (dims, force, {"units": "nN"})})


#: Tensions of soft contacts, over the pull, at shares 0 to 1 of the way from the contact to the detachment.
TENSIONS = {"plateau": np.ones_like, "root": np.sqrt, "ramp": np.asarray}


def soft_retractions(rng, pulls, drift, period, *, tension="plateau", noise=0.006):
    """Return retractions (nm, nN) of a soft Hertz contact 1.5 µm deep, with drift of a period, as a Dataset."""
    piezo = np.linspace(8000.0, 0.0, 2000)
    depth = piezo - 6000.0
    way = np.clip(-depth / 300.0, 0.0, 1.0)
    pulled = np.where((depth <= 0) & (depth > -300), TENSIONS[tension](way), 0.0)
    pulled += np.where((depth > 0) & (depth < 200), 1 - depth / 200, 0.0) * (tension == "plateau")
    force = np.maximum(depth / 1500.0, 0.0) ** 1.5 - np.asarray(pulls)[:, None] * pulled
    phase = rng.uniform(0, 2 * np.pi, (len(pulls), 1))
    force = force + drift * np.sin(2 * np.pi * piezo / period + phase) + rng.normal(0, noise, force.shape)
    dims = ("subregion", "sample")
    return xr.Dataset({"piezo": ("sample", piezo, {"units": "nm"}), "force": (dims, force, {"units": "nN"})})


def cycle(rng, n=800, **options):
    """Return piezo (nm) and force (nN) of both branches."""
    there = np.linspace(-800.0, 150.0, n)
    return [(piezo, noisy_force(rng, piezo, **options)) for piezo in (there, there[::-1])]


def write_afmformats(path, count=4, fmt="hdf5", seed=0, **options):
    """Write cycles on a square grid of 500 nm as afmformats exports them; return them."""
    import h5py
    from afmformats import AFMForceDistance

    rng = np.random.default_rng(seed)
    cycles = [cycle(rng, **options) for _ in range(count)]
    side = int(np.ceil(np.sqrt(count)))
    curves = [AFMForceDistance(*_contents(path, k, side, cycle_of_curve)) for k, cycle_of_curve in enumerate(cycles)]
    if fmt == "tab":
        curves[0].export_data(path, fmt="tab")
        return cycles
    with h5py.File(path, "w") as file:
        for curve in curves:
            curve.export_data(file, fmt="hdf5")
    return cycles


def _contents(path, number, side, branches):
    piezo, force = (np.concatenate(parts) for parts in zip(*branches))
    segment = np.repeat([0, 1], [branches[0][0].size, branches[1][0].size]).astype(np.uint8)
    columns = {"force": force * 1e-9, "height (measured)": -piezo * 1e-9, "segment": segment}
    header = {"spring constant": STIFFNESS, "sensitivity": 5e-8, "imaging mode": "force-distance", "enum": number}
    header |= {"position x": (number // side) * 5e-7, "position y": (number % side) * 5e-7, "path": path}
    return columns, header | {"point count": force.size}


#: NanoScope's size of a count, V; its sensitivities of deflection, piezo and height sensor, nm/V.
VOLTS_PER_COUNT = 0.000375
DEFLECTION_SENSITIVITY = 50.0
PIEZO_SENSITIVITY = 12.5
SENSOR_SENSITIVITY = 80.0


def write_nanoscope_curves(
    path,
    cycles,
    *,
    dtype="<i4",
    bits=0,
    sensor=False,
    volume=False,
    capture=False,
    trigger=True,
    lacking="",
    stopped=None,
    finer=1,
):
    """Write cycles as NanoScope's force curves: extension, then retraction, both from contact outwards.

    ``stopped`` is the number of samples of extensions that the trigger stopped, before filler; ``finer`` the ratio of
    the image's lines to the curves'.
    """
    heights, forces = (
        [part for branches in cycles for part in parts(branches)] for parts in (_outwards(0), _outwards(1))
    )
    counts = np.concatenate(forces) / (STIFFNESS * DEFLECTION_SENSITIVITY * VOLTS_PER_COUNT) * 2**bits
    channels = [("DeflectionError", "DeflSens", counts)]
    if sensor:
        channels.append(("ZSensor", "ZsensSens", np.concatenate(heights) / (SENSOR_SENSITIVITY * VOLTS_PER_COUNT)))
    size = cycles[0][0][0].size
    if stopped is not None:
        counts.reshape(-1, 2, size)[:, 0, stopped:] = -32768
    threshold = float(forces[0].max() - np.median(forces[0][-size // 4 :])) / (STIFFNESS * DEFLECTION_SENSITIVITY)
    ramp = np.ptp(heights[0]) / PIEZO_SENSITIVITY
    head = ["\\*Force file list", "\\Start context: FVOL" if volume else "\\Start context: FOL"]
    head += ["\\*Scanner list", f"\\@Sens. Zsens: V {PIEZO_SENSITIVITY} nm/V", "\\*Ciao scan list"]
    head += ["\\Operating mode: Image"] if capture else [f"\\Operating mode: Force{' Volume' * volume}"]
    head += ["\\PeakForce Capture: Allow", "\\Peak Force Amplitude: 100"] if capture else []
    head += ["\\Sample Points: 256", f"\\Sync Distance QNM: {size}"] if capture else []
    head += ["\\Scan Size: 2000 nm", "\\Samps/line: 256"]
    head += [f"\\@Sens. DeflSens: V {DEFLECTION_SENSITIVITY} "]  # some versions leave out nm/V
    head += [f"\\@Sens. ZsensSens: V {SENSOR_SENSITIVITY} nm/V", "\\*Ciao force list"]
    head += [f"\\force/line: {round(len(cycles) ** 0.5)}"] * (finer > 1)
    head += [f"\\Trigger mode: {'Relative' if trigger else 'Off'}"]
    head += [f"\\@4:Trig Threshold Deflection: V [Sens. DeflSens] ({VOLTS_PER_COUNT} V/LSB) {threshold:.6f} V"]
    offset = 8192
    for title, sensitivity, values in channels:
        length = values.size * np.dtype(dtype).itemsize
        head += ["\\*Ciao force image list", f"\\Data offset: {offset}", f"\\Data length: {length}", "\\Bytes/pixel: 2"]
        head += [f"\\Samps/line: {size} {stopped or size}", f"\\Spring Constant: {STIFFNESS}"]
        head += [f"\\Samps/line, retrace: {size}"] * (stopped is not None)
        head += [f'\\@4:Image Data: S [{title}] "{title}"']
        head += [f"\\@4:Z scale: V [Sens. {sensitivity}] ({VOLTS_PER_COUNT} V/LSB) 2.500000 V"]
        head += [f"\\@4:Ramp Size: V [Sens. Zsens] (0.006713765 V/LSB) {ramp:.6f} V"]
        offset += length
    if volume or capture:
        side = round(len(cycles) ** 0.5) * finer
        head += ["\\*Ciao image list", f"\\Samps/line: {side}", f"\\Number of lines: {side}", "\\Scan Size: 2 2 ~m"]
    text = "\r\n".join(line for line in head if not (lacking and lacking in line)) + "\r\n\\*File list end\r\n\x1a"
    samples = b"".join(np.round(values).astype(dtype).tobytes() for _, _, values in channels)
    path.write_bytes(text.encode("latin-1").ljust(8192, b"\0") + samples)
    return path


def _outwards(part):
    """Return a function of a cycle that gives piezo or force of both branches from contact outwards."""
    return lambda branches: (branches[0][part][::-1], branches[1][part])


def write_jpk_text(path, branches, unit="N"):
    """Write a cycle as JPK's programs export text, with a pause in contact."""
    scale = {"N": 1e-9, "pN": 1e3, "m": 1e-9 / STIFFNESS, "nm": 1 / STIFFNESS, "V": 1e-9 / (STIFFNESS * 50e-9)}[unit]
    pause = np.full(50, branches[0][0][-1]), np.full(50, branches[0][1][-1])
    lines = ["# TEXT EXPORT", "# xPosition: 2.0E-6", "# yPosition: 3.0E-6", "#"]
    for segment, (piezo, force) in zip(("extend", "pause", "retract"), (branches[0], pause, branches[1])):
        lines += [f"# segment: {segment}", "# columns: height vDeflection strainGaugeHeight time"]
        lines += ["# sensitivity: 5.0E-8", f"# springConstant: {STIFFNESS}", f"# units: m {unit} m s", "#"]
        lines += [f"{-2e-9 * z:.12e} {f * scale:.10e} {-1e-9 * z:.12e} 0.1" for z, f in zip(piezo, force)] + [""]
    path.write_text("\n".join(lines) + "\n")
    return path


def write_nanoscope_text(path, branches, *, unit="pN", head=True):
    """Write a cycle as NanoScope Analysis exports text."""
    scale = {"pN": 1e3, "nm": 1 / STIFFNESS, "V": 1 / (STIFFNESS * DEFLECTION_SENSITIVITY)}[unit]
    lines = ['"\\?Force file list"', f'"\\@Sens. DeflSens: V {DEFLECTION_SENSITIVITY} nm/V"'] if head else []
    lines += [f'"\\Spring Constant: {STIFFNESS}"', '"\\*Force file list end"'] if head else []
    lines += [f"Time_s_Ex\tCalc_Ramp_Ex_nm\tCalc_Ramp_Rt_nm\tDefl_{unit}_Ex\tDefl_{unit}_Rt\t"]
    rows = np.c_[branches[0][0] * 0, branches[0][0], branches[1][0], branches[0][1] * scale, branches[1][1] * scale]
    lines += ["\t".join(f"{number:.9e}" for number in row) + "\t" for row in rows]
    path.write_text("\n".join(lines) + "\n")
    return path


def write_workshop(path, branches, volts=True):
    """Write a cycle as AFM Workshop does: in volts without their sensitivity, or in forces."""
    (there, pushed), (back, drawn) = branches
    unit, scale = ("T-B(V)", 1 / (50.0 * STIFFNESS)) if volts else ("Force(nN)", 1.0)
    head = ["Force-Distance Curve", "File Format:\t3", "", "Date:\tWednesday, August 1, 2018", "Time:\t1:06:09 PM"]
    head += ["Mode:\tSingle", "Point:\t1", "X, um:\t2.5", "Y, um:\t4.0", ""]
    head += [f"Extend Z-Sense(nm),Extend {unit},Retract Z-Sense(nm),Retract {unit}"]
    rows = np.c_[there, pushed * scale, back, drawn * scale]
    path.write_text("\n".join(head + [",".join(f"{v:.10g}" for v in row) for row in rows]) + "\n")


def write_nt_mdt(path, branches):
    """Write a cycle as NT-MDT's Nova exports it: height in nm, deflection in nA of both branches, one line a height."""
    (there, pushed), (_, drawn) = branches
    rows = np.c_[-there, pushed / (50.0 * STIFFNESS), drawn[::-1] / (50.0 * STIFFNESS)][::-1]
    path.write_text("\n".join("\t".join(f"{v:.10g}".replace(".", ",") for v in row) for row in rows) + "\n")


def write_chiaro(path, branches):
    """Write a cycle as Optics11's Chiaro does: load in µN, indentation, bending and piezo in nm, with a head."""
    piezo, force = (np.concatenate(parts) for parts in zip(*branches))
    head = ["Date\t01/08/2018", "Time\t13:06:09", "Device:\tChiaro", "Software version\t1.0", f"k (N/m)\t{STIFFNESS}"]
    head += ["Max load (µN)\t0.1", "Piezo position (nm) (Measured)\t100", "Piezo speed  (µm/s)\t1", ""]
    head += ["Time (s)\tLoad (uN)\tIndentation (nm)\tCantilever (nm)\tPiezo (nm)\tAuxiliary"]
    bent = force / STIFFNESS
    rows = np.c_[np.arange(piezo.size) * 1e-3, force * 1e-3, piezo - bent, bent, piezo, 0 * piezo]
    lines = ["\t".join(f"{number:.10g}" for number in row) for row in rows]
    path.write_text("\n".join(head + lines), encoding="ISO-8859-1")


def write_asylum(path, branches):
    """Write a cycle as an Igor wave of version 5 of three columns, Raw, Defl, ZSnsr in m, without a turning point."""
    piezo, force = (np.concatenate(parts) for parts in zip(*branches))
    _write_wave(path, np.stack([piezo, force / STIFFNESS, piezo]) * 1e-9, _NOTE, ("", "Raw", "Defl", "ZSnsr"))


def write_asylum_pair(folder, name, branches, place=(0.0, 0.0)):
    """Write a cycle with a pause as Asylum's maps: waves of deflection and sensor, turning points in their notes."""
    piezo, force = (np.concatenate([there, np.full(50, there[-1]), back]) for there, back in zip(*branches))
    turns = np.cumsum([0, branches[0][0].size - 1, 50, branches[1][0].size])
    note = _NOTE | {"Indexes": ",".join(map(str, turns)) + ",", "Direction": "NaN,1,0,-1,"}
    note |= {f"{axis}LVDT": value * 1e-9 for axis, value in zip("XY", place)}
    for end, values in (("Defl", force / STIFFNESS), ("ZSnsr", piezo)):
        _write_wave(folder / f"{name}{end}.ibw", values[None] * 1e-9, note)
    return folder / f"{name}Defl.ibw"


def _write_wave(path, columns, note, labels=()):
    """Write columns as an Igor wave of version 5, of one dimension without labels."""
    columns = columns.astype("<f4")
    note = "\r".join(f"{key}:{value}" for key, value in note.items()).encode()
    labels = b"".join(name.encode().ljust(32, b"\0") for name in labels)
    wave = _wave_header(columns.shape[1], columns.shape[0] if labels else 0)
    sizes = struct.pack("<15i", len(wave) + columns.nbytes, 0, len(note), 0, 0, 0, 0, 0, 0, len(labels), *[0] * 5)
    head = struct.pack("<hh", 5, 0) + sizes[:60]
    checksum = -int(np.frombuffer(head + wave, "<i2").sum(dtype=np.int64)) & 0xFFFF
    head = struct.pack("<hH", 5, checksum) + sizes[:60]
    path.write_bytes(head + wave + columns.tobytes() + note + labels)


_NOTE = {"BaseName": "curve", "ImagingMode": "Contact", "NumPtsPerSec": 1000, "InvOLS": 5e-8}
_NOTE |= {"SpringConstant": STIFFNESS, "InputTime": 1, "TriggerChannel": "Force", "TriggerPoint": 1e-7}
_NOTE |= {"ApproachVelocity": 1e-6, "RetractVelocity": 1e-6, "MicroscopeModel": "MFP3D", "Version": 1}
_NOTE |= {"Date": "2018-08-01", "Time": "13:06:09"}


def _wave_header(rows, columns):
    """Return the 320 bytes of an Igor wave's header of version 5."""
    head = bytearray(320)
    struct.pack_into("<IIi", head, 4, 0, 0, rows * max(columns, 1))  # dates, samples
    struct.pack_into("<h", head, 16, 2)  # single precision
    head[28:32] = b"wave"
    struct.pack_into("<4i", head, 68, rows, columns, 0, 0)
    struct.pack_into("<4d", head, 84, 1.0, 1.0, 1.0, 1.0)
    return bytes(head)


def write_jpk(path, cycles, places=None, stated=True, styles=("extend", "retract")):
    """Write cycles as a JPK force map: an archive of properties and big-endian integers, scaled in steps V → m → N."""
    import zipfile

    places = places or [(0.0, 0.0)] * len(cycles)
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("header.properties", "jpk-data-file=spm-forcefile\ntype=force-scan-map\n")
        archive.writestr("index/", "")
        for k, (branches, place) in enumerate(zip(cycles, places)):
            header = "".join(f"force-scan-series.header.position.{a}={v * 1e-9!r}\n" for a, v in zip("xy", place))
            header += f"force-scan-series.header.position-index={k}\n"
            archive.writestr(f"index/{k}/", "")
            archive.writestr(f"index/{k}/header.properties", header)
            archive.writestr(f"index/{k}/segments/", "")
            for segment, (style, (piezo, force)) in enumerate(zip(styles, branches)):
                _write_jpk_segment(archive, f"index/{k}/segments/{segment}/", style, piezo, force, stated)


def _write_jpk_segment(archive, folder, style, piezo, force, stated):
    archive.writestr(folder, "")
    settings = {"duration": 1.0, "z-start": 0.0, "z-end": 1e-6, "type": f"z-{style}-force"}
    lines = {f"settings.segment-settings.{key}": value for key, value in settings.items()}
    lines |= {"settings.style": style, "settings.feedback-mode.name": "contact", "approach-id": "one"}
    lines |= {"duration": 1.0, "num-points": piezo.size, "time-stamp": "2026-01-01 10\\:00\\:00 +0000"}
    text = "".join(f"force-segment-header.{key}={value}\n" for key, value in lines.items())
    volts = force / (50.0 * STIFFNESS)
    text += _jpk_channel(archive, folder, "measuredHeight", -piezo * 1e-9, [("nominal", "volts", 1.0, "m")])
    slots = [("distance", "volts", 5e-8, "m"), ("force", "distance", STIFFNESS, "N")]
    vertical = _jpk_channel(archive, folder, "vDeflection", volts, slots)
    text += (
        vertical
        if stated
        else "\n".join(line for line in vertical.split("\n") if "conversion." not in line or ".name" in line)
    )
    archive.writestr(f"{folder}segment-header.properties", text)


def _jpk_channel(archive, folder, name, values, slots):
    """Write a channel's integers; return the properties that convert them to values with units."""
    step = np.abs(values).max() / 2**30
    archive.writestr(f"{folder}channels/{name}.dat", np.rint(values / step).astype(">i4").tobytes())
    properties = {"data.encoder.type": "signedinteger", "data.encoder.scaling.offset": 0.0}
    properties |= {"data.encoder.scaling.multiplier": step, "conversion-set.conversions.base": "volts"}
    for slot, base, times, unit in slots:
        scaling = {"offset": 0.0, "multiplier": times, "unit.unit": unit}
        properties |= {f"conversion-set.conversion.{slot}.scaling.{key}": value for key, value in scaling.items()}
        properties[f"conversion-set.conversion.{slot}.base-calibration-slot"] = base
        properties[f"conversion-set.conversion.{slot}.name"] = slot
    return "".join(f"channel.{name}.{key}={value!s}\n" for key, value in properties.items())
