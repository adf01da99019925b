"""Performances as other programs write them, made from planted numbers."""

from __future__ import annotations

import io
import json
import struct
from collections.abc import Sequence

import numpy as np

LABELS = ("brow_left", "brow_right", "cheek_left", "cheek_right", "nose", "lip", "chin", "jaw_left", "jaw_right")
FACE = np.array(
    [
        [30, 45, 8], [-30, 45, 8], [48, -5, -14], [-48, -5, -14], [0, 0, 30], [0, -30, 20], [0, -62, 10],
        [40, -45, -18], [-40, -45, -18],
    ],
    dtype=np.float64,
)  # fmt: skip


def performance(frames: int = 24, seed: int = 0) -> np.ndarray:
    """Positions (L, 9, 3), mm: a face that talks a little."""
    rng = np.random.default_rng(seed)
    time = np.linspace(0, 2 * np.pi, frames)[:, None, None]
    return FACE + 3 * np.sin(time + rng.uniform(0, 6, (1, 9, 3)))


def c3d_bytes(
    positions: np.ndarray,
    labels: Sequence[str] = LABELS,
    fps: float = 120.0,
    *,
    scale: float = 0.01,
    processor: str = "intel",
    unit: bytes = b"mm",
    used: int | None = None,
    last: int | None = None,
    analog: int = 0,
    extra: Sequence[tuple[bytes, bytes]] = (),
) -> bytes:
    """A C3D file: 16-bit counts of ``scale`` mm, or floats where it is negative; NaN is a gap (residual -1)."""
    order = ">" if processor == "mips" else "<"
    frames, count = positions.shape[:2]
    width = max(len(label) for label in labels)
    words = b"".join(label.encode().ljust(width) for label in labels)

    def number(value: float) -> bytes:
        raw = np.array([value], f"{order}f4")
        return _dec(raw) if processor == "dec" else raw.tobytes()

    body = _record(b"POINT", -1, b"", order)
    for name, kind, shape, data in (
        (b"USED", 2, (), struct.pack(f"{order}H", count if used is None else used)),
        (b"SCALE", 4, (), number(scale)),
        (b"RATE", 4, (), number(fps)),
        (b"DATA_START", 2, (), struct.pack(f"{order}H", 4)),
        (b"UNITS", -1, (len(unit),), unit),
        (b"LABELS", -1, (width, len(labels)), words),
    ):
        body += _record(name, 1, struct.pack("<bB", kind, len(shape)) + bytes(shape) + data, order)
    body += _record(b"ANALOG", -2, b"", order)
    body += _record(b"USED", 2, struct.pack("<bB", 2, 0) + struct.pack(f"{order}H", analog), order)
    for name, data in extra:
        body += _record(name, 1, data, order)
    parameters = (bytes([1, 0x50, 2, {"intel": 84, "dec": 85, "mips": 86}[processor]]) + body).ljust(1024, b"\0")
    assert len(parameters) == 1024
    head = bytearray(512)
    struct.pack_into(f"{order}5H", head, 2, count, analog, 1, frames if last is None else last, 0)
    head[0:2] = b"\2\x50"
    head[12:16] = number(scale)
    struct.pack_into(f"{order}HH", head, 16, 4, 1 if analog else 0)
    head[20:24] = number(fps)
    table = np.zeros((frames, 4 * count + analog))
    gap = ~np.isfinite(positions).all(axis=2)
    points = np.zeros((frames, count, 4))
    points[..., :3] = np.where(gap[..., None], 0, positions) / (scale if scale > 0 else 1)
    points[..., 3] = np.where(gap, -1, 0)
    table[:, : 4 * count] = points.reshape(frames, 4 * count)
    if scale < 0:
        raw = table.astype(f"{order}f4")
        data = _dec(raw) if processor == "dec" else raw.tobytes()
    else:
        data = np.rint(table).astype(f"{order}i2").tobytes()
    return bytes(head) + parameters + data + bytes(-len(data) % 512)


def _dec(raw: np.ndarray) -> bytes:
    words = (raw.astype(np.float32) * 4).view(np.uint32)
    return np.stack([words >> 16, words & 0xFFFF], axis=-1).astype("<u2").tobytes()


def _record(name: bytes, group: int, data: bytes, order: str) -> bytes:
    return struct.pack("<bb", len(name), group) + name + struct.pack(f"{order}h", 3 + len(data)) + data + b"\0"


def trc_text(positions: np.ndarray, labels: Sequence[str] = LABELS, fps: float = 60.0, unit: str = "mm") -> str:
    """A TRC file; gaps are empty fields."""
    frames, count = positions.shape[:2]
    lines = [
        "PathFileType\t4\t(X/Y/Z)\tclip.trc",
        "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames",
        f"{fps:g}\t{fps:g}\t{frames}\t{count}\t{unit}\t{fps:g}\t1\t{frames}",
        "Frame#\tTime\t" + "\t\t\t".join(labels) + "\t\t",
        "\t\t" + "\t".join(f"{axis}{k + 1}" for k in range(count) for axis in "XYZ"),
        "",
    ]
    for k, row in enumerate(positions.reshape(frames, 3 * positions.shape[1])):
        cells = ["" if np.isnan(value) else repr(float(value)) for value in row]
        lines.append("\t".join([str(k + 1), repr(k / fps), *cells]))
    return "\n".join(lines) + "\n"


