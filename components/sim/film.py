"""Images of a camera as one animated PNG, which browsers play and other programs show the first of.

https://www.w3.org/TR/png-3/ has the format.
"""

import struct
import zlib

_SIGNATURE = b"\x89PNG\r\n\x1a\n"
_RGB8 = (8, 2, 0, 0, 0)  # bits, colours, and the only methods there are


class Film:
    """Takes frames of one size, ``rgb8``."""

    def __init__(self, every: int) -> None:
        self._every = every  # ms
        self._size = (0, 0)
        self._frames: list = []

    def __len__(self) -> int:
        return len(self._frames)

    def take(self, frame) -> None:
        """Adds an image, a value of type ``images::frame``."""
        size = (frame.width, frame.height)
        if frame.encoding != "rgb8" or (self._frames and size != self._size):
            raise ValueError(f"not an image of this film: {frame.encoding}, {size}")
        self._size = size
        pixels, step = bytes(frame.data), frame.step
        # A row begins with its filter: none.
        rows = (b"\0" + pixels[at : at + step] for at in range(0, step * frame.height, step))
        self._frames.append(zlib.compress(b"".join(rows)))

    def save(self, path: str) -> None:
        """Writes the film, which is played over and over."""
        with open(path, "wb") as file:
            file.write(_SIGNATURE)
            file.write(_chunk(b"IHDR", struct.pack(">2I5B", *self._size, *_RGB8)))
            file.write(_chunk(b"acTL", struct.pack(">2I", len(self._frames), 0)))
            number = 0
            for at, frame in enumerate(self._frames):
                control = (number, *self._size, 0, 0, self._every, 1000, 0, 0)
                file.write(_chunk(b"fcTL", struct.pack(">5I2H2B", *control)))
                number += 1
                if at == 0:
                    file.write(_chunk(b"IDAT", frame))
                else:
                    file.write(_chunk(b"fdAT", struct.pack(">I", number) + frame))
                    number += 1
            file.write(_chunk(b"IEND", b""))


def _chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
