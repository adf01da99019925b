"""Size and soundness of an image file, found out before it is decoded.

A decoder allocates what the header asks for and reports damage on the process's standard error; so sizes are read,
checksums compared and the end looked for here first.
"""

from __future__ import annotations

import re
import struct
import zlib
from dataclasses import dataclass

from engine.errors import InputError
from engine.files.exr import EXR, ExrDamagedError, exr_size
from engine.files.source import MAX_PIXELS, check_pixels

_PNG = b"\x89PNG\r\n\x1a\n"
_PNM = re.compile(rb"P([56])(?:\s|#[^\n]*\n)+(\d{1,9})(?:\s|#[^\n]*\n)+(\d{1,9})(?:\s|#[^\n]*\n)+(\d{1,9})\s")
_MOST_PARTS = 100_000
_TIFF_NUMBERS = {1: "B", 3: "H", 4: "I"}
_TIFF_TAGS = {256, 257, 258, 273, 277, 279, 322, 323, 324, 325}
_TIFF_SIZES = {1: 1, 2: 1, 3: 2, 4: 4, 5: 8, 6: 1, 7: 1, 8: 2, 9: 4, 10: 8, 11: 4, 12: 8, 13: 4}


@dataclass(frozen=True)
class ImageHeader:
    """What an image file says of itself: its format and its size in pixels."""

    kind: str
    width: int
    height: int


def image_header(data: bytes, subject: str, largest: int = MAX_PIXELS) -> ImageHeader:
    """Return kind (``png``, ``jpeg``, ``tiff``, ``exr``, ``ppm``) and size of an image file that is whole.

    Parameters
    ----------
    data : bytes
        The file.
    subject : str
        The file's name, for the message.
    largest : int
        Most pixels that are accepted.

    Raises
    ------
    InputError
        On another format, a size beyond ``largest``, and on files that are cut off or damaged.
    """
    try:
        if data.startswith(_PNG):
            header = _png(data)
        elif data.startswith(b"\xff\xd8\xff"):
            header = _jpeg(data)
        elif data[:4] in (b"II*\0", b"MM\0*"):
            header = _tiff(data)
        elif data.startswith(EXR):
            header = ImageHeader("exr", *exr_size(data))
        elif match := _PNM.match(data, 0, 1024):
            header = _pnm(data, match)
        else:
            raise InputError(subject, "is not a PNG, JPEG, TIFF, EXR or binary PPM image", "export it as one of these")
    except (_DamagedError, ExrDamagedError, struct.error, IndexError) as error:
        problem = str(error) if isinstance(error, _DamagedError | ExrDamagedError) else "is cut off"
        raise InputError(subject, problem, "copy or export it again") from error
    check_pixels(subject, header.width, header.height, largest)
    if header.kind == "png":
        _check_png_data(data, header, subject)
    return header


class _DamagedError(Exception):
    pass


def _png(data: bytes) -> ImageHeader:
    width, height = struct.unpack_from(">II", data, 16)
    _png_chunks(data)
    return ImageHeader("png", width, height)


def _png_chunks(data: bytes) -> list[tuple[bytes, int, int]]:
    """Return (kind, start, stop) of every chunk's content; all checksums agree."""
    chunks: list[tuple[bytes, int, int]] = []
    position = len(_PNG)
    while True:
        length, kind = struct.unpack_from(">I4s", data, position)
        start, stop = position + 8, position + 8 + length
        (expected,) = struct.unpack_from(">I", data, stop) if stop + 4 <= len(data) else (None,)
        if expected is None:
            raise _DamagedError("is cut off")
        if zlib.crc32(memoryview(data)[position + 4 : stop]) != expected:
            raise _DamagedError("is damaged (a checksum does not agree)")
        if (not chunks) != (kind == b"IHDR") or (kind == b"IHDR" and length != 13):
            raise _DamagedError("is damaged (its header is not where it should be)")
        chunks.append((kind, start, stop))
        if len(chunks) > _MOST_PARTS:
            raise _DamagedError("is damaged (it is in too many pieces)")
        if kind == b"IEND":
            return chunks
        position = stop + 4