def marker_text(
    positions: np.ndarray,
    labels: Sequence[str] = LABELS,
    separator: str = ",",
    form: str = "_x",
    gap: str = "NA",
    fps: float | None = 120.0,
    comma: bool = False,
) -> str:
    """A marker table; ``form`` is ``_x``, ``.X`` or ``rows`` (labels above X, Y, Z)."""
    frames = len(positions)
    first = ["Frame"] if fps is None else ["Frame", "Time"]
    lines = []
    if form == "rows":
        lines.append(separator.join([*[""] * len(first), *[c for label in labels for c in (label, "", "")]]))
        lines.append(separator.join([*first, *["X", "Y", "Z"] * len(labels)]))
    else:
        axes = "xyz" if form[1].islower() else "XYZ"
        lines.append(separator.join([*first, *[f"{label}{form[0]}{a}" for label in labels for a in axes]]))
    for k, row in enumerate(positions.reshape(frames, 3 * positions.shape[1])):
        cells = [str(k + 1), *([] if fps is None else [repr(k / fps)])]
        cells += [gap if np.isnan(value) else repr(float(value)) for value in row]
        text = separator.join(cells)
        lines.append(text.replace(".", ",") if comma else text)
    return "\n".join(lines) + "\n"


def pc2_bytes(vertices: np.ndarray, samples: int | None = None, rate: float = 1.0) -> bytes:
    """A PC2 mesh cache."""
    count = len(vertices) if samples is None else samples
    head = struct.pack("<12siiffi", b"POINTCACHE2\0", 1, vertices.shape[1], 0.0, rate, count)
    return head + vertices.astype("<f4").tobytes()


def npz_bytes(packed: bool = False, **arrays: object) -> bytes:
    """A NumPy archive."""
    stream = io.BytesIO()
    (np.savez_compressed if packed else np.savez)(stream, **arrays)  # type: ignore[arg-type]
    return stream.getvalue()


def animated_glb(
    times: np.ndarray, values: np.ndarray, names: Sequence[str] | None, form: str = "LINEAR", targets: int | None = None
) -> bytes:
    """A GLB of one triangle whose targets' weights are animated: ``values`` as the file holds them, flat."""
    count = targets if targets is not None else len(names or ())
    triangle = np.array([[0, 0, 0], [0.2, 0, 0], [0, 0.2, 0]], "<f4")
    arrays = [("VEC3", triangle), *[("VEC3", triangle * 0.01 * (k + 1)) for k in range(count)]]
    arrays += [("SCALAR", np.asarray(times, "<f4")), ("SCALAR", np.asarray(values, "<f4").ravel())]
    data, views, accessors = b"", [], []
    for kind, array in arrays:
        views.append({"buffer": 0, "byteOffset": len(data), "byteLength": array.nbytes})
        accessors.append(
            {"bufferView": len(views) - 1, "byteOffset": 0, "componentType": 5126, "count": len(array), "type": kind}
            | ({"min": array.min(axis=0).tolist(), "max": array.max(axis=0).tolist()} if kind == "VEC3" else {})
        )
        data += array.tobytes()
    mesh: dict[str, object] = {
        "primitives": [{"attributes": {"POSITION": 0}, "targets": [{"POSITION": 1 + k} for k in range(count)]}],
        "weights": [0.0] * count,
    }
    if names is not None:
        mesh["extras"] = {"targetNames": list(names)}
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [mesh],
        "animations": [
            {
                "channels": [{"sampler": 0, "target": {"node": 0, "path": "weights"}}],
                "samplers": [{"input": 1 + count, "output": 2 + count, "interpolation": form}],
            }
        ],
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": len(data)}],
    }
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    total = 28 + len(text) + len(data)
    return b"".join(
        (struct.pack("<4sII", b"glTF", 2, total), struct.pack("<I4s", len(text), b"JSON"), text,
         struct.pack("<I4s", len(data), b"BIN\0"), data)
    )  # fmt: skip


def live_link_text(frames: int = 20, skipped: Sequence[int] = (), fps: int = 30, base: int = 60) -> str:
    """A Live Link Face table: weights of three shapes; ``skipped`` frames are missing from the time code."""
    lines = ["Timecode,BlendShapeCount,EyeBlinkLeft,JawOpen,HeadYaw"]
    for k in range(frames):
        if k in skipped:
            continue
        count = 100 * base + k * base // fps
        seconds, frame = divmod(count, base)
        lines.append(f"10:{seconds // 60:02d}:{seconds % 60:02d}:{frame:02d}.250,3,{k / 100:.10f},{k / 50:.10f},-0.1")
    return "\n".join(lines) + "\n"


PAIRS = json.dumps({"pairs": [{"name": "a", "source": "nose", "target": 3}, {"source": "chin", "target": [1, 2, 3]}]})