def _check_png_data(data: bytes, header: ImageHeader, subject: str) -> None:
    """Compare the unpacked length with the header's size, in pieces, so that neither a bomb nor a stub is decoded."""
    bits, colour, _, _, interlace = data[24:29]
    channels = {0: 1, 2: 3, 3: 1, 4: 2, 6: 4}.get(colour)
    if channels is None or bits not in (1, 2, 4, 8, 16):
        raise InputError(subject, "is not a PNG image that can be read", "export it again")
    if interlace:
        return
    expected = header.height * (1 + (header.width * channels * bits + 7) // 8)
    stream, length = zlib.decompressobj(), 0
    try:
        for kind, start, stop in _png_chunks(data):
            if kind == b"IDAT":
                piece: bytes = data[start:stop]
                while piece and length <= expected:
                    length += len(stream.decompress(piece, 1 << 20))
                    piece = stream.unconsumed_tail
    except zlib.error as error:
        raise InputError(subject, "is damaged (its data cannot be unpacked)", "copy or export it again") from error
    if length != expected:
        amount = f"{length} of" if length < expected else "more than"
        raise InputError(subject, f"holds {amount} the {expected} bytes it announces", "copy or export it again")


def _jpeg(data: bytes) -> ImageHeader:
    position, size = 2, None
    while True:
        while data[position] == 0xFF and data[position + 1] == 0xFF:
            position += 1
        if data[position] != 0xFF:
            raise _DamagedError("is damaged (a segment does not begin where it should)")
        marker = data[position + 1]
        (length,) = struct.unpack_from(">H", data, position + 2)
        if 0xC0 <= marker <= 0xCF and marker not in (0xC4, 0xC8, 0xCC):
            size = struct.unpack_from(">HH", data, position + 5)
        if length < 2 or position + 2 + length > len(data):
            raise _DamagedError("is cut off")
        position += 2 + length
        if marker == 0xDA:
            break
    if size is None:
        raise _DamagedError("is damaged (it states no size)")
    if data.rfind(b"\xff\xd9") < position:
        raise _DamagedError("is cut off")
    return ImageHeader("jpeg", size[1], size[0])


def _pnm(data: bytes, match: re.Match[bytes]) -> ImageHeader:
    kind, width, height, largest = (int(group) for group in match.groups())
    if not 0 < largest < 65536:
        raise _DamagedError("is damaged (its largest value is not 1 to 65535)")
    needed = width * height * (3 if kind == 6 else 1) * (2 if largest > 255 else 1)
    if needed > len(data) - match.end():
        raise _DamagedError("is cut off")
    return ImageHeader("ppm", width, height)


def _tiff(data: bytes) -> ImageHeader:
    order = "<" if data[:2] == b"II" else ">"
    (start,) = struct.unpack_from(order + "I", data, 4)
    (count,) = struct.unpack_from(order + "H", data, start)
    struct.unpack_from("4x", data, start + 2 + 12 * count)  # the place of a next directory ends this one
    tags: dict[int, list[int]] = {}
    for index in range(count):
        tag, kind, number = struct.unpack_from(order + "HHI", data, start + 2 + 12 * index)
        size = _TIFF_SIZES.get(kind, 1) * number
        place = start + 10 + 12 * index
        if size > 4:
            (place,) = struct.unpack_from(order + "I", data, place)
        if place + size > len(data):
            raise _DamagedError("is cut off")
        if tag in _TIFF_TAGS and kind in _TIFF_NUMBERS and number:
            if number > _MOST_PARTS:
                raise _DamagedError("is damaged (it is in too many pieces)")
            tags[tag] = list(struct.unpack_from(f"{order}{number}{_TIFF_NUMBERS[kind]}", data, place))
    width, height = tags.get(256, [0])[0], tags.get(257, [0])[0]
    for offsets, lengths in ((273, 279), (324, 325)):
        for offset, length in zip(tags.get(offsets, []), tags.get(lengths, []), strict=False):
            if offset + length > len(data):
                raise _DamagedError("is cut off")
    if max(tags.get(258, [1])) > 64 or tags.get(277, [1])[0] > 4:
        raise _DamagedError("is not a grey or colour image of at most 64 bits a channel")
    # A decoder reserves room for a whole tile, however small the image is.
    if tags.get(322, [0])[0] * tags.get(323, [0])[0] > 4 * width * height + (1 << 20):
        raise _DamagedError("is damaged (its tiles are larger than the image)")
    return ImageHeader("tiff", width, height)
